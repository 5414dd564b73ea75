// SPDX-License-Identifier: Apache-2.0
// The direction of the normal of one piece of S, exactly: a cross product, edge factors divided out.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

void kn_direction_clear(kn_ctx *ctx, kn_direction *d)
{
    kn_bezier_clear(ctx, &d->n);
    *d = (kn_direction){0};
}

double kn_direction_length(double unit[3], const kn_bezier *direction, const double x[2])
{
    double bu[KN_MAX_DEGREE + 1], bv[KN_MAX_DEGREE + 1], row[3 * (KN_MAX_DEGREE + 1)];
    int mu = direction->degree[0] + 1, mv = direction->degree[1] + 1;
    kn_bernstein_basis(bu, mu - 1, x[0]);
    kn_bernstein_basis(bv, mv - 1, x[1]);
    kn_bernstein_contract(row, direction->coef, 3, mu, (size_t)mv, bu);
    kn_bernstein_contract(unit, row, 3, mv, 1, bv);
    double largest = fmax(fabs(unit[0]), fmax(fabs(unit[1]), fabs(unit[2]))), length = 0.0;
    bool there = largest > 0.0 && isfinite(largest);
    for (int c = 0; c < 3; c++) {
        unit[c] = there ? unit[c] / largest : 0.0;
        length += unit[c] * unit[c];
    }
    length = sqrt(length);
    for (int c = 0; c < 3 && there; c++) unit[c] /= length;
    return there ? largest * length : 0.0;
}

bool kn_direction_unit(double unit[3], const kn_bezier *direction, const double x[2])
{
    return kn_direction_length(unit, direction, x) > 0.0;
}

// ---- S_u x S_v; for S = P/W the numerator W (P_u x P_v) - W_v (P_u x P) - W_u (P x P_v) over W^3 ----

enum { P, PU, PV, W, WU, WV, T1, T2, NTEMP };

// Times a power of two, so that the largest coefficient is near 1: products of what follows then neither overflow nor
// underflow, which no bound of rounding here accounts for. The direction does not change. Answers the exponent.
static int normalise(kn_bezier *b)
{
    size_t n = kn_bezier_count(b) * (size_t)b->ncomp;
    double largest = 0.0;
    int exponent = 0;
    for (size_t i = 0; i < n; i++) largest = fmax(largest, fabs(b->coef[i]));
    if (!(largest > 0.0) || !isfinite(largest)) return 0;
    (void)frexp(largest, &exponent);
    for (size_t i = 0; i < n; i++) b->coef[i] = ldexp(b->coef[i], -exponent);
    return exponent;
}

// *exponent: of two, by which the numerator of these is too small.
static kn_status factors(kn_ctx *ctx, kn_bezier *t, int *exponent, const kn_bezier *piece)
{
    kn_status status = kn_bezier_components(ctx, &t[P], piece, 0, 3);
    if (status == KN_OK) *exponent = 2 * normalise(&t[P]);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &t[PU], &t[P], 0);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &t[PV], &t[P], 1);
    if (status != KN_OK || !piece->rational) return status;
    status = kn_bezier_components(ctx, &t[W], piece, 3, 1);
    if (status == KN_OK) *exponent += normalise(&t[W]);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &t[WU], &t[W], 0);
    if (status == KN_OK) status = kn_bezier_derivative(ctx, &t[WV], &t[W], 1);
    return status;
}

// sum -= scalar (a x b), all of which have one shape in the end.
static kn_status subtract(kn_ctx *ctx, kn_bezier *sum, kn_bezier *t, int scalar, int a, int b)
{
    kn_status status = kn_bezier_cross(ctx, &t[T2], &t[a], &t[b]);
    if (status == KN_OK) status = kn_bezier_product(ctx, &t[T2], &t[scalar], &t[T2]);
    if (status == KN_OK) status = kn_bezier_difference(ctx, sum, sum, &t[T2]);
    return status;
}

static kn_status numerator(kn_ctx *ctx, kn_bezier *out, kn_bezier *t, bool rational)
{
    kn_status status = kn_bezier_cross(ctx, out, &t[PU], &t[PV]);
    if (!rational) return status;
    if (status == KN_OK) status = kn_bezier_product(ctx, out, &t[W], out);
    if (status == KN_OK) status = subtract(ctx, out, t, WV, PU, P);
    if (status == KN_OK) status = subtract(ctx, out, t, WU, P, PV);
    return status;
}

