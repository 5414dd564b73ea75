// SPDX-License-Identifier: Apache-2.0
// The lines and degrees of the fitted normal: fit at the highest degree, halve the spans that fail in the variable
// that is to blame, and take the lowest degrees that meet the tolerance on these lines.
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>
#include <string.h>

enum { MOST_SPANS = 1 << 20 };

// Wild surfaces need more spans than anyone wants to wait for: work is limited, to four times what the worst of the
// smooth ones in bench/normals takes. Errors go down with the sixth power of the span, so that spans go up with the
// cube root of the tolerance.
static double work_for(const kn_shell *s)
{
    // multiply-adds, for each span of S at a tolerance of 1e-6: some seconds. N m is longer, and a cubic m needs more
    const double for_one = s->method == KN_NORMAL_EXACT_DIRECTION ? 4e9 : 1e9;
    return for_one * (1.0 + (double)s->nspans) * cbrt(1e-6 / s->normal_tol);
}

typedef struct refinement {
    kn_shell *shell;
    int max_degree, max_spans;
    int least[2], lowest[2];               // lowest: with whole cells
    int highest, cell_degree_sum, most[2]; // most: kn_grid_axis
    kn_grid_axis axes[2];
    kn_direction_box *box; // the direction over each span of n, last variable fastest
    size_t nboxes;
    double work; // multiply-adds that are left
} refinement;

typedef struct candidate {
    kn_spline n;
    kn_bezier *pieces;
    size_t npieces;
    kn_normal_certificate *certificates, worst;
    char *failed; // spans that do not meet the tolerance
    size_t nfailed;
} candidate;

static void candidate_clear(kn_ctx *ctx, candidate *c)
{
    kn_spline_clear(ctx, &c->n);
    for (size_t i = 0; i < c->npieces; i++) kn_bezier_clear(ctx, &c->pieces[i]);
    kn_free(ctx, c->pieces);
    kn_free(ctx, c->certificates);
    kn_free(ctx, c->failed);
    *c = (candidate){0};
}

// ---- the direction over each span of the grid ----

static void clear_boxes(kn_ctx *ctx, refinement *r)
{
    for (size_t i = 0; i < r->nboxes; i++) kn_bezier_clear(ctx, &r->box[i].n);
    kn_free(ctx, r->box);
    r->box = NULL, r->nboxes = 0;
}

static kn_status make_box(kn_ctx *ctx, refinement *r, int i, int j)
{
    const kn_shell *s = r->shell;
    const int at[2] = {i, j};
    int from[2];
    double lo[2], hi[2];
    for (int v = 0; v < 2; v++) {
        const double *cut = r->axes[v].cut + at[v], *knot;
        from[v] = kn_interval(s->knot[v], s->nknots[v], cut[0]);
        knot = s->knot[v] + from[v];
        lo[v] = (cut[0] - knot[0]) / (knot[1] - knot[0]);
        hi[v] = (cut[1] - knot[0]) / (knot[1] - knot[0]);
    }
    kn_direction_box *box = &r->box[(size_t)i * (size_t)(r->axes[1].ncuts - 1) + (size_t)j];
    box->span = (size_t)(from[0] * (s->nknots[1] - 1) + from[1]);
    const kn_direction *d = &s->direction[box->span];
    box->error = d->error + kn_gamma(8.0 * (d->n.degree[0] + d->n.degree[1] + 4)) * kn_largest_vector(&d->n, 0, 3);
    r->work -= 3.0 * (double)kn_bezier_count(&d->n) * (d->n.degree[0] + d->n.degree[1]);
    return kn_bezier_restrict(ctx, &box->n, &d->n, lo, hi);
}

static kn_status make_boxes(kn_ctx *ctx, refinement *r)
{
    clear_boxes(ctx, r);
    int nu = r->axes[0].ncuts - 1, nv = r->axes[1].ncuts - 1;
    size_t n = (size_t)nu * (size_t)nv;
    r->box = kn_alloc_zero(ctx, n, sizeof *r->box);
    if (!r->box) return KN_ENOMEM;
    r->nboxes = n;
    kn_status status = KN_OK;
    for (int i = 0; i < nu && status == KN_OK; i++)
        for (int j = 0; j < nv && status == KN_OK; j++) status = make_box(ctx, r, i, j);
    return status;
}

// ---- one fit, and what it is worth ----

