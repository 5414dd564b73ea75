// SPDX-License-Identifier: Apache-2.0
// Places over a base: which point of which surface the (u,v) of a cell is, the same one from every cell that has it,
// and what fields ask about it.
#include "job/internal.h"
#include "job/vary.h"

#include <math.h>
#include <string.h>

// ---- one place, one name ----

// Lattice coordinates: x[d] in [0, cells[d]], whole numbers on cell lines.
static bool is_before(const kn_job_spot *a, const kn_job_spot *b)
{
    if (a->surface != b->surface) return a->surface < b->surface;
    return a->x[0] != b->x[0] ? a->x[0] < b->x[0] : a->x[1] < b->x[1];
}

enum { MOST_NAMES = 32 }; // of one point: more surfaces than meet at any vertex

typedef struct names {
    kn_job_spot list[MOST_NAMES];
    int n;
} names;

static void add_name(names *all, kn_job_spot spot)
{
    for (int i = 0; i < all->n; i++)
        if (all->list[i].surface == spot.surface && all->list[i].x[0] == spot.x[0] && all->list[i].x[1] == spot.x[1])
            return;
    if (all->n < MOST_NAMES) all->list[all->n++] = spot;
}

// The names that the point has across the ends of variable d: over the seam, or over an edge that is shared.
static void add_across(names *all, const kn_job *job, kn_job_spot spot, int d)
{
    const kn_job_surface *s = &job->surfaces[spot.surface];
    double last = s->cells[d];
    for (int end = 0; end < 2; end++) {
        if (spot.x[d] != (end == 0 ? 0.0 : last)) continue;
        kn_job_spot other = spot;
        const kn_job_partner *p = &s->partner[2 * d + end];
        if (s->closed[d]) {
            other.x[d] = last - spot.x[d];
            add_name(all, other);
        } else if (p->goes_on) {
            const kn_job_surface *to = &job->surfaces[p->edge / 4];
            int across = (p->edge % 4) >> 1;
            other.surface = p->edge / 4;
            other.x[across] = p->edge % 2 == 0 ? 0.0 : to->cells[across];
            other.x[1 - across] = p->reversed ? s->cells[1 - d] - spot.x[1 - d] : spot.x[1 - d];
            add_name(all, other);
        }
    }
}

int kn_job_spot_names(kn_job_spot *out, const kn_job *job, kn_job_spot spot, int room)
{
    names all = {.list = {spot}, .n = 1};
    for (int i = 0; i < all.n; i++)
        for (int d = 0; d < 2; d++) add_across(&all, job, all.list[i], d);
    int n = all.n < room ? all.n : room;
    memcpy(out, all.list, (size_t)n * sizeof *out);
    return n;
}

// Steps of 2^-40 of a cell: what rounding leaves of one place in two cells becomes one number again, and what is
// added to it below is exact.
static double on_grid(double x)
{
    return round(x * 0x1p40) * 0x1p-40;
}

static double into(double x, int cells, bool closed)
{
    if (!closed) return fmin(fmax(x, 0.0), cells);
    double wrapped = x - cells * floor(x / cells); // the quotient may be rounded up to a whole number
    return wrapped < 0.0 ? wrapped + cells : wrapped;
}

kn_job_spot kn_job_find_spot(const kn_job *job, int surface, const int cell[2], const double uv[2])
{
    int offset[2];
    double part[3] = {0.0, 0.0, 0.0};
    for (int d = 0; d < 2; d++) {
        double at = on_grid(fmin(fmax(uv[d], -KN_JOB_MAX_REACH), KN_JOB_MAX_REACH + 1));
        offset[d] = (int)floor(at);
        part[d] = at - offset[d];
    }
    kn_job_place place = kn_job_find_place(job, surface, cell, offset);
    kn_job_turn(part, 1, 1, place.turn);
    kn_job_spot spot = {place.surface, {0.0, 0.0}}, all[MOST_NAMES];
    const kn_job_surface *s = &job->surfaces[place.surface];
    for (int d = 0; d < 2; d++) spot.x[d] = into(place.cell[d] + part[d], s->cells[d], s->closed[d]);
    int n = kn_job_spot_names(all, job, spot, MOST_NAMES);
    for (int i = 0; i < n; i++)
        if (is_before(&all[i], &spot)) spot = all[i];
    return spot;
}

