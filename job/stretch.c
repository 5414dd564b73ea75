// SPDX-License-Identifier: Apache-2.0
// Heights that follow the local stretch: a thickness for each part, the same on edges that parts share.
#include "job/internal.h"

#include <math.h>

// All coefficients of all parts' factors, one part after the other; those at one place of the base are one class.
typedef struct joined {
    size_t *parent;
    double *sum;
    size_t *members;
    size_t *first; // of each part
} joined;

static size_t root_of(const joined *j, size_t i)
{
    for (; j->parent[i] != i; i = j->parent[i]) j->parent[i] = j->parent[j->parent[i]];
    return i;
}

static void join(const joined *j, size_t a, size_t b)
{
    a = root_of(j, a), b = root_of(j, b);
    j->parent[a < b ? b : a] = a < b ? a : b;
}

// The place of coefficient k along an edge of part s; the edge has count[edge < 2] of them, or one for all.
static size_t on_edge(const joined *j, const kn_spline *h, int s, int edge, int k)
{
    if (h->count[edge < 2] == 1) k = 0;
    int fixed = edge >> 1, last = edge % 2 == 0 ? 0 : h->count[fixed] - 1;
    return j->first[s] + (size_t)(fixed == 0 ? last * h->count[1] + k : k * h->count[1] + last);
}

// An edge that is a point of S: all its coefficients were meant to be equal, and are but for rounding.
static bool one_value(const joined *j, const kn_spline *h, int s, int edge)
{
    double least = INFINITY, most = -INFINITY;
    for (int k = 0; k < h->count[edge < 2]; k++) {
        double x = h->coef[on_edge(j, h, s, edge, k) - j->first[s]];
        least = fmin(least, x), most = fmax(most, x);
    }
    return most - least <= 1e-12 * most;
}

static void join_edges(const joined *j, const kn_job *job, const kn_spline *h)
{
    for (int e = 0; e < 4 * job->nsurfaces; e++) {
        int s = e / 4, n = h[s].count[e % 4 < 2];
        const kn_job_partner *p = &job->surfaces[s].partner[e % 4];
        if (one_value(j, &h[s], s, e % 4))
            for (int k = 1; k < n; k++) join(j, on_edge(j, &h[s], s, e % 4, 0), on_edge(j, &h[s], s, e % 4, k));
        int other = p->edge < 0 ? 0 : h[p->edge / 4].count[p->edge % 4 < 2];
        if (other != n && (other == 0 || (other > 1 && n > 1))) continue;
        n = n > other ? n : other;
        for (int k = 0; k < n; k++)
            join(j, on_edge(j, &h[s], s, e % 4, k),
                 on_edge(j, &h[p->edge / 4], p->edge / 4, p->edge % 4, p->reversed ? n - 1 - k : k));
    }
}

static const double least_stretch = 0.2497; // (cells.h)

// Classes take their means, and none is below half of what the stretch can be: so h stays positive. change[s] = the
// most that a coefficient of part s has moved.
static void take_means(const joined *j, double *change, kn_spline *h, int n)
{
    for (size_t i = 0; i < j->first[n]; i++) j->sum[i] = 0.0, j->members[i] = 0;
    for (int s = 0; s < n; s++)
        for (size_t i = j->first[s]; i < j->first[s + 1]; i++) {
            j->sum[root_of(j, i)] += h[s].coef[i - j->first[s]];
            j->members[root_of(j, i)]++;
        }
    for (int s = 0; s < n; s++) {
        change[s] = 0.0;
        for (size_t i = j->first[s]; i < j->first[s + 1]; i++) {
            double *x = &h[s].coef[i - j->first[s]], mean = *x;
            if (j->members[root_of(j, i)] > 1) mean = j->sum[root_of(j, i)] / (double)j->members[root_of(j, i)];
            mean = fmax(mean, 0.5 * least_stretch);
            change[s] = fmax(change[s], fabs(mean - *x));
            *x = mean;
        }
    }
}

static kn_status meet(kn_ctx *ctx, double *change, kn_spline *h, const kn_job *job)
{
    int n = job->nsurfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    joined j = {.first = kn_scratch(ctx, (size_t)n + 1, sizeof *j.first)};
    if (j.first) j.first[0] = 0;
    for (int s = 0; j.first && s < n; s++) j.first[s + 1] = j.first[s] + kn_spline_count(&h[s]);
    if (j.first) {
        j.parent = kn_scratch(ctx, j.first[n], sizeof *j.parent);
        j.sum = kn_scratch(ctx, j.first[n], sizeof *j.sum);
        j.members = kn_scratch(ctx, j.first[n], sizeof *j.members);
    }
    bool room = j.parent && j.sum && j.members;
    for (size_t i = 0; room && i < j.first[n]; i++) j.parent[i] = i;
    if (room) {
        join_edges(&j, job, h);
        take_means(&j, change, h, n);
    }
    kn_scratch_release(ctx, mark);
    return room ? KN_OK : KN_ENOMEM;
}