static kn_status fit(kn_ctx *ctx, candidate *c, refinement *r, const int degree[2])
{
    kn_shell *s = r->shell;
    kn_status status = KN_OK;
    for (int v = 0; v < 2 && status == KN_OK; v++)
        status = kn_grid_set_degree(ctx, &r->axes[v], degree[v], s->knot[v], s->nknots[v]);
    if (status == KN_OK && s->method == KN_NORMAL_EXACT_DIRECTION)
        status = kn_fit_exact_direction(ctx, &c->n, s, r->axes, r->box);
    else if (status == KN_OK)
        status = kn_fit_normal(ctx, &c->n, s, r->axes);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &c->pieces, &c->npieces, &c->n);
    if (status != KN_OK) return status;
    r->work -= 8.0 * (double)kn_spline_count(&c->n) * (degree[0] + degree[1]);
    c->certificates = kn_alloc_zero(ctx, c->npieces, sizeof *c->certificates);
    c->failed = kn_alloc_zero(ctx, c->npieces, 1);
    return c->certificates && c->failed ? KN_OK : KN_ENOMEM;
}

// Samples are cheap and find most failures. c->worst receives the largest. all: go on after the first failure.
static void sample(candidate *c, refinement *r, bool all)
{
    double tol = r->shell->normal_tol, length, angle;
    for (size_t i = 0; i < c->npieces && (all || c->nfailed == 0); i++) {
        kn_sample_errors(&length, &angle, &c->pieces[i], &r->box[i].n);
        r->work -= 16.0 * (double)(kn_bezier_count(&c->pieces[i]) + kn_bezier_count(&r->box[i].n)) + 500.0;
        c->failed[i] = !(length <= tol && angle <= tol);
        c->nfailed += (size_t)c->failed[i];
        c->worst.length_error = fmax(c->worst.length_error, length);
        c->worst.angle_error = fmax(c->worst.angle_error, angle);
    }
}

// The certificates, after sample() found no failure: subdivided until they come near the worst sample of all.
static kn_status certify(kn_ctx *ctx, candidate *c, refinement *r, bool all)
{
    const double near = 1.6;
    kn_certify_options o = {.limit = r->shell->normal_tol, .work = &r->work};
    o.target[0] = near * c->worst.length_error;
    o.target[1] = near * c->worst.angle_error;
    double largest = 1.0; // coefficients of n, whose pieces have errors in proportion
    for (size_t i = 0; i < 3 * kn_spline_count(&c->n); i++) largest = fmax(largest, fabs(c->n.coef[i]));
    o.normal_error = 2.0 * largest * kn_gamma(16.0 * (c->n.degree[0] + c->n.degree[1] + 2));
    c->worst = (kn_normal_certificate){.certified = true};
    for (size_t i = 0; i < c->npieces && (all || c->nfailed == 0); i++) {
        o.direction_error = r->box[i].error;
        kn_normal_certificate *here = &c->certificates[i];
        kn_status status = kn_certify(ctx, here, &c->pieces[i], &r->box[i].n, &o);
        if (status != KN_OK) return status;
        c->failed[i] = !here->certified;
        c->nfailed += (size_t)c->failed[i];
        c->worst.length_error = fmax(c->worst.length_error, here->length_error);
        c->worst.angle_error = fmax(c->worst.angle_error, here->angle_error);
    }
    return KN_OK;
}

// ---- where to put more lines ----

// The difference of order degree + 1 of the unit normal at equal steps across the box in variable var: what a
// polynomial of that degree leaves over, up to a factor that both variables share. Of N m, instead, that of 1/|N|
// over 1/|N| at the last step.
static double left_over(const refinement *r, const kn_bezier *direction, int degree, int var)
{
    double worst = 0.0;
    for (int line = 0; line < 3; line++) {
        double f[KN_MAX_DEGREE + 2][3], x[2], square = 0.0, length[KN_MAX_DEGREE + 2];
        x[1 - var] = 0.5 * line;
        for (int k = 0; k <= degree + 1; k++) {
            x[var] = (double)k / (degree + 1);
            length[k] = kn_direction_length(f[k], direction, x);
            if (!(length[k] > 0.0)) return INFINITY;
        }
        for (int k = 0; k <= degree + 1 && r->shell->method == KN_NORMAL_EXACT_DIRECTION; k++) {
            f[k][0] = length[degree + 1] / length[k];
            f[k][1] = f[k][2] = 0.0;
        }
        for (int round = 0; round <= degree; round++)
            for (int k = 0; k <= degree - round; k++)
                for (int c = 0; c < 3; c++) f[k][c] = f[k + 1][c] - f[k][c];
        for (int c = 0; c < 3; c++) square += f[0][c] * f[0][c];
        worst = fmax(worst, sqrt(square));
    }
    return worst;
}

