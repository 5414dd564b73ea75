// SPDX-License-Identifier: Apache-2.0
// Centres of tiles that are scattered over a base at a least distance: a Poisson-disk set, near to maximal.
//
// The base is cut into boxes of (u,v) not wider than the distance. In each round one dart is thrown into every box
// that is left, in the order of a hash of the box; it stays when no other centre is within the distance in space.
// Boxes that lie in the ball of one centre are then gone, the others are halved each way. Darts are hashed from the
// seed and the box, so that nothing depends on threads; distances are taken in space, so that seams, shared edges and
// the two sides of a fold need no care.
// Source: Ebeida, Mitchell, Patney, Davidson & Owens, A simple algorithm for maximal Poisson-disk sampling in high
// dimensions, CGF 31 (2012).
#include "job/placement.h"
#include "kernel/hash.h"

#include <math.h>
#include <stdlib.h>

enum {
    LEVELS = 7,            // boxes end at 1/64 of the first ones' sides
    MAX_BOXES = 1 << 22,   // at the start
    CHECKED_AT_ONCE = 4096 // boxes between two looks at progress
};

typedef struct box {
    int surface;
    uint32_t at[2]; // of the boxes of its level
    uint64_t order;
    double uv[2], p[3];
} box;

// Centres so far, in a hash grid whose meshes are as wide as the distance.
typedef struct centre {
    int surface;
    double uv[2], p[3];
    uint32_t next; // 1 + index of the next one in its bucket; 0: none
} centre;

typedef struct scatter {
    const kn_job *job;
    uint64_t seed;
    double distance;
    uint32_t (*count)[2]; // first boxes of each surface, each way
    double (*lo)[2], (*hi)[2];
    box *boxes;
    size_t nboxes;
    int level;
    centre *centres;
    size_t ncentres, room;
    uint32_t *bucket; // nbuckets, a power of two
    size_t nbuckets;
    double *at, *value; // for one batch of evaluation: 2 and 9 numbers for each box
} scatter;

// ---- the hash grid ----

static size_t bucket_of(const scatter *s, const double p[3], const int step[3])
{
    uint64_t h = 0;
    for (int c = 0; c < 3; c++) h = kn_hash_add(h, (uint64_t)(int64_t)(floor(p[c] / s->distance) + step[c]));
    return (size_t)h & (s->nbuckets - 1);
}

