// SPDX-License-Identifier: Apache-2.0
// Patches over cells for which no polynomial stands for n: each interpolates T(D), N/|N| in it, at sites that crowd
// towards the ends, with both ends among them. Along an edge that depends on T(D) there alone, in one degree, so that
// the patches on both sides of it have the same control points, bit for bit: points on edges that surfaces share are
// taken from one of them, and sums are the same for both directions of an edge.
//
// The bound: over each of its parts over which a polynomial stands for N/|N|, with an error that is certified, the
// difference from what D composes to with that is a polynomial, and of a rational surface one over a weight.
#include "bezier/norm_bound.h"
#include "job/cross.h"
#include "kernel/bernstein.h"

#include <knurl/compose.h>

#include <math.h>

enum { MOST_SITES = KN_MAX_DEGREE + 1, DEPTH = 8, MOST_DEGREES = 20 };

// ---- where a place is, the same for all surfaces that have it ----

// Basis functions add up to 1 but for rounding, and what is on a line is to be there.
static double on_line(double x)
{
    double line = nearbyint(x);
    return fabs(x - line) <= 0x1p-44 ? line : fmin(fmax(x, 0.0), 1.0);
}

// The multiples of 2^-40: x and 1 - x on both sides of an edge that runs backwards.
static double on_lattice(double x)
{
    return ldexp(nearbyint(ldexp(x, 40)), -40);
}

static double line_at(const double *line, int cell, double t)
{
    return t == 1.0 ? line[cell + 1] : line[cell] + t * (line[cell + 1] - line[cell]);
}

// (u,v) in a cell of the surface, one of its own, as x in the parameters of the surface that has it first.
static void find_first(int *surface, double x[2], const kn_job *job, const int cell[2], const double uv[2])
{
    const kn_job_surface *s = &job->surfaces[*surface];
    int at[2] = {cell[0], cell[1]}, end[2];
    double t[2] = {uv[0], uv[1]};
    for (int d = 0; d < 2; d++) {
        bool first = at[d] == 0 && t[d] == 0.0, last = at[d] == s->cells[d] - 1 && t[d] == 1.0;
        if (last && s->closed[d]) at[d] = 0, t[d] = 0.0, first = true, last = false;
        end[d] = first ? 0 : last ? 1 : -1;
    }
    for (int d = 0; d < 2; d++)
        if (end[d] >= 0 && s->pole[2 * d + end[d]]) at[1 - d] = 0, t[1 - d] = 0.0, end[1 - d] = 0;
    if (end[0] >= 0 && end[1] >= 0) {
        int first = s->joint[2 * end[0] + end[1]];
        *surface = first / 4, s = &job->surfaces[*surface];
        x[0] = s->lines[0][first & 2 ? s->cells[0] : 0];
        x[1] = s->lines[1][first & 1 ? s->cells[1] : 0];
        return;
    }
    int d = end[0] >= 0 ? 0 : 1;
    int edge = end[d] >= 0 ? 2 * d + end[d] : -1;
    if (edge >= 0 && kn_job_meets(job, *surface, edge)) {
        const kn_job_partner *p = &s->partner[edge];
        t[1 - d] = on_lattice(t[1 - d]);
        if (p->edge < 4 * *surface + edge) {
            const kn_job_surface *other = &job->surfaces[p->edge / 4];
            int across = (p->edge % 4) >> 1, n = other->cells[1 - across], i = at[1 - d];
            double along = t[1 - d];
            at[1 - across] = p->reversed ? n - 1 - i : i;
            t[1 - across] = p->reversed ? 1.0 - along : along;
            at[across] = p->edge % 2 == 1 ? other->cells[across] - 1 : 0;
            t[across] = p->edge % 2;
            *surface = p->edge / 4, s = other;
        }
    }
    for (int k = 0; k < 2; k++) x[k] = line_at(s->lines[k], at[k], t[k]);
}