// From left_over to the error of interpolation. Splines of degree p on spans h err by about 4/pi (h/pi)^(p+1)
// |f^(p+1)| (Favard's constant), the difference is (h/(p+1))^(p+1) f^(p+1); and n spans have n + p sites, not n.
// Doubled: this only decides whether a line in this variable would help.
static double spline_factor(int degree, int spans)
{
    double pi = 3.14159265358979323846;
    return 8.0 / pi * pow((degree + 1) / pi * spans / (spans + degree), degree + 1);
}

// split[v]: for each interval of variable v, whether it is to be halved. Errors of a smooth spline spread from the
// span that causes them to its neighbours: a failed span that its own share does not explain is left for the next
// round, unless no span is to blame.
static size_t choose(const refinement *r, const candidate *c, char *const split[2], bool to_blame_only)
{
    size_t chosen = 0;
    const double little = 0.1; // of the other variable's share: whether that much is true shows in the next round
    double half = 0.5 * r->shell->normal_tol, weight[2];
    for (int v = 0; v < 2; v++) weight[v] = spline_factor(r->max_degree, r->axes[v].ncuts - 1);
    size_t nv = (size_t)r->axes[1].ncuts - 1;
    for (size_t i = 0; i < c->npieces; i++) {
        if (!c->failed[i]) continue;
        const kn_bezier *d = &r->box[i].n;
        double u = left_over(r, d, r->max_degree, 0), v = left_over(r, d, r->max_degree, 1);
        double eu = u * weight[0], ev = v * weight[1];
        if (to_blame_only && eu <= half && ev <= half) continue;
        chosen++;
        if (!(eu <= half || eu <= little * ev) || eu >= ev) split[0][i / nv] = 1;
        if (!(ev <= half || ev <= little * eu) || ev > eu) split[1][i % nv] = 1;
    }
    return chosen;
}

static kn_status give_up(kn_ctx *ctx, const refinement *r, const char *why)
{
    return kn_fail(ctx, KN_EUNDECIDED, "shell: normal tolerance %.3g not met with %d x %d spans of degree %d: %s%s",
                   r->shell->normal_tol, r->axes[0].ncuts - 1, r->axes[1].ncuts - 1, r->max_degree, why,
                   kn_thin_edge(r->shell));
}

static kn_status split_axis(kn_ctx *ctx, refinement *r, int var, const char *split)
{
    kn_grid_axis *g = &r->axes[var];
    double width = g->cut[g->ncuts - 1] - g->cut[0];
    int more = 0;
    for (int i = 0; i + 1 < g->ncuts; i++) {
        more += split[i] != 0;
        if (split[i] && g->cut[i + 1] - g->cut[i] < 1e-9 * width)
            return give_up(ctx, r, "spans shrink without end (is the normal continuous?)");
    }
    if (g->ncuts - 1 + more > r->max_spans) return give_up(ctx, r, "max_spans");
    return kn_grid_split(ctx, g, split);
}

// No line helps where rounding alone passes the tolerance: in the spline, or in the direction of a span.
static bool below_rounding(const refinement *r, const candidate *c)
{
    double tol = r->shell->normal_tol;
    if (tol < 1e-12) return true;
    for (size_t i = 0; i < c->npieces; i++)
        if (c->failed[i] && r->box[i].error > 0.5 * tol * kn_largest_vector(&r->box[i].n, 0, 3)) return true;
    return false;
}

// Whether one of the lines that are wanted would lie between those of the cells.
static bool cuts_cells(const kn_grid_axis *g, const char *split)
{
    for (int i = 0; i + 1 < g->ncuts; i++) {
        if (!split[i]) continue;
        int at = kn_interval(g->line, g->nlines, g->cut[i]);
        if (g->line[at + 1] >= g->cut[i + 1]) return true;
    }
    return false;
}

