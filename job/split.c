// SPDX-License-Identifier: Apache-2.0
// The surfaces of a job: what is left of the bases between their creases, each with its part of the fields.
//
// A part is an origin and a box of it, on the grid that the cuts through the origin make. Further cuts are further
// steps: each replaces a part by several (job_rows.c).
#include "job/internal.h"

#include <math.h>
#include <string.h>

// ---- checks ----

static kn_status check_field(kn_ctx *ctx, const kn_spline *f, int dim, const char *name)
{
    if (!f) return KN_OK;
    kn_status status = kn_spline_check(ctx, f);
    if (status != KN_OK) return status;
    bool unit = f->nvars == 2;
    for (int v = 0; v < 2 && unit; v++) {
        double lo, hi;
        kn_spline_domain(f, v, &lo, &hi);
        unit = lo == 0.0 && hi == 1.0;
    }
    if (!unit || f->ncomp != dim || f->rational)
        return kn_fail(ctx, KN_EDOMAIN, "job: the %s is to be a polynomial over [0,1]^2 of %d components", name, dim);
    return KN_OK;
}

kn_status kn_job_check_bases(kn_ctx *ctx, const kn_spline *surfaces, int nsurfaces, const kn_job_options *o)
{
    if (nsurfaces < 1) return kn_fail(ctx, KN_EDOMAIN, "job: %d surfaces", nsurfaces);
    kn_status status = KN_OK;
    int volumes = 0;
    for (int s = 0; status == KN_OK && s < nsurfaces; s++) {
        int nvars = surfaces[s].nvars;
        volumes += nvars == 3;
        if ((nvars != 2 && nvars != 3) || kn_spline_dim(&surfaces[s]) != 3)
            return kn_fail(ctx, KN_EDOMAIN, "job: surface %d has %d variables, %d components", s, nvars,
                           kn_spline_dim(&surfaces[s]));
        status = kn_spline_check(ctx, &surfaces[s]);
    }
    if (status == KN_OK) status = check_field(ctx, o->thickness, 1, "thickness");
    if (status == KN_OK) status = check_field(ctx, o->direction, 3, "direction");
    if (status == KN_OK) status = check_field(ctx, o->attraction, 3, "attraction");
    if (status != KN_OK) return status;
    if (volumes > 0 && volumes < nsurfaces)
        return kn_fail(ctx, KN_EDOMAIN, "job: %d volumes among %d surfaces", volumes, nsurfaces);
    if (volumes > 0 && (o->thickness || o->direction || o->attraction))
        return kn_fail(ctx, KN_EDOMAIN, "job: a volume has its own thickness and direction, and no attraction");
    if (o->attraction_power < 0 || o->attraction_power > KN_MAX_DEGREE)
        return kn_fail(ctx, o->attraction_power < 0 ? KN_EDOMAIN : KN_ELIMIT, "job: attraction with w^%d",
                       o->attraction_power);
    return KN_OK;
}

// ---- parts ----

static void base_clear(kn_ctx *ctx, kn_job_base *b)
{
    kn_spline_clear(ctx, &b->volume);
    kn_spline_clear(ctx, &b->thickness);
    kn_spline_clear(ctx, &b->direction);
    kn_spline_clear(ctx, &b->attraction);
}

void kn_job_bases_clear(kn_ctx *ctx, kn_job_bases *bases)
{
    for (int i = 0; i < bases->n; i++) {
        base_clear(ctx, &bases->list[i]);
        kn_spline_clear(ctx, &bases->faces[i]);
    }
    kn_free(ctx, bases->list);
    kn_free(ctx, bases->faces);
    *bases = (kn_job_bases){0};
}