// h, from h n, which T moves by where w begins; n at x comes, too.
static kn_status thickness_at(kn_ctx *ctx, double *h, double n[3], const kn_shell *shell, const double x[2])
{
    double at[3], jacobian[9], dot = 0.0, square = 0.0;
    kn_status status = kn_shell_eval(ctx, at, jacobian, shell, x[0], x[1], 0.0);
    if (status == KN_OK) status = kn_spline_eval(ctx, n, kn_shell_normal(shell), x);
    if (status != KN_OK) return status;
    for (int c = 0; c < 3; c++) dot += jacobian[3 * c + 2] * n[c], square += n[c] * n[c];
    *h = dot / square;
    return KN_OK;
}

// T there, with the unit normal itself.
static kn_status value_at(kn_ctx *ctx, double out[3], const kn_job *job, const kn_job_place *place,
                          const double uvw[3])
{
    double x[2], n[3], m[3] = {0.0, 0.0, 0.0}, h = 1.0;
    int surface = place->surface;
    find_first(&surface, x, job, place->cell, uvw);
    const kn_shell *shell = job->surfaces[surface].shell;
    kn_status status = kn_spline_eval(ctx, out, kn_shell_surface(shell), x);
    if (status != KN_OK || uvw[2] == 0.0) return status;
    if (job->has_fields) status = thickness_at(ctx, &h, m, shell, x);
    if (status == KN_OK && job->has_fields) status = kn_shell_eval(ctx, out, NULL, shell, x[0], x[1], uvw[2]);
    if (status == KN_OK) status = kn_shell_unit_normal(ctx, n, shell, x[0], x[1]);
    for (int c = 0; c < 3 && status == KN_OK; c++) out[c] += uvw[2] * h * (n[c] - m[c]);
    return status;
}

kn_status kn_job_meeting_scale(kn_ctx *ctx, double *out, const kn_job *job)
{
    enum { STEPS = 8 };
    double most = job->has_fields ? 0.0 : 1.0, h, n[3];
    kn_status status = KN_OK;
    for (int i = 0; job->has_fields && i < job->nsurfaces * (STEPS + 1) * (STEPS + 1) && status == KN_OK; i++) {
        const kn_job_surface *s = &job->surfaces[i / ((STEPS + 1) * (STEPS + 1))];
        const int at[2] = {i / (STEPS + 1) % (STEPS + 1), i % (STEPS + 1)};
        double x[2];
        if (!s->meets) continue;
        for (int v = 0; v < 2; v++) x[v] = s->lines[v][s->cells[v] * at[v] / STEPS];
        status = thickness_at(ctx, &h, n, s->shell, x);
        if (status == KN_OK) most = fmax(most, h);
    }
    *out = fabs(job->report.height) * most;
    return status;
}

// ---- interpolation ----

// out[i] = sum_j a[i][j] in[j] along one variable of (outer, columns, inner), in pairs from both ends: for a matrix
// that is the same from both, the result of what is reversed is reversed, bit for bit.
static void apply(double *out, const double *a, int rows, int columns, const double *in, size_t outer, size_t inner)
{
    for (size_t o = 0; o < outer; o++)
        for (int i = 0; i < rows; i++)
            for (size_t k = 0; k < inner; k++) {
                const double *row = a + (size_t)i * (size_t)columns, *x = in + o * (size_t)columns * inner + k;
                double sum = 0.0;
                for (int j = 0; 2 * j < columns; j++) {
                    int last = columns - 1 - j;
                    double pair = row[j] * x[(size_t)j * inner];
                    if (last > j) pair += row[last] * x[(size_t)last * inner];
                    sum += pair;
                }
                out[(o * (size_t)rows + (size_t)i) * inner + k] = sum;
            }
}

// Makes it the same from both ends.
static void even(double *a, int rows, int columns)
{
    for (int i = 0; 2 * i < rows; i++)
        for (int j = 0; j < columns; j++) {
            int last = (rows - 1 - i) * columns + columns - 1 - j;
            if (2 * i + 1 == rows && 2 * j >= columns) continue;
            a[last] = a[i * columns + j];
        }
}