// What max_degree leaves for the sum of h's degrees beside a normal of the least degrees, 3 and 3.
static int room_for_degrees(const kn_job *job, const kn_job_base *b, const kn_spline *face)
{
    int n = b->direction.coef ? b->direction.degree[0] + b->direction.degree[1] : 6;
    int own = b->thickness.coef ? b->thickness.degree[0] + b->thickness.degree[1] : 0;
    int weight = face->rational ? face->degree[0] + face->degree[1] : 0;
    return job->options.max_degree / kn_job_tile_degree(job) - (n + 1 + weight + own);
}

// C1 where there is room for it, else bilinear.
static int choose_degree(const kn_job *job, const kn_job_bases *bases)
{
    int degree = 2;
    for (int s = 0; s < bases->n; s++)
        if (room_for_degrees(job, &bases->list[s], &bases->faces[s]) < 4) degree = 1;
    return degree;
}

// Where there is no room for that either, h is taken along the one variable in which it varies more. error: what that
// changes is added.
static kn_status lower(kn_ctx *ctx, double *error, kn_spline *h, const kn_job *job, const kn_job_bases *bases)
{
    kn_status status = KN_OK;
    for (int s = 0; status == KN_OK && s < bases->n; s++) {
        if (room_for_degrees(job, &bases->list[s], &bases->faces[s]) >= h[s].degree[0] + h[s].degree[1]) continue;
        const double varies[2] = {kn_job_field_variation(&h[s], 0), kn_job_field_variation(&h[s], 1)};
        int v = varies[0] <= varies[1] ? 0 : 1;
        status = kn_job_lower_field(ctx, &h[s], v);
        error[s] += 0.5 * varies[v] / least_stretch * (1.0 + 0x1p-40);
    }
    return status;
}

// *most: the largest factor.
static kn_status apply(kn_ctx *ctx, double *most, kn_job_bases *bases, kn_spline *h)
{
    kn_status status = KN_OK;
    for (int s = 0; status == KN_OK && s < bases->n; s++) {
        kn_spline *t = &bases->list[s].thickness;
        for (size_t i = 0; i < kn_spline_count(&h[s]); i++) *most = fmax(*most, h[s].coef[i]);
        if (t->coef)
            status = kn_spline_product(ctx, t, t, &h[s]);
        else
            kn_spline_swap(t, &h[s]);
    }
    return status;
}

// h is no one polynomial across cell lines, and T with it.
static void mark_knots(kn_job *job, const kn_spline *h)
{
    for (int i = 0; i < job->nsurfaces; i++)
        for (int d = 0; d < 2; d++)
            for (int k = 0; h[i].degree[d] > 0 && k <= job->surfaces[i].cells[d]; k++)
                job->surfaces[i].knot[d][k] = true;
}

kn_status kn_job_stretch(kn_ctx *ctx, kn_job *job, kn_job_bases *bases)
{
    size_t n = (size_t)bases->n;
    double most = 0.0, *error = kn_alloc(ctx, n, sizeof *error), *change = kn_alloc(ctx, n, sizeof *change);
    kn_spline *h = kn_alloc_zero(ctx, n, sizeof *h);
    kn_cells_stretch_options o = {.mean = job->report.spread.area.mean, .degree = choose_degree(job, bases)};
    kn_status status = h && error && change ? KN_OK : KN_ENOMEM;
    if (status == KN_OK && bases->list[0].volume.coef)
        status = kn_fail(ctx, KN_EDOMAIN, "job: a volume has its own heights, which cannot follow the stretch");
    for (size_t s = 0; status == KN_OK && s < n; s++) {
        const kn_job_surface *at = &job->surfaces[s];
        const double *const lines[2] = {at->lines[0], at->lines[1]};
        const int nlines[2] = {at->cells[0] + 1, at->cells[1] + 1};
        status = kn_cells_stretch(ctx, &h[s], &error[s], &bases->faces[s], lines, nlines, &o);
    }
    if (status == KN_OK) status = lower(ctx, error, h, job, bases);
    if (status == KN_OK) status = meet(ctx, change, h, job);
    for (size_t s = 0; status == KN_OK && s < n; s++) {
        error[s] += change[s] / least_stretch * (1.0 + 0x1p-40);
        job->report.stretch_error = fmax(job->report.stretch_error, error[s]);
    }
    if (status == KN_OK) mark_knots(job, h);
    if (status == KN_OK) status = apply(ctx, &most, bases, h);
    if (status == KN_OK) job->w_length *= most;
    for (size_t s = 0; h && s < n; s++) kn_spline_clear(ctx, &h[s]);
    kn_free(ctx, h);
    kn_free(ctx, error);
    kn_free(ctx, change);
    return status;
}