static kn_status reserve(kn_ctx *ctx, kn_job_bases *bases)
{
    if (bases->n < bases->room) return KN_OK;
    size_t room = bases->room > 0 ? 2 * (size_t)bases->room : 8;
    kn_job_base *list = kn_resize(ctx, bases->list, room, sizeof *list);
    if (!list) return KN_ENOMEM;
    bases->list = list;
    kn_spline *faces = kn_resize(ctx, bases->faces, room, sizeof *faces);
    if (!faces) return KN_ENOMEM;
    bases->faces = faces;
    bases->room = (int)room;
    return KN_OK;
}

// The knots of f inside its domain become knots of the face; those within rounding of one are that one (shell.h).
static kn_status insert_knots_of(kn_ctx *ctx, kn_spline *face, const kn_spline *f)
{
    kn_status status = KN_OK;
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        int n = f->count[v] + f->degree[v] + 1, more = 0, last = face->count[v] + face->degree[v];
        const double *k = face->knots[v];
        double close = 0x1p-48 * (fabs(k[0]) + fabs(k[last]));
        kn_mark mark = kn_scratch_mark(ctx);
        double *x = kn_scratch(ctx, (size_t)n, sizeof *x);
        if (!x) return KN_ENOMEM;
        for (int i = 0, j = 0; i < n; i++) {
            double t = f->knots[v][i];
            while (j < last && k[j] < t - close) j++;
            if (fabs(k[j] - t) > close && (more == 0 || x[more - 1] != t)) x[more++] = t;
        }
        if (more > 0) status = kn_spline_insert_knots(ctx, face, face, v, x, more);
        kn_scratch_release(ctx, mark);
    }
    return status;
}

// The field over the part: [0,1]^2 stands for the origin's domain.
static kn_status take_field(kn_ctx *ctx, kn_spline *out, kn_spline *face, const kn_spline *field,
                            const kn_spline *origin)
{
    if (!field) return KN_OK;
    double lo[2], hi[2];
    kn_status status = kn_spline_copy(ctx, out, field);
    for (int v = 0; v < 2 && status == KN_OK; v++)
        if (kn_job_field_variation(out, v) == 0.0) status = kn_job_lower_field(ctx, out, v);
    for (int v = 0; v < 2 && status == KN_OK; v++) {
        kn_spline_domain(origin, v, &lo[v], &hi[v]);
        status = kn_spline_reparameterize(ctx, out, out, v, lo[v], hi[v]);
        kn_spline_domain(face, v, &lo[v], &hi[v]);
    }
    if (status == KN_OK) status = kn_spline_restrict(ctx, out, out, lo, hi);
    return status == KN_OK ? insert_knots_of(ctx, face, out) : status;
}

// Appends the part of an origin that `face` is; takes its contents.
static kn_status add_part(kn_ctx *ctx, kn_job_bases *bases, kn_spline *face, const kn_job_options *o,
                          const kn_spline *origin, const kn_job_base *place)
{
    kn_job_base b = *place;
    kn_status status = reserve(ctx, bases);
    if (status == KN_OK) status = take_field(ctx, &b.thickness, face, o->thickness, origin);
    if (status == KN_OK) status = take_field(ctx, &b.direction, face, o->direction, origin);
    if (status == KN_OK) status = take_field(ctx, &b.attraction, face, o->attraction, origin);
    if (status != KN_OK) {
        base_clear(ctx, &b);
        return status;
    }
    bases->list[bases->n] = b;
    bases->faces[bases->n] = *face;
    bases->n++;
    *face = (kn_spline){0};
    return KN_OK;
}