// ---- what fields ask ----

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// Mean and Gaussian curvature from S_u, S_v and second derivatives (k = 3: uu, 4: uv, 5: vv), n along S_u x S_v: with
// E, F, G and e, f, g  H = (e G - 2 f F + g E) / 2 (E G - F^2), K = (e g - f^2) / (E G - F^2). False: S_u x S_v is 0
// but for rounding.
static bool curvature_of(double out[2], const double *const d[6])
{
    double e1 = dot(d[1], d[1]), f1 = dot(d[1], d[2]), g1 = dot(d[2], d[2]);
    const double n[3] = {d[1][1] * d[2][2] - d[1][2] * d[2][1], d[1][2] * d[2][0] - d[1][0] * d[2][2],
                         d[1][0] * d[2][1] - d[1][1] * d[2][0]};
    double square = dot(n, n), length = sqrt(square); // E G - F^2
    if (!(square > 1e-20 * e1 * g1) || length == 0.0) return false;
    double e2 = dot(d[3], n) / length, f2 = dot(d[4], n) / length, g2 = dot(d[5], n) / length;
    out[0] = (e2 * g1 - 2.0 * f2 * f1 + g2 * e1) / (2.0 * square);
    out[1] = (e2 * g2 - f2 * f2) / square;
    return true;
}

// At a pole, and wherever else S_u x S_v vanishes, that of a place a little nearer to the middle; 0 where there is
// none either.
static kn_status find_curvature(kn_ctx *ctx, double out[2], const kn_spline *s, const double at[2])
{
    static const int order[6][2] = {{0, 0}, {1, 0}, {0, 1}, {2, 0}, {1, 1}, {0, 2}};
    double near[2] = {at[0], at[1]}, values[18];
    const double *d[6];
    kn_status status = KN_OK;
    out[0] = out[1] = 0.0;
    for (int k = 0; k < 6; k++) d[k] = values + 3 * kn_derivative_index(2, order[k]);
    for (int round = 0; status == KN_OK && round < 4; round++) {
        status = kn_spline_derivatives(ctx, values, s, near, 2);
        if (status == KN_OK && curvature_of(out, d)) return KN_OK;
        for (int v = 0; v < 2; v++) {
            double lo, hi;
            kn_spline_domain(s, v, &lo, &hi);
            near[v] += ldexp(0.5 * (lo + hi) - near[v], 4 * round - 12);
        }
    }
    return status;
}

// S's parameter; the same double from both sides of a line.
static double parameter(const kn_job_surface *s, int d, double x)
{
    int cell = (int)fmin(fmax(floor(x), 0.0), s->cells[d] - 1);
    double part = x - cell, lo = s->lines[d][cell], hi = s->lines[d][cell + 1];
    return part == 1.0 ? hi : lo + part * (hi - lo);
}

kn_status kn_job_fill_spot(kn_ctx *ctx, kn_place *out, const kn_job *job, const kn_job_spot *spot, unsigned needs)
{
    const kn_job_surface *s = &job->surfaces[spot->surface];
    const kn_spline *base = kn_shell_surface(s->shell);
    kn_place place = {.surface = s->origin};
    double at[2];
    kn_status status = KN_OK;
    for (int d = 0; d < 2; d++) {
        double first = s->lines[d][0], last = s->lines[d][s->cells[d]];
        at[d] = parameter(s, d, spot->x[d]);
        double part = (at[d] - first) / (last - first);
        place.uv[d] = at[d] == last ? s->box[1][d] : s->box[0][d] + part * (s->box[1][d] - s->box[0][d]);
    }
    if ((needs & KN_NEEDS_POINT) != 0) status = kn_spline_eval(ctx, place.point, base, at);
    if (status == KN_OK && (needs & KN_NEEDS_NORMAL) != 0)
        status = kn_shell_unit_normal(ctx, place.normal, s->shell, at[0], at[1]);
    if (status == KN_OK && (needs & KN_NEEDS_CURVATURE) != 0) status = find_curvature(ctx, place.curvature, base, at);
    if (status == KN_OK) *out = place;
    return status;
}