// Values at the sites of degree p become coefficients by way of Chebyshev's polynomials: of what is smooth those with
// large Bernstein coefficients have small factors, so that less is lost than with the inverse of the basis functions.
// a: from values to the factors of T_k(1 - 2x); b: from these to Bernstein coefficients. Both are the same from both
// ends, of odd k but for the sign.
static void make_transform(double *a, double *b, int p)
{
    const double pi = 3.14159265358979323846;
    double wave[2 * MOST_SITES], t[MOST_SITES], raised[MOST_SITES];
    int n = p + 1;
    for (int m = 0; m <= 2 * p; m++) {
        int k = m <= p ? m : 2 * p - m; // 0 .. p
        int j = 2 * k <= p ? k : p - k; // 0 .. p/2
        double x = 2 * j == p ? 0.0 : cos(pi * j / p);
        wave[m] = 2 * k <= p ? x : -x;
    }
    for (int k = 0; k <= p; k++) {
        for (int j = 0; j <= p; j++)
            a[k * n + j] = wave[j * k % (2 * p)] * (j == 0 || j == p ? 0.5 : 1.0) * (k == 0 || k == p ? 1.0 : 2.0) /
                           p;
        t[0] = 1.0;
        for (int j = 0; j < k; j++) t[j + 1] = -t[j] * (2 * k - 2 * j - 1) / (2 * j + 1);
        kn_bernstein_elevate(raised, t, 1, k, p, 1);
        for (int i = 0; 2 * i <= p; i++) {
            double x = 2 * i == p && k % 2 == 1 ? 0.0 : raised[i];
            b[i * n + k] = x, b[(p - i) * n + k] = k % 2 == 1 ? -x : x;
        }
    }
}

// Along one variable of (outer, p + 1, inner). Both ends stay what they are.
static kn_status to_bernstein(kn_ctx *ctx, double *out, const double *in, int p, size_t outer, size_t inner)
{
    size_t n = (size_t)p + 1;
    kn_mark mark = kn_scratch_mark(ctx);
    double *a = kn_scratch(ctx, 2 * n * n, sizeof *a), *work = kn_scratch(ctx, outer * n * inner, sizeof *work);
    if (a && work) {
        make_transform(a, a + n * n, p);
        apply(work, a, p + 1, p + 1, in, outer, inner);
        apply(out, a + n * n, p + 1, p + 1, work, outer, inner);
        for (size_t o = 0; o < outer; o++)
            for (size_t k = 0; k < inner; k++) {
                size_t first = o * n * inner + k, last = first + (n - 1) * inner;
                out[first] = in[first], out[last] = in[last];
            }
    }
    kn_scratch_release(ctx, mark);
    return a && work ? KN_OK : KN_ENOMEM;
}

// From the coefficients of degree m to values at the sites of degree p.
static void make_values(double *a, int p, int m)
{
    for (int i = 0; i <= p; i++) kn_bernstein_basis(a + i * (m + 1), m, kn_cross_site(i, p));
    even(a, p + 1, m + 1);
}

kn_status kn_job_sample(kn_ctx *ctx, double *at, const kn_job *job, const kn_job_place *place, const kn_bezier *d,
                        const int degree[2])
{
    int n[2] = {degree[0] + 1, degree[1] + 1}, m[2] = {d->degree[0] + 1, d->degree[1] + 1};
    size_t sites = (size_t)n[0] * (size_t)n[1], values = 0;
    for (int v = 0; v < 2; v++) values = (size_t)(n[v] * m[v]) > values ? (size_t)(n[v] * m[v]) : values;
    double *a = kn_scratch(ctx, values, sizeof *a), *work = kn_scratch(ctx, 3 * (size_t)(n[0] * m[1]), sizeof *work);
    kn_status status = a && work ? KN_OK : KN_ENOMEM;
    if (status != KN_OK) return status;
    make_values(a, degree[0], m[0] - 1);
    apply(work, a, n[0], m[0], d->coef, 3, (size_t)m[1]);
    make_values(a, degree[1], m[1] - 1);
    apply(at, a, n[1], m[1], work, 3 * (size_t)n[0], 1);
    for (size_t i = 0; i < sites && status == KN_OK; i++) {
        double value[3], uvw[3] = {at[i], at[sites + i], at[2 * sites + i]};
        for (int c = 0; c < 2; c++) uvw[c] = on_line(uvw[c]);
        status = value_at(ctx, value, job, place, uvw);
        for (size_t c = 0; c < 3 && status == KN_OK; c++) at[c * sites + i] = value[c];
    }
    return status;
}