// A direction goes on over a crease, and so does T.
static kn_status add_surface(kn_ctx *ctx, kn_job_bases *bases, const kn_job_options *o, const kn_spline *surface,
                             int origin)
{
    kn_spline *pieces = NULL;
    int counts[2] = {1, 1};
    kn_status status = KN_OK;
    if (o->direction) {
        pieces = kn_alloc_zero(ctx, 1, sizeof *pieces);
        status = pieces ? kn_spline_copy(ctx, pieces, surface) : KN_ENOMEM;
    } else {
        // n is joined where both sides agree to a tenth of its tolerance (shell.h); nothing below this is decidable
        status = kn_shell_split_creases(ctx, &pieces, counts, surface, fmax(0.1 * o->normal_tol, 1e-11));
    }
    for (int i = 0; pieces && i < counts[0] * counts[1]; i++) {
        kn_job_base place = {
            .origin = origin, .part = {i / counts[1], i % counts[1]}, .parts = {counts[0], counts[1]}};
        if (status == KN_OK) status = add_part(ctx, bases, &pieces[i], o, surface, &place);
        kn_spline_clear(ctx, &pieces[i]);
    }
    kn_free(ctx, pieces);
    return status;
}

static kn_status add_volume(kn_ctx *ctx, kn_job_bases *bases, const kn_spline *volume, int origin)
{
    kn_job_base b = {.origin = origin, .parts = {1, 1}};
    kn_spline face = {0};
    kn_status status = reserve(ctx, bases);
    if (status == KN_OK) status = kn_spline_reparameterize(ctx, &b.volume, volume, 2, 0.0, 1.0);
    if (status == KN_OK) status = kn_spline_isoparametric(ctx, &face, &b.volume, 2, 0.5);
    if (status != KN_OK) {
        kn_spline_clear(ctx, &b.volume);
        return status;
    }
    bases->list[bases->n] = b;
    bases->faces[bases->n++] = face;
    return KN_OK;
}

// ---- the length of w = 1 ----

// Of a volume the longest of nine fibres.
static kn_status fibre_length(kn_ctx *ctx, double *length, const kn_spline *volume)
{
    for (int i = 0; i < 9; i++) {
        double at[3], p[2][3], square = 0.0;
        for (int v = 0; v < 2; v++) {
            double lo, hi;
            kn_spline_domain(volume, v, &lo, &hi);
            at[v] = lo + 0.5 * (v == 0 ? i / 3 : i % 3) * (hi - lo);
        }
        for (int k = 0; k < 2; k++) {
            at[2] = k;
            kn_status status = kn_spline_eval(ctx, p[k], volume, at);
            if (status != KN_OK) return status;
        }
        for (int c = 0; c < 3; c++) square += (p[1][c] - p[0][c]) * (p[1][c] - p[0][c]);
        *length = fmax(*length, sqrt(square));
    }
    return KN_OK;
}

static kn_status measure_w(kn_ctx *ctx, double *length, const kn_job_options *o, const kn_job_bases *bases)
{
    double h = 0.0, d = 0.0;
    kn_status status = KN_OK;
    *length = 0.0;
    if (bases->list[0].volume.coef) {
        for (int i = 0; i < bases->n && status == KN_OK; i++)
            status = fibre_length(ctx, length, &bases->list[i].volume);
        return status;
    }
    size_t nh = o->thickness ? kn_spline_count(o->thickness) : 0,
           nd = o->direction ? kn_spline_count(o->direction) : 0;
    for (size_t i = 0; i < nh; i++) h = fmax(h, fabs(o->thickness->coef[i]));
    for (size_t i = 0; i < nd; i++) {
        const double *c = o->direction->coef + i;
        d = fmax(d, hypot(hypot(c[0], c[nd]), c[2 * nd]));
    }
    *length = (nh > 0 ? h : 1.0) * (nd > 0 ? d : 1.0);
    return KN_OK;
}

// ---- the whole ----

