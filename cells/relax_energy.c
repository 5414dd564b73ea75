// SPDX-License-Identifier: Apache-2.0
// How far cells are from rectangles of one size.
//
// A cell is cut into 2 x 2 parts, whose corners are the bilinear map's. p and q, the mean differences of a part's
// four images, are the cell's tangents there; in units of the wanted size the metric is
//     G = (p.p/L0^2, p.q/(L0 L1); ., q.q/L1^2), with eigenvalues a^2 >= b^2, and Hencky's logarithmic strain
//     h = area log^2(a b) 2 + log^2(a/b) / 2 = area log^2(det G) / 2 + 2 asinh^2(z),
//     z^2 = ((G11 - G22)^2 / 4 + G12^2) / det G.
// Halving counts as much as doubling, h is 0 for the wanted cell alone, and it grows slowly enough that the triangles
// at a pole do not outweigh everything else. The distortion is h + TAIL h^2 / 2, the beginning of an exponential,
// which puts what is far off before the rest. Parts, not whole cells: the mean differences of whole cells do not see
// corners that move in a checkerboard's way.
// Source: Neff, Ghiba & Lankeit, The exponentiated Hencky-logarithmic strain energy, J. Elasticity 121 (2015).
#include "cells/relax.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

bool kn_corner_moves(const kn_corner_grid *g, int i, int j, int d)
{
    const int at[2] = {i, j};
    if (at[d] == 0 || at[d] == g->n[d] || g->held[d][at[d]]) return false;
    for (int e = 0; e < 2; e++)
        if ((at[e] == 0 && g->fixed[e][0]) || (at[e] == g->n[e] && g->fixed[e][1])) return false;
    return true;
}

// (b - a) x (c - a) > 0, less the rounding of two differences, a product and a difference.
static bool turns_left(const double *a, const double *b, const double *c)
{
    double left = (b[0] - a[0]) * (c[1] - a[1]), right = (b[1] - a[1]) * (c[0] - a[0]);
    return left - right > 0x1p-49 * (fabs(left) + fabs(right)) + 0x1p-1000;
}

// The determinant of a bilinear map's derivative is linear in each variable and has no other term: its values at the
// corners bound it.
bool kn_corners_unfolded(const kn_corner_grid *g, const double *corners)
{
    size_t row = 2 * ((size_t)g->n[1] + 1);
    for (int i = 0; i < g->n[0]; i++)
        for (int j = 0; j < g->n[1]; j++) {
            const double *a = corners + (size_t)i * row + 2 * (size_t)j, *b = a + row, *c = a + 2, *d = b + 2;
            if (!(turns_left(a, b, c) && turns_left(b, d, a) && turns_left(d, c, b) && turns_left(c, a, d)))
                return false;
        }
    return true;
}

// ---- places: corners, middles of sides and of cells ----

typedef struct places {
    size_t rows, columns; // 2 n + 1
    double *at, *value;   // (u,v); S, S_u, S_v: 9 numbers
    double *pull;         // the derivative by S there: 3 numbers
} places;

size_t kn_relax_room(const kn_corner_grid *g)
{
    return (size_t)(2 * g->n[0] + 1) * (size_t)(2 * g->n[1] + 1) * 14;
}

static places places_of(const kn_corner_grid *g, double *room)
{
    places p = {.rows = 2 * (size_t)g->n[0] + 1, .columns = 2 * (size_t)g->n[1] + 1};
    p.at = room, p.value = p.at + 2 * p.rows * p.columns, p.pull = p.value + 9 * p.rows * p.columns;
    return p;
}

// The corners behind place (i,j), and their weight: 1, 2 or 4 of them.
static int behind(size_t at[4], const kn_corner_grid *g, size_t i, size_t j)
{
    size_t row = (size_t)g->n[1] + 1, first = i / 2 * row + j / 2;
    int n = 0;
    for (size_t a = 0; a <= i % 2; a++)
        for (size_t b = 0; b <= j % 2; b++) at[n++] = first + a * row + b;
    return n;
}

static void spread_corners(places *p, const kn_corner_grid *g, const double *corners)
{
    size_t at[4];
    for (size_t i = 0; i < p->rows; i++)
        for (size_t j = 0; j < p->columns; j++) {
            double *to = p->at + 2 * (i * p->columns + j), sum[2] = {0.0, 0.0};
            int n = behind(at, g, i, j);
            for (int k = 0; k < n; k++) sum[0] += corners[2 * at[k]], sum[1] += corners[2 * at[k] + 1];
            to[0] = sum[0] / n, to[1] = sum[1] / n;
        }
}

