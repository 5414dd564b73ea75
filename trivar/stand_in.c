// SPDX-License-Identifier: Apache-2.0
// One polynomial in place of the unit normal over a box, or N times one in place of 1/|N|: interpolation at
// Chebyshev-Lobatto sites, whose ends are the box's edges, so that an edge of the stand-in depends on that edge and
// its degree alone.
#include "kernel/banded.h"
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/internal.h"

#include <math.h>

enum { HIGHEST = 16, ROOM = HIGHEST + 1 };
static const double most_work = 1e7; // multiply-adds for one box, some milliseconds: a smaller box may be easier

// The sites of degree n in [0,1], exact at both ends.
static void lobatto(double *site, int n)
{
    const double pi = 3.14159265358979323846;
    for (int k = 0; k <= n; k++) site[k] = k == n ? 1.0 : 0.5 - 0.5 * cos(pi * k / n);
}

// ---- which degrees? ----

// The unit normal at n + 1 sites along a line; or, of exact directions, 1/|N| in units of its least value there,
// which makes errors those of the length.
static bool sample_line(double f[ROOM][3], const kn_bezier *direction, int var, double across, const double *site,
                        int n, bool exact)
{
    double x[2], length[ROOM], most = 0.0;
    x[1 - var] = across;
    for (int k = 0; k <= n; k++) {
        x[var] = site[k];
        length[k] = kn_direction_length(f[k], direction, x);
        if (!(length[k] > 0.0)) return false;
        most = fmax(most, length[k]);
    }
    for (int k = 0; k <= n && exact; k++) f[k][0] = most / length[k], f[k][1] = f[k][2] = 0.0;
    return true;
}

// rest[k] = sum over j > k of the Chebyshev coefficients |c_j| of what is interpolated in variable var, the largest
// of three lines: about the error of interpolation of degree k. False where the normal vanishes.
static bool decay(double rest[ROOM], const kn_bezier *direction, int var, int n, bool exact)
{
    double site[ROOM], f[ROOM][3], c[ROOM];
    lobatto(site, n);
    for (int k = 0; k <= n; k++) rest[k] = 0.0;
    for (int line = 0; line < 3; line++) {
        if (!sample_line(f, direction, var, 0.5 * line, site, n, exact)) return false;
        for (int k = 0; k <= n; k++) {
            double sum[3] = {0}, end = k == 0 || k == n ? 0.5 : 1.0;
            for (int j = 0; j <= n; j++) {
                int m = j * k % (2 * n); // cos(pi j k / n) from the sites: 1 - 2 site
                double w = (1.0 - 2.0 * site[m <= n ? m : 2 * n - m]) * (j == 0 || j == n ? 0.5 : 1.0);
                for (int d = 0; d < 3; d++) sum[d] += w * f[j][d];
            }
            c[k] = 2.0 * end / n * sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
        }
        double tail = 0.0;
        for (int k = n; k > 0; k--) {
            rest[k] = fmax(rest[k], tail);
            tail += c[k];
        }
        rest[0] = fmax(rest[0], tail);
    }
    rest[n] = 0.5 * rest[n - 1]; // nothing is known beyond n: no better than this
    return true;
}

static int enough(const double rest[ROOM], int n, double limit)
{
    int k = 1;
    while (k <= n && !(rest[k] <= limit)) k++;
    return k;
}

// ---- interpolation ----

// Values at the sites of Bernstein degree p become coefficients.
static kn_status to_bernstein(kn_ctx *ctx, double *data, int p, const double *site, size_t outer, size_t inner)
{
    double knots[2 * ROOM];
    int span[ROOM];
    for (int i = 0; i <= p; i++) knots[i] = 0.0, knots[p + 1 + i] = 1.0, span[i] = p;
    kn_collocation c = {.count = p + 1, .degree = p};
    c.band = kn_scratch(ctx, kn_collocation_room(c.count, p), sizeof *c.band);
    if (!c.band) return KN_ENOMEM;
    kn_collocation_factor(&c, knots, site, span);
    kn_collocation_solve(&c, data, outer, inner);
    return KN_OK;
}