kn_status kn_job_split(kn_ctx *ctx, kn_job_bases *bases, kn_job *job, const kn_spline *surfaces, int nsurfaces)
{
    kn_job_options *o = &job->options;
    kn_status status = KN_OK;
    for (int s = 0; s < nsurfaces && status == KN_OK; s++)
        status = surfaces[s].nvars == 3 ? add_volume(ctx, bases, &surfaces[s], s)
                                        : add_surface(ctx, bases, o, &surfaces[s], s);
    for (int i = 0; i < bases->n && o->bodies; i++) bases->list[i].body = o->bodies[bases->list[i].origin];
    if (status == KN_OK && o->rows) status = kn_job_cut_rows(ctx, bases, job);
    if (status == KN_OK) status = measure_w(ctx, &job->w_length, o, bases);
    if (status == KN_OK) job->surfaces = kn_alloc_zero(ctx, (size_t)bases->n, sizeof *job->surfaces);
    if (status == KN_OK && !job->surfaces) status = KN_ENOMEM;
    if (status != KN_OK) return status;
    job->nsurfaces = bases->n;
    job->report.nsurfaces = nsurfaces;
    job->report.nparts = bases->n;
    for (int i = 0; i < bases->n; i++) {
        const kn_job_base *b = &bases->list[i];
        job->surfaces[i].origin = b->origin, job->surfaces[i].body = b->body;
        for (int v = 0; v < 2; v++) {
            job->surfaces[i].part[v] = b->part[v], job->surfaces[i].parts[v] = b->parts[v];
            job->surfaces[i].count[v] = b->count[v];
            double end[2], all[2];
            kn_spline_domain(&bases->faces[i], v, &end[0], &end[1]);
            kn_spline_domain(&surfaces[b->origin], v, &all[0], &all[1]);
            for (int e = 0; e < 2; e++)
                job->surfaces[i].box[e][v] = end[e] == all[1] ? 1.0 : (end[e] - all[0]) / (all[1] - all[0]);
        }
    }
    if (bases->list[0].volume.coef && o->height == 0.0) o->height = 1.0;
    return KN_OK;
}

// ---- counts and numbers of cells ----

kn_status kn_job_share_count(kn_ctx *ctx, int (*counts)[2], const kn_job *job, int first, int along, int count,
                             const kn_spline *faces, const kn_job_measure *measures)
{
    const kn_job_surface *s = job->surfaces + first;
    int n = s->parts[along], step = along == 0 ? s->parts[1] : 1, total = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *length = kn_scratch(ctx, (size_t)n, sizeof *length);
    int *share = kn_scratch(ctx, (size_t)n, sizeof *share);
    kn_status status = length && share ? KN_OK : KN_ENOMEM;
    for (int i = 0; i < n && status == KN_OK; i++) {
        int at = first + i * step;
        double lo, hi;
        kn_spline_domain(&faces[at], along, &lo, &hi);
        length[i] = job->options.spacing == KN_CELLS_EVEN ? kn_job_mean_length(&measures[at], along) : hi - lo;
        total += share[i] = kn_spline_spans(&faces[at], along);
    }
    if (status == KN_OK && total > count)
        status = kn_fail(ctx, KN_EDOMAIN,
                         "job: count %d in %s would make cells straddle knot lines of surface %d, which has %d knot "
                         "spans there: at least %d",
                         count, along == 0 ? "u" : "v", s->origin, total, total);
    for (; status == KN_OK && total < count; total++) { // one more where cells are longest
        int best = 0;
        for (int i = 1; i < n; i++)
            if (length[i] / share[i] > length[best] / share[best]) best = i;
        share[best]++;
    }
    for (int i = 0; i < s->parts[0] * s->parts[1] && status == KN_OK; i++)
        counts[first + i][along] = share[s[i].part[along]];
    kn_scratch_release(ctx, mark);
    return status;
}

void kn_job_number_cells(kn_job *job)
{
    for (int i = 0; i < job->nsurfaces; i++) {
        kn_job_surface *s = &job->surfaces[i];
        const int step[2] = {s->parts[1], 1}; // to the part before in each variable
        for (int v = 0; v < 2; v++) {
            const kn_job_surface *before = s - step[v];
            s->origin_cell[v] = s->part[v] > 0 ? before->origin_cell[v] + before->cells[v] : 0;
        }
    }
}