// A product's coefficients are means of products of its factors' coefficients, so its rounding is at most gamma(k)
// times the product of the largest ones; the factors' own errors enter by the product rule. g: the relative error of
// the piece's coefficients (extraction from a spline, and a translation before that), against the control points
// behind it, which may be larger; slack: of the points themselves.
static double numerator_error(const kn_bezier *t, const kn_bezier *piece, const double acting[2], double slack)
{
    bool rational = piece->rational;
    int du = piece->degree[0], dv = piece->degree[1];
    double terms = 2.0 * (du + 1) * (dv + 1), g = kn_gamma(6.0 * (du + dv + 2));
    double size = kn_largest_vector(piece, 0, 3), far = slack * (rational ? acting[1] : 1.0);
    double gp = g * fmax(1.0, acting[0] / size) + far / size,
           gw = rational ? g * fmax(1.0, acting[1] / kn_largest_vector(piece, 3, 1)) : 0.0;
    double p = kn_largest_vector(&t[P], 0, 3), pu = kn_largest_vector(&t[PU], 0, 3),
           pv = kn_largest_vector(&t[PV], 0, 3);
    double ep = gp * p, epu = 2 * du * ep + kn_gamma(3) * pu, epv = 2 * dv * ep + kn_gamma(3) * pv;
    double round = 2.0 * kn_gamma(terms + 16), error = round * pu * pv + epu * pv + pu * epv + epu * epv;
    if (rational) {
        double w = kn_largest_vector(&t[W], 0, 1), wu = kn_largest_vector(&t[WU], 0, 1),
               wv = kn_largest_vector(&t[WV], 0, 1);
        double ew = gw * w, ewu = 2 * du * ew + kn_gamma(3) * wu, ewv = 2 * dv * ew + kn_gamma(3) * wv;
        double k = 2.0 * kn_gamma(3 * terms + 48);
        error = k * (w * pu * pv + wv * pu * p + wu * p * pv); // all roundings of all products and differences
        error += ew * pu * pv + w * (epu * pv + pu * epv);
        error += ewv * pu * p + wv * (epu * p + pu * ep);
        error += ewu * p * pv + wu * (ep * pv + p * epv);
    }
    return 1.01 * error;
}

// ---- edges ----

// Sets the rows from this edge inwards to zero for as long as they are zero within `near`; a row beyond the error of
// d raises that to `near`: then d is of the surface whose edge has collapsed exactly, and that is so far away.
static void clear_edge(kn_direction *d, double near, int var, bool at_end)
{
    kn_bezier *n = &d->n;
    int rows = n->degree[var] + 1, cross = n->degree[1 - var] + 1;
    size_t count = kn_bezier_count(n);
    for (int r = 0; r < rows - 1; r++) {
        size_t row = (size_t)(at_end ? rows - 1 - r : r), step = var == 0 ? 1 : (size_t)rows,
               first = var == 0 ? row * (size_t)cross : row;
        double largest = 0.0;
        for (size_t k = 0; k < (size_t)(3 * cross); k++) {
            double c = n->coef[k / (size_t)cross * count + first + k % (size_t)cross * step];
            largest = fmax(largest, fabs(c));
        }
        if (!(largest <= near)) return;
        if (largest > d->error) d->error = near;
        for (size_t k = 0; k < (size_t)(3 * cross); k++)
            n->coef[k / (size_t)cross * count + first + k % (size_t)cross * step] = 0.0;
    }
}

// Dividing by x scales coefficient i of degree n by n/i <= n.
static kn_status divide_edges(kn_ctx *ctx, kn_direction *d, double near)
{
    kn_status status = KN_OK;
    for (int e = 0; e < 4 && status == KN_OK; e++) {
        int var = e / 2, *order = &d->order[var][e % 2];
        clear_edge(d, near, var, e % 2);
        status = kn_bezier_divide_edge(ctx, &d->n, order, &d->n, var, e % 2);
        for (int k = 0; k < *order && status == KN_OK; k++) {
            d->error *= d->n.degree[var] + *order - k;
            near *= d->n.degree[var] + *order - k;
        }
    }
    return status;
}

kn_status kn_direction_init(kn_ctx *ctx, kn_direction *out, bool *zero, const kn_bezier *piece,
                            const double acting[2], double slack)
{
    kn_bezier t[NTEMP] = {0};
    kn_direction d = {0};
    kn_status status = factors(ctx, t, &d.exponent, piece);
    if (status == KN_OK) status = numerator(ctx, &d.n, t, piece->rational);
    if (status == KN_OK) {
        double near = numerator_error(t, piece, acting, slack);
        d.error = numerator_error(t, piece, acting, 0.0);
        *zero = !(kn_largest_vector(&d.n, 0, 3) > 2.0 * near);
        if (!*zero) status = divide_edges(ctx, &d, near);
    }
    if (status == KN_OK && !*zero) {
        *out = d;
        d = (kn_direction){0};
    }
    kn_direction_clear(ctx, &d);
    for (int i = 0; i < NTEMP; i++) kn_bezier_clear(ctx, &t[i]);
    return status;
}