static kn_status interpolate(kn_ctx *ctx, kn_bezier *out, const kn_job *job, const kn_job_place *place,
                             const kn_bezier *d, const int degree[2])
{
    size_t n[2] = {(size_t)degree[0] + 1, (size_t)degree[1] + 1}, sites = n[0] * n[1];
    kn_status status = kn_bezier_init(ctx, out, 2, 3, false, degree);
    double *work = kn_scratch(ctx, 3 * sites, sizeof *work), *at = kn_scratch(ctx, 3 * sites, sizeof *at);
    if (status == KN_OK && !(work && at)) status = KN_ENOMEM;
    if (status == KN_OK) status = kn_job_sample(ctx, at, job, place, d, degree);
    if (status == KN_OK) status = to_bernstein(ctx, work, at, degree[0], 3, n[1]);
    if (status == KN_OK) status = to_bernstein(ctx, out->coef, work, degree[1], 3 * n[0], 1);
    return status;
}

// ---- the bound ----

// The largest of components first .. first + count - 1.
static double largest(const kn_bezier *f, int first, int count)
{
    double most = 0.0;
    size_t n = kn_bezier_count(f), from = (size_t)first * n;
    for (size_t i = from; i < from + (size_t)count * n; i++) most = fmax(most, fabs(f->coef[i]));
    return most;
}

// What rounding does to these components of a composition with the piece, inside its box.
static double composed(const kn_shell_piece *piece, const kn_bezier *d, double top, int first, int count)
{
    double sum = 0.0, terms = (d->degree[0] + 1.0) * (d->degree[1] + 1.0);
    for (int t = 0; t < piece->nterms; t++) {
        const kn_bezier *f = &piece->term[t];
        double p = f->degree[0] + f->degree[1] + piece->power[t], fold = (f->degree[0] + 1.0) * (f->degree[1] + 1.0);
        double size = largest(f, first, count) * pow(top, piece->power[t]);
        sum += kn_gamma_up(p * (terms + 9.0) + fold + 8.0) * size * 1.01;
    }
    return kn_round_up(2.0 * sum);
}

// e = (q - T(D)) W, T(D) being composed with the piece; of a polynomial T is W = 1.
typedef struct difference {
    kn_bezier e;
    double weight;   // W at least
    double rounding; // of e
} difference;

// W(D), in its own degrees.
static kn_status weight_of(kn_ctx *ctx, kn_bezier *w, const kn_shell_piece *piece, const kn_bezier *d)
{
    kn_bezier uv = {0};
    kn_status status = kn_bezier_components(ctx, w, &piece->term[0], 3, 1);
    if (status == KN_OK) status = kn_bezier_components(ctx, &uv, d, 0, 2);
    if (status == KN_OK) status = kn_bezier_compose(ctx, w, w, &uv);
    kn_bezier_clear(ctx, &uv);
    return status;
}

// Of q over [lo,hi], which D is a part of the patch over.
static kn_status find_difference(kn_ctx *ctx, difference *out, const kn_shell_piece *piece, const kn_bezier *d,
                                 double top, const kn_bezier *q, const double *lo, const double *hi)
{
    kn_bezier made = {0}, w = {0}, *e = &out->e;
    double size = largest(q, 0, 3), wrong = 0.0;
    kn_status status = kn_compose_piece(ctx, &made, piece, d);
    bool rational = status == KN_OK && made.rational;
    out->weight = 1.0;
    if (status == KN_OK) status = kn_bezier_restrict(ctx, e, q, lo, hi);
    if (status == KN_OK && rational) {
        status = kn_bezier_components(ctx, &made, &made, 0, 3);
        if (status == KN_OK) status = weight_of(ctx, &w, piece, d);
        if (status == KN_OK) status = kn_bezier_product(ctx, e, e, &w);
        wrong = composed(piece, d, top, 3, 1);
        for (size_t k = 0; status == KN_OK && k < kn_bezier_count(&w); k++)
            out->weight = fmin(out->weight, w.coef[k] - wrong);
        out->rounding = size * wrong;
        if (status == KN_OK) size *= largest(&w, 0, 1);
    }
    if (status == KN_OK) status = kn_bezier_difference(ctx, e, e, &made);
    if (status == KN_OK) { // the restriction, the product and the difference
        double gamma = kn_gamma_up(16.0 * (e->degree[0] + e->degree[1] + 2) + (rational ? 100.0 : 0.0));
        out->rounding += composed(piece, d, top, 0, 3) + 2.0 * gamma * (size + largest(&made, 0, 3));
        out->rounding = kn_round_up(out->rounding);
    }
    kn_bezier_clear(ctx, &made);
    kn_bezier_clear(ctx, &w);
    return status;
}