// inside: no lines are added, and it is set, where they would lie in cells; NULL: they may.
static kn_status more_lines(kn_ctx *ctx, refinement *r, const candidate *c, bool *inside)
{
    if (below_rounding(r, c)) return give_up(ctx, r, "the tolerance is below what rounding leaves");
    if (r->work < 0.0) return give_up(ctx, r, "that is all the work that this tolerance is worth");
    size_t nu = (size_t)r->axes[0].ncuts - 1, nv = (size_t)r->axes[1].ncuts - 1;
    kn_mark mark = kn_scratch_mark(ctx);
    char *split[2] = {kn_scratch(ctx, nu, 1), kn_scratch(ctx, nv, 1)};
    kn_status status = split[0] && split[1] ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        memset(split[0], 0, nu);
        memset(split[1], 0, nv);
        if (choose(r, c, split, true) == 0) (void)choose(r, c, split, false);
        if (inside) *inside = cuts_cells(&r->axes[0], split[0]) || cuts_cells(&r->axes[1], split[1]);
        if (inside && *inside) {
            kn_scratch_release(ctx, mark);
            return KN_OK;
        }
        status = split_axis(ctx, r, 0, split[0]);
        if (status == KN_OK) status = split_axis(ctx, r, 1, split[1]);
        if (status == KN_OK && (size_t)r->axes[0].ncuts * (size_t)r->axes[1].ncuts > MOST_SPANS)
            status = give_up(ctx, r, "more than a million");
        if (status == KN_OK) status = make_boxes(ctx, r);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- the whole ----

static kn_status try_degrees(kn_ctx *ctx, candidate *best, bool *found, refinement *r, const int degree[2])
{
    candidate c = {0};
    kn_status status = fit(ctx, &c, r, degree);
    if (status == KN_OK) sample(&c, r, false);
    if (status == KN_OK && c.nfailed == 0) status = certify(ctx, &c, r, false);
    *found = status == KN_OK && c.nfailed == 0;
    if (*found) {
        *best = c;
        c = (candidate){0};
    }
    candidate_clear(ctx, &c);
    return status;
}

// The first pair of degrees below the highest, by their sum and then the most even, that meets the tolerance.
static kn_status lower_degrees(kn_ctx *ctx, candidate *best, bool *found, refinement *r)
{
    int top = r->max_degree;
    kn_status status = KN_OK;
    *found = false;
    for (int sum = r->least[0] + r->least[1]; sum < 2 * top; sum++)
        for (int difference = sum % 2; difference <= top - KN_LEAST_DEGREE; difference += 2)
            for (int k = 0; k < (difference > 0 ? 2 : 1); k++) {
                int low = (sum - difference) / 2, high = (sum + difference) / 2;
                const int degree[2] = {k == 0 ? high : low, k == 0 ? low : high};
                bool allowed = degree[0] >= r->least[0] && degree[1] >= r->least[1] && high <= top;
                if (allowed && !*found && status == KN_OK) status = try_degrees(ctx, best, found, r, degree);
            }
    return status;
}

// The variable in which the spans that failed leave more over.
static int worse_variable(const refinement *r, const candidate *c, const int degree[2])
{
    double worst[2] = {0.0, 0.0};
    for (size_t i = 0; i < c->npieces; i++)
        for (int v = 0; v < 2 && c->failed[i]; v++)
            worst[v] = fmax(worst[v], left_over(r, &r->box[i].n, degree[v], v));
    return worst[1] > worst[0];
}

// Higher degrees instead of lines between those of the cells, and C2 or C0 alone across these (most): raised one by
// one until the tolerance is met, then lowered as far as it goes. Not found where their sum is more than there is room
// for.
static kn_status raise_degrees(kn_ctx *ctx, candidate *best, bool *found, refinement *r, int most)
{
    int degree[2] = {r->max_degree, r->max_degree};
    kn_status status = KN_OK;
    *found = false;
    for (int v = 0; v < 2; v++) r->axes[v].most = most < r->most[v] ? most : r->most[v];
    while (status == KN_OK && !*found && r->work > 0.0 && degree[0] <= r->highest && degree[1] <= r->highest &&
           degree[0] + degree[1] <= r->cell_degree_sum + r->max_degree) {
        candidate c = {0};
        status = fit(ctx, &c, r, degree);
        if (status == KN_OK) sample(&c, r, true);
        if (status == KN_OK && c.nfailed == 0) status = certify(ctx, &c, r, true);
        *found = status == KN_OK && c.nfailed == 0;
        if (status == KN_OK && !*found) degree[worse_variable(r, &c, degree)]++;
        candidate_clear(ctx, *found ? best : &c);
        if (*found) *best = c;
    }
    for (int v = 0; v < 2 && *found; v++)
        for (bool lower = true; status == KN_OK && lower && degree[v] > r->lowest[v];) {
            candidate c = {0};
            degree[v]--;
            status = try_degrees(ctx, &c, &lower, r, degree);
            if (!lower) degree[v]++;
            if (!lower) continue;
            candidate_clear(ctx, best);
            *best = c;
        }
    if (*found && (status != KN_OK || best->n.degree[0] + best->n.degree[1] > r->cell_degree_sum)) {
        candidate_clear(ctx, best);
        *found = false;
    }
    for (int v = 0; v < 2 && !*found; v++) r->axes[v].most = r->most[v];
    return status;
}

static kn_status refine(kn_ctx *ctx, candidate *best, refinement *r)
{
    const int degree[2] = {r->max_degree, r->max_degree};
    kn_status status = make_boxes(ctx, r);
    bool found = false, cells_alone = r->cell_degree_sum > 0;
    while (status == KN_OK && !found) {
        candidate c = {0};
        status = fit(ctx, &c, r, degree);
        if (status == KN_OK) sample(&c, r, true);
        if (status == KN_OK && c.nfailed == 0) status = lower_degrees(ctx, best, &found, r);
        if (status == KN_OK && c.nfailed == 0 && !found) {
            status = certify(ctx, &c, r, true);
            found = status == KN_OK && c.nfailed == 0;
            if (found) {
                *best = c;
                c = (candidate){0};
            }
        }
        bool inside = false;
        if (status == KN_OK && !found) status = more_lines(ctx, r, &c, cells_alone ? &inside : NULL);
        if (status == KN_OK && inside) status = raise_degrees(ctx, best, &found, r, KN_LOOSE);
        if (status == KN_OK && inside && !found) status = raise_degrees(ctx, best, &found, r, 0);
        cells_alone = cells_alone && !inside;
        candidate_clear(ctx, &c);
    }
    return status;
}

static void adopt(refinement *r, candidate *c)
{
    kn_shell *s = r->shell;
    kn_spline_swap(&s->normal, &c->n);
    s->normal_piece = c->pieces, s->nnormal_pieces = c->npieces;
    s->certificates = c->certificates, s->certificate = c->worst;
    c->pieces = NULL, c->npieces = 0, c->certificates = NULL;
    for (int v = 0; v < 2; v++) {
        s->cut[v] = r->axes[v].cut, s->ncuts[v] = r->axes[v].ncuts;
        r->axes[v].cut = NULL;
    }
}

kn_status kn_refine_normal(kn_ctx *ctx, kn_shell *shell, const kn_shell_options *o, int highest)
{
    refinement r = {.shell = shell, .max_spans = o->max_spans, .work = work_for(shell), .highest = highest};
    candidate best = {0};
    r.max_degree = o->max_degree < highest ? o->max_degree : highest;
    r.cell_degree_sum = o->cell_degree_sum;
    for (int v = 0; v < 2; v++) {
        int least = o->min_degree[v] < highest ? o->min_degree[v] : highest;
        r.least[v] = least > KN_LEAST_DEGREE ? least : KN_LEAST_DEGREE;
        r.lowest[v] = least > 1 ? least : 1;
        r.max_degree = r.least[v] > r.max_degree ? r.least[v] : r.max_degree;
    }
    kn_status status = kn_grid_init(ctx, &r.axes[0], shell, 0);
    if (status == KN_OK) status = kn_grid_init(ctx, &r.axes[1], shell, 1);
    for (int v = 0; v < 2; v++)
        r.axes[v].most = r.most[v] = o->cells_apart[v] ? 0 : o->min_degree[v] > 0 ? KN_LOOSE : KN_SMOOTH;
    if (status == KN_OK) status = refine(ctx, &best, &r);
    if (status == KN_OK) adopt(&r, &best);
    candidate_clear(ctx, &best);
    clear_boxes(ctx, &r);
    for (int v = 0; v < 2; v++) kn_grid_clear(ctx, &r.axes[v]);
    return status;
}