static void gather_pulls(double *gradient, const places *p, const kn_corner_grid *g)
{
    size_t at[4];
    memset(gradient, 0, 2 * kn_corner_count(g) * sizeof *gradient);
    for (size_t i = 0; i < p->rows; i++)
        for (size_t j = 0; j < p->columns; j++) {
            size_t k = i * p->columns + j;
            const double *s = p->value + 9 * k, *pull = p->pull + 3 * k;
            int n = behind(at, g, i, j);
            for (int d = 0; d < 2; d++) {
                const double *along = s + 3 + 3 * d;
                double by = (along[0] * pull[0] + along[1] * pull[1] + along[2] * pull[2]) / n;
                for (int m = 0; m < n; m++) gradient[2 * at[m] + (size_t)d] += by;
            }
        }
}

// ---- one part ----

static const double TAIL = 4.0;

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// The distortion of the part between these four places, and what pulls at their images.
static double part_energy(double *pull[4], const double *const image[4], const double size[2], double area)
{
    double p[3], q[3];
    for (int c = 0; c < 3; c++) {
        p[c] = (image[2][c] + image[3][c] - image[0][c] - image[1][c]) / size[0];
        q[c] = (image[1][c] + image[3][c] - image[0][c] - image[2][c]) / size[1];
    }
    double a = dot(p, p), b = dot(p, q), c = dot(q, q), det = a * c - b * b;
    if (!(det > 0.0) || isinf(det)) return INFINITY;
    double middle = 0.5 * (a + c), half = 0.5 * (a - c), z = sqrt((half * half + b * b) / det), log_det = log(det);
    double turn = asinh(z), root = sqrt(det);
    double slope = z > 1e-8 ? 2.0 * turn / z : 2.0; // of acosh^2 at x = middle / root = sqrt(1 + z^2)
    double strain = 0.5 * area * log_det * log_det + 2.0 * turn * turn, more = 1.0 + TAIL * strain;
    double by_det = more * (area * log_det / det - slope * middle / (root * det)),
           by_middle = more * 2.0 * slope / root;
    double by_a = by_det * c + 0.5 * by_middle, by_b = -2.0 * by_det * b, by_c = by_det * a + 0.5 * by_middle;
    for (int k = 0; k < 3; k++) {
        double by_p = (2.0 * by_a * p[k] + by_b * q[k]) / size[0], by_q = (2.0 * by_c * q[k] + by_b * p[k]) / size[1];
        pull[0][k] -= by_p + by_q;
        pull[1][k] += by_q - by_p;
        pull[2][k] += by_p - by_q;
        pull[3][k] += by_p + by_q;
    }
    return strain + 0.5 * TAIL * strain * strain;
}

// What may not move has no gradient; two ends that move together have one.
static void constrain(double *gradient, const kn_corner_grid *g)
{
    size_t row = (size_t)g->n[1] + 1;
    for (int i = 0; i <= g->n[0]; i++)
        for (int j = 0; j <= g->n[1]; j++) {
            double *own = gradient + 2 * ((size_t)i * row + (size_t)j);
            for (int d = 0; d < 2; d++)
                if (!kn_corner_moves(g, i, j, d)) own[d] = 0.0;
        }
    for (int d = 0; d < 2; d++)
        for (int k = 0; g->closed[d] && k <= g->n[1 - d]; k++) {
            size_t low = d == 0 ? (size_t)k : (size_t)k * row;
            size_t high = low + (d == 0 ? (size_t)g->n[0] * row : (size_t)g->n[1]);
            size_t other = (size_t)(1 - d);
            gradient[2 * low + other] += gradient[2 * high + other];
            gradient[2 * high + other] = 0.0;
        }
}

kn_status kn_relax_energy(kn_ctx *ctx, double *energy, double *gradient, const kn_corner_grid *g,
                          const double *corners, double *room)
{
    places p = places_of(g, room);
    size_t n = p.rows * p.columns;
    spread_corners(&p, g, corners);
    kn_status status = kn_spline_eval_batch_partials(ctx, p.value, g->surface, n, p.at);
    if (status != KN_OK) return status;
    memset(p.pull, 0, 3 * n * sizeof *p.pull);
    double sum = 0.0, parts = 4.0 * g->n[0] * g->n[1];
    for (size_t i = 0; i + 1 < p.rows; i++)
        for (size_t j = 0; j + 1 < p.columns; j++) {
            size_t at[4] = {i * p.columns + j};
            at[1] = at[0] + 1, at[2] = at[0] + p.columns, at[3] = at[2] + 1;
            const double *image[4];
            double *pull[4];
            for (int k = 0; k < 4; k++) image[k] = p.value + 9 * at[k], pull[k] = p.pull + 3 * at[k];
            sum += part_energy(pull, image, g->size, g->area);
        }
    *energy = isfinite(sum) ? sum / parts : INFINITY;
    gather_pulls(gradient, &p, g);
    for (size_t k = 0; k < 2 * kn_corner_count(g); k++) gradient[k] /= parts;
    constrain(gradient, g);
    return KN_OK;
}