// The bound of q, as closely as it is above aim, and no farther than the limit: then it is INFINITY.
typedef struct bounding {
    const kn_job *job;
    const kn_job_place *place;
    const kn_bezier *q;
    double aim, limit, top, off;
    kn_normal_certificate normal; // the worst of the normals in use
} bounding;

// A bound of h over a piece, from that of its second term, h n, and 2^-40 of it for rounding.
static double thickness_of(const kn_shell_piece *piece)
{
    double weight = INFINITY;
    const kn_bezier *s = &piece->term[0];
    size_t n = kn_bezier_count(s);
    for (size_t i = 0; i < n && s->rational; i++) weight = fmin(weight, s->coef[3 * n + i]);
    if (!s->rational) weight = 1.0;
    weight *= 1.0 - piece->normal.length_error;
    return weight > 0.0 ? kn_largest_vector(&piece->term[1], 0, 3) / weight * (1.0 + 0x1p-40) : INFINITY;
}

// Over [lo,hi] of q, with T(D) composed with the piece, of d.
static kn_status bound_part(kn_ctx *ctx, bounding *b, const kn_shell_piece *piece, const kn_bezier *d,
                            const double *lo, const double *hi)
{
    difference v = {.weight = 1.0};
    double most = 0.0, thick = b->job->has_fields ? thickness_of(piece) : 1.0;
    double known = (piece->normal.length_error + piece->normal.angle_error) * thick * b->top;
    kn_status status = find_difference(ctx, &v, piece, d, b->top, b->q, lo, hi);
    // what is below it need not be known better
    double least = fmax(0.0, (b->aim - known) * v.weight - v.rounding) / 1.25;
    if (status == KN_OK) status = kn_bezier_norm_bound(ctx, &most, &least, &v.e, -1.0);
    if (status == KN_OK) {
        double off = v.weight > 0.0 ? kn_round_up(kn_round_up((most + v.rounding) / v.weight) + known) : INFINITY;
        b->off = fmax(b->off, off <= b->limit ? off : INFINITY);
        b->normal.length_error = fmax(b->normal.length_error, piece->normal.length_error);
        b->normal.angle_error = fmax(b->normal.angle_error, piece->normal.angle_error);
        b->normal.certified = b->normal.certified && piece->normal.certified;
    }
    kn_bezier_clear(ctx, &v.e);
    return status;
}

// The degrees that n may have, added: the composition is to be possible beside h, 1 and the weight, which the surface
// has left room for. More of them ask for fewer parts.
static int degree_sum_for(const bounding *b, const kn_bezier *d)
{
    const kn_job_surface *s = &b->job->surfaces[b->place->surface];
    int m = d->degree[0] > d->degree[1] ? d->degree[0] : d->degree[1];
    int beside = b->job->options.max_degree / s->tile_degree - s->degree_sum;
    int room = KN_MAX_DEGREE / (m > 0 ? m : 1) - beside;
    return room > MOST_DEGREES ? MOST_DEGREES : room;
}