// The unit normal, or 1/|N|.
static kn_status interpolate(kn_ctx *ctx, kn_bezier *out, const kn_bezier *direction, const int degree[2], bool exact)
{
    double site[2][ROOM], unit[3];
    kn_status status = kn_bezier_init(ctx, out, 2, exact ? 1 : 3, false, degree);
    if (status != KN_OK) return status;
    size_t nu = (size_t)degree[0] + 1, nv = (size_t)degree[1] + 1;
    for (int v = 0; v < 2; v++) lobatto(site[v], degree[v]);
    for (size_t i = 0; i < nu; i++)
        for (size_t j = 0; j < nv; j++) {
            double length = kn_direction_length(unit, direction, (const double[2]){site[0][i], site[1][j]});
            if (exact) unit[0] = length > 0.0 ? 1.0 / length : 0.0;
            for (size_t c = 0; c < (size_t)out->ncomp; c++) out->coef[(c * nu + i) * nv + j] = unit[c];
        }
    kn_mark mark = kn_scratch_mark(ctx);
    status = to_bernstein(ctx, out->coef, degree[0], site[0], (size_t)out->ncomp, nv);
    if (status == KN_OK) status = to_bernstein(ctx, out->coef, degree[1], site[1], (size_t)out->ncomp * nu, 1);
    kn_scratch_release(ctx, mark);
    return status;
}

static kn_status try_degrees(kn_ctx *ctx, kn_bezier *out, kn_normal_certificate *certificate, bool *fits,
                             const kn_bezier *direction, const kn_certify_options *o, const int degree[2], bool exact)
{
    kn_bezier m = {0};
    double length, angle;
    kn_normal_certificate found = {.certified = false};
    kn_status status = interpolate(ctx, &m, direction, degree, exact);
    if (status == KN_OK && exact) status = kn_bezier_product(ctx, &m, direction, &m);
    if (status == KN_OK) {
        kn_sample_errors(&length, &angle, &m, direction);
        if (length <= o->limit && angle <= o->limit) status = kn_certify(ctx, &found, &m, direction, o);
    }
    *fits = status == KN_OK && found.certified;
    if (*fits) {
        kn_bezier_swap(out, &m);
        *certificate = found;
    }
    kn_bezier_clear(ctx, &m);
    return status;
}

kn_status kn_stand_in(kn_ctx *ctx, kn_bezier *out, kn_normal_certificate *certificate, bool *fits,
                      const kn_bezier *direction, double direction_error, double limit, int degree_sum, bool exact)
{
    if (exact) degree_sum -= direction->degree[0] + direction->degree[1];
    double rest[2][ROOM];
    int n = degree_sum > HIGHEST ? HIGHEST : degree_sum > 2 ? degree_sum - 1 : 2, degree[2];
    *fits = false;
    for (int v = 0; v < 2; v++) { // the certificate multiplies it with the direction, and with itself
        int most = (exact ? KN_MAX_DEGREE / 2 : KN_MAX_DEGREE) - direction->degree[v];
        if (n > most) n = most;
    }
    if (exact && (n < 2 || degree_sum < 2)) return KN_OK;
    if (n < 2) n = 2;
    for (int v = 0; v < 2; v++) {
        if (!decay(rest[v], direction, v, n, exact)) return KN_OK;
        degree[v] = enough(rest[v], n, limit);
    }
    kn_certify_options o = {.limit = limit, .target = {limit, limit}, .direction_error = direction_error};
    double work = most_work;
    o.work = &work;
    kn_status status = KN_OK;
    while (status == KN_OK && !*fits && work >= 0.0 && degree[0] + degree[1] <= degree_sum && degree[0] <= n &&
           degree[1] <= n) {
        status = try_degrees(ctx, out, certificate, fits, direction, &o, degree, exact);
        degree[rest[1][degree[1]] > rest[0][degree[0]]]++;
    }
    return status;
}