static double square_distance(const double *p, const double *q)
{
    double d[3] = {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

// Whether a centre is nearer to p than `radius`, which is at most the distance.
static bool is_near(const scatter *s, const double p[3], double radius)
{
    for (int k = 0; k < 27; k++) {
        const int step[3] = {k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1};
        for (uint32_t i = s->bucket[bucket_of(s, p, step)]; i > 0; i = s->centres[i - 1].next)
            if (square_distance(p, s->centres[i - 1].p) < radius * radius) return true;
    }
    return false;
}

static void enter(scatter *s, size_t index)
{
    const int here[3] = {0, 0, 0};
    uint32_t *head = &s->bucket[bucket_of(s, s->centres[index].p, here)];
    s->centres[index].next = *head;
    *head = (uint32_t)index + 1;
}

static kn_status grow(kn_ctx *ctx, scatter *s)
{
    size_t room = s->room > 0 ? 2 * s->room : 256;
    centre *list = kn_resize(ctx, s->centres, room, sizeof *list);
    if (!list) return KN_ENOMEM;
    s->centres = list;
    s->room = room;
    uint32_t *bucket = kn_alloc_zero(ctx, 2 * room, sizeof *bucket);
    if (!bucket) return KN_ENOMEM;
    kn_free(ctx, s->bucket);
    s->bucket = bucket;
    s->nbuckets = 2 * room;
    for (size_t i = 0; i < s->ncentres; i++) enter(s, i);
    return KN_OK;
}

static kn_status add(kn_ctx *ctx, scatter *s, const box *b)
{
    if (s->ncentres == s->room) {
        kn_status status = grow(ctx, s);
        if (status != KN_OK) return status;
    }
    s->centres[s->ncentres] = (centre){b->surface, {b->uv[0], b->uv[1]}, {b->p[0], b->p[1], b->p[2]}, 0};
    enter(s, s->ncentres++);
    return KN_OK;
}

// ---- boxes ----

static double side(const scatter *s, const box *b, int d)
{
    return (s->hi[b->surface][d] - s->lo[b->surface][d]) / ldexp(s->count[b->surface][d], s->level);
}

// The point of a box at x in [0,1]^2, in S's parameters.
static void parameters(double uv[2], const scatter *s, const box *b, const double x[2])
{
    for (int d = 0; d < 2; d++)
        uv[d] = fmin(s->lo[b->surface][d] + (b->at[d] + x[d]) * side(s, b, d), s->hi[b->surface][d]);
}

// The first boxes: sides of at most distance / sqrt 2 by the longest of three lines each way.
static kn_status first_boxes(kn_ctx *ctx, scatter *s)
{
    const kn_job *job = s->job;
    double sum = 0.0;
    for (int i = 0; i < job->nsurfaces; i++) {
        const kn_spline *surface = kn_shell_surface(job->surfaces[i].shell);
        kn_job_measure m;
        kn_status status = kn_job_measure_surface(ctx, &m, surface);
        if (status != KN_OK) return status;
        double n[2];
        for (int d = 0; d < 2; d++) {
            n[d] = fmax(ceil(fmax(m.length[d][0], fmax(m.length[d][1], m.length[d][2])) * sqrt(2.0) / s->distance),
                        1.0);
            kn_spline_domain(surface, d, &s->lo[i][d], &s->hi[i][d]);
        }
        sum += n[0] * n[1];
        if (!(sum <= MAX_BOXES))
            return kn_fail(ctx, KN_ELIMIT, "job: tiles scattered %g apart would be some %.3g and more", s->distance,
                           sum / 2.0);
        for (int d = 0; d < 2; d++) s->count[i][d] = (uint32_t)n[d];
    }
    s->nboxes = (size_t)sum;
    s->boxes = kn_alloc(ctx, s->nboxes, sizeof *s->boxes);
    if (!s->boxes) return KN_ENOMEM;
    size_t k = 0;
    for (int i = 0; i < job->nsurfaces; i++)
        for (uint32_t a = 0; a < s->count[i][0]; a++)
            for (uint32_t b = 0; b < s->count[i][1]; b++) s->boxes[k++] = (box){.surface = i, .at = {a, b}};
    return KN_OK;
}

// Boxes follow one another by surface: as many as one surface has of those from `first`.
static size_t batch_of(const scatter *s, size_t first)
{
    size_t n = 1;
    while (n < CHECKED_AT_ONCE && first + n < s->nboxes && s->boxes[first + n].surface == s->boxes[first].surface)
        n++;
    return n;
}

static int compare_order(const void *a, const void *b)
{
    const box *x = a, *y = b;
    if (x->order != y->order) return x->order < y->order ? -1 : 1;
    if (x->surface != y->surface) return x->surface < y->surface ? -1 : 1;
    if (x->at[0] != y->at[0]) return x->at[0] < y->at[0] ? -1 : 1;
    return (x->at[1] > y->at[1]) - (x->at[1] < y->at[1]);
}

static int compare_surface(const void *a, const void *b)
{
    const box *x = a, *y = b;
    if (x->surface != y->surface) return x->surface < y->surface ? -1 : 1;
    return compare_order(a, b);
}

static kn_status throw_darts(kn_ctx *ctx, scatter *s)
{
    kn_status status = KN_OK;
    for (size_t i = 0, n; status == KN_OK && i < s->nboxes; i += n) {
        n = batch_of(s, i);
        for (size_t k = 0; k < n; k++) {
            box *b = &s->boxes[i + k];
            uint64_t h = kn_hash_add(kn_hash_add(s->seed, (uint64_t)s->level), (uint64_t)b->surface);
            h = kn_hash_add(h, (uint64_t)b->at[0] << 32 | b->at[1]);
            b->order = h;
            double x[2] = {kn_hash_unit(kn_hash_add(h, 1)), kn_hash_unit(kn_hash_add(h, 2))};
            parameters(b->uv, s, b, x);
            for (int d = 0; d < 2; d++) s->at[2 * k + (size_t)d] = b->uv[d];
        }
        const kn_spline *surface = kn_shell_surface(s->job->surfaces[s->boxes[i].surface].shell);
        status = kn_spline_eval_batch(ctx, s->value, surface, n, s->at);
        for (size_t k = 0; status == KN_OK && k < n; k++)
            for (int c = 0; c < 3; c++) s->boxes[i + k].p[c] = s->value[3 * k + (size_t)c];
    }
    if (status != KN_OK) return status;
    qsort(s->boxes, s->nboxes, sizeof *s->boxes, compare_order);
    for (size_t i = 0; status == KN_OK && i < s->nboxes; i++) {
        if (!is_near(s, s->boxes[i].p, s->distance)) status = add(ctx, s, &s->boxes[i]);
        if (status == KN_OK && i % CHECKED_AT_ONCE == 0)
            status = kn_progress(ctx, "scatter", (s->level + (double)i / (double)s->nboxes) / LEVELS);
    }
    qsort(s->boxes, s->nboxes, sizeof *s->boxes, compare_surface);
    return status;
}

// Drops the boxes of one surface from `first` that the ball of one centre covers, by the partial derivatives in the
// middle, and appends the quarters of the others to *to.
static kn_status divide(kn_ctx *ctx, scatter *s, size_t first, size_t n, box *to, size_t *nto)
{
    static const double middle[2] = {0.5, 0.5};
    for (size_t k = 0; k < n; k++) parameters(&s->at[2 * k], s, &s->boxes[first + k], middle);
    const kn_spline *surface = kn_shell_surface(s->job->surfaces[s->boxes[first].surface].shell);
    kn_status status = kn_spline_eval_batch_partials(ctx, s->value, surface, n, s->at);
    for (size_t k = 0; status == KN_OK && k < n; k++) {
        const box *b = &s->boxes[first + k];
        const double *p = &s->value[9 * k], zero[3] = {0.0, 0.0, 0.0};
        double reach = 0.0;
        for (int d = 0; d < 2; d++) reach += 0.5 * side(s, b, d) * sqrt(square_distance(p + 3 + 3 * d, zero));
        double ball = s->distance - 1.05 * reach; // S bends
        if (ball > 0.0 && is_near(s, p, ball)) continue;
        for (uint32_t q = 0; q < 4; q++) {
            box quarter = *b;
            quarter.at[0] = 2 * b->at[0] + q / 2, quarter.at[1] = 2 * b->at[1] + q % 2;
            to[(*nto)++] = quarter;
        }
    }
    return status;
}

static kn_status refine(kn_ctx *ctx, scatter *s)
{
    size_t nto = 0;
    box *to = kn_alloc(ctx, 4 * s->nboxes, sizeof *to);
    kn_status status = to ? KN_OK : KN_ENOMEM;
    for (size_t i = 0, n; status == KN_OK && i < s->nboxes; i += n) {
        n = batch_of(s, i);
        status = divide(ctx, s, i, n, to, &nto);
    }
    if (status == KN_OK) {
        kn_free(ctx, s->boxes);
        s->boxes = to;
        s->nboxes = nto;
        s->level++;
    } else {
        kn_free(ctx, to);
    }
    return status;
}

// ---- cells ----

static int compare_darts(const void *a, const void *b)
{
    const kn_job_dart *x = a, *y = b;
    if (x->cell != y->cell) return x->cell < y->cell ? -1 : 1;
    if (x->at[0] != y->at[0]) return x->at[0] < y->at[0] ? -1 : 1;
    return (x->at[1] > y->at[1]) - (x->at[1] < y->at[1]);
}

// The cell in which a parameter lies, and where in it.
static int find_line(double *part, const double *line, int cells, double t)
{
    int lo = 0, hi = cells;
    while (hi - lo > 1) {
        int middle = lo + (hi - lo) / 2;
        *(t < line[middle] ? &hi : &lo) = middle;
    }
    *part = (t - line[lo]) / (line[lo + 1] - line[lo]);
    return lo;
}

static kn_status take_darts(kn_ctx *ctx, kn_job *job, const scatter *s)
{
    kn_job_dart *darts = kn_alloc(ctx, s->ncentres, sizeof *darts);
    if (!darts) return KN_ENOMEM;
    for (size_t k = 0; k < s->ncentres; k++) {
        const centre *c = &s->centres[k];
        const kn_job_surface *surface = &job->surfaces[c->surface];
        int at[2];
        for (int d = 0; d < 2; d++)
            at[d] = find_line(&darts[k].at[d], surface->lines[d], surface->cells[d], c->uv[d]);
        darts[k].cell = surface->first_cell + (size_t)at[0] * (size_t)surface->cells[1] + (size_t)at[1];
    }
    qsort(darts, s->ncentres, sizeof *darts, compare_darts);
    job->darts = darts;
    job->ndarts = s->ncentres;
    return KN_OK;
}

kn_status kn_job_scatter_tiles(kn_ctx *ctx, kn_job *job)
{
    const kn_job_scatter *o = &job->options.placement.scatter;
    if (o->distance == 0.0) return KN_OK;
    size_t n = (size_t)job->nsurfaces;
    scatter s = {.job = job, .seed = kn_hash_mix(o->seed), .distance = o->distance};
    s.count = kn_alloc(ctx, n, sizeof *s.count);
    s.lo = kn_alloc(ctx, n, sizeof *s.lo);
    s.hi = kn_alloc(ctx, n, sizeof *s.hi);
    s.at = kn_alloc(ctx, 2 * (size_t)CHECKED_AT_ONCE, sizeof *s.at);
    s.value = kn_alloc(ctx, 9 * (size_t)CHECKED_AT_ONCE, sizeof *s.value);
    kn_status status = s.count && s.lo && s.hi && s.at && s.value ? grow(ctx, &s) : KN_ENOMEM;
    if (status == KN_OK) status = first_boxes(ctx, &s);
    while (status == KN_OK && s.nboxes > 0) {
        status = throw_darts(ctx, &s);
        if (s.level + 1 == LEVELS) break;
        if (status == KN_OK) status = refine(ctx, &s);
    }
    if (status == KN_OK) status = take_darts(ctx, job, &s);
    kn_free(ctx, s.count);
    kn_free(ctx, s.lo);
    kn_free(ctx, s.hi);
    kn_free(ctx, s.at);
    kn_free(ctx, s.value);
    kn_free(ctx, s.boxes);
    kn_free(ctx, s.centres);
    kn_free(ctx, s.bucket);
    return status;
}

size_t kn_job_first_dart(const kn_job *job, size_t cell)
{
    size_t lo = 0, hi = job->ndarts;
    while (lo < hi) {
        size_t middle = lo + (hi - lo) / 2;
        if (job->darts[middle].cell < cell)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}