// Over [lo,hi] of q, which D is d over: where no normal fits, over its halves.
static kn_status bound_parts(kn_ctx *ctx, bounding *b, const kn_bezier *d, const double *lo, const double *hi,
                             int depth)
{
    kn_shell_piece piece = {0};
    kn_bezier at = {0}, half[2] = {{0}, {0}};
    double from[2], to[2];
    bool fits = false;
    kn_job_box(from, to, d);
    for (int c = 0; c < 2; c++) from[c] = fmax(from[c], 0.0), to[c] = fmin(to[c], 1.0);
    kn_status status = kn_shell_piece_init(ctx, &piece, &fits, b->job->surfaces[b->place->surface].shell,
                                           b->place->cell, from, to, degree_sum_for(b, d));
    if (status == KN_OK && fits) {
        size_t n = kn_bezier_count(d);
        status = kn_bezier_copy(ctx, &at, d);
        for (size_t i = 0; i < 2 * n && status == KN_OK; i++)
            at.coef[i] = (at.coef[i] - from[i / n]) / (to[i / n] - from[i / n]);
        if (status == KN_OK) status = bound_part(ctx, b, &piece, &at, lo, hi);
        kn_shell_piece_clear(ctx, &piece);
    } else if (status == KN_OK && depth == DEPTH) {
        b->off = INFINITY;
    } else if (status == KN_OK) {
        int var = depth % 2;
        status = kn_bezier_subdivide(ctx, &half[0], &half[1], d, var, 0.5);
        for (int k = 0; k < 2 && status == KN_OK && b->off < INFINITY; k++) {
            double start[2] = {lo[0], lo[1]}, end[2] = {hi[0], hi[1]};
            (k == 0 ? end : start)[var] = 0.5 * (lo[var] + hi[var]);
            status = bound_parts(ctx, b, &half[k], start, end, depth + 1);
        }
    }
    kn_bezier_clear(ctx, &at);
    for (int k = 0; k < 2; k++) kn_bezier_clear(ctx, &half[k]);
    return status;
}

// ---- in the plan ----

// One leaf that is q, which it takes.
static kn_status add_made(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_leaf *leaf, kn_bezier *q)
{
    kn_job_leaf made = *leaf;
    made.alone = true;
    made.made = *q;
    *q = (kn_bezier){0};
    kn_status status = kn_job_add_leaf(ctx, plan, &made);
    kn_bezier_clear(ctx, &made.made);
    return status;
}

kn_status kn_job_meet(kn_ctx *ctx, bool *met, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                      const kn_job_place *place, int number)
{
    static const double zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    const kn_job *job = plan->job;
    double aim = 4.0 * job->report.normal_tol * job->meeting_height;
    kn_bezier q = {0}, d = {0};
    bounding b = {job, place, &q, aim, 4.0 * aim, kn_job_leaf_patch(plan, leaf)->top, 0.0, plan->normal};
    int degree[2];
    kn_job_meeting_fate fate = kn_job_fate_of(plan, number);
    *met = false;
    if (fate == KN_JOB_STAYS) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_job_restrict(ctx, &d, kn_job_leaf_patch(plan, leaf), leaf->key.rect, place->turn);
    kn_job_meeting_degree(degree, plan, number);
    if (status == KN_OK) status = interpolate(ctx, &q, job, place, &d, degree);
    if (status == KN_OK && (fate != KN_JOB_MEETS || plan->pieces.outline))
        status = bound_parts(ctx, &b, &d, zero, one, 0);
    if (status == KN_EUNDEFINED || status == KN_ELIMIT) { // no normal somewhere; a product of too high a degree
        kn_ctx_clear_error(ctx);
        status = KN_OK, b.off = INFINITY;
    }
    if (status == KN_OK) kn_job_set_fate(plan, number, b.off < INFINITY ? KN_JOB_MEETS : KN_JOB_STAYS);
    if (status == KN_OK && b.off < INFINITY) {
        *met = true;
        plan->normal = b.normal;
        plan->stand_in = fmax(plan->stand_in, b.off);
        status = add_made(ctx, plan, leaf, &q);
    }
    kn_scratch_release(ctx, mark);
    kn_bezier_clear(ctx, &q);
    kn_bezier_clear(ctx, &d);
    return status;
}
