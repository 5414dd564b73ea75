// SPDX-License-Identifier: Apache-2.0
// What the edges of the domain are: curves, poles, or an apex.
#include "trivar/internal.h"

#include <math.h>

static const double alike = 1e-10; // normals that count as one: sines of angles

// True where all control points of the edge of S are one point, to 1e-12 of the surface's size and what the rounding
// of coordinates leaves.
static bool collapsed(double point[3], const kn_shell *shell, int var, int end)
{
    const kn_spline *s = &shell->surface;
    size_t count = kn_spline_count(s);
    kn_row row = kn_edge_row(s->count, var, end);
    const double *first = s->coef + row.first;
    for (size_t c = 0; c < 3; c++) point[c] = first[c * count] / (s->rational ? first[3 * count] : 1.0);
    return kn_one_point(s->coef, count, s->rational, &row, 1e-12 * shell->size + 2.0 * shell->slack);
}

// Whether all coefficients of n along the edge are parallel to the unit vector d, and n points its way. Each is off
// by the direction's error.
static bool along(const kn_direction *direction, int var, int end, const double d[3])
{
    const kn_bezier *n = &direction->n;
    size_t count = kn_bezier_count(n);
    kn_row row = kn_edge_row((const int[2]){n->degree[0] + 1, n->degree[1] + 1}, var, end);
    double largest = 0.0, off = 0.0, forward = 0.0;
    for (size_t k = 0; k < row.count; k++) {
        const double *c = n->coef + row.first + k * row.step;
        double a[3] = {c[0], c[count], c[2 * count]}, square = 0.0, x = 0.0;
        for (int i = 0; i < 3; i++) {
            double out = a[(i + 1) % 3] * d[(i + 2) % 3] - a[(i + 2) % 3] * d[(i + 1) % 3];
            square += a[i] * a[i], x += out * out;
            if (k == 0) forward += a[i] * d[i]; // at a corner: n has a direction there, and keeps it along the edge
        }
        largest = fmax(largest, square), off = fmax(off, x);
    }
    return forward > 0.0 && sqrt(off) <= alike * sqrt(largest) + 4.0 * direction->error;
}

kn_shell_edge kn_edge_of(const kn_shell *s, int var, int end)
{
    kn_shell_edge edge = {.kind = KN_EDGE_CURVE};
    double point[3], d[3], corner[2] = {0.0, 0.0};
    bool pole = collapsed(point, s, var, end);
    if (pole) edge.kind = KN_EDGE_POLE;
    for (int c = 0; c < 3 && pole; c++) edge.point[c] = point[c];
    int columns = s->nknots[1] - 1, spans = s->nknots[1 - var] - 1, row = end ? s->nknots[var] - 2 : 0;
    corner[var] = end;
    for (int j = 0; j < spans && s->direction; j++) {
        const kn_direction *here = &s->direction[var == 0 ? row * columns + j : j * columns + row];
        if (j == 0) (void)kn_direction_unit(d, &here->n, corner);
        if (here->order[var][end] > edge.order) edge.order = here->order[var][end];
        if (pole && !along(here, var, end, d)) edge.kind = KN_EDGE_APEX;
    }
    return edge;
}

void kn_shell_edges(const kn_shell *shell, kn_shell_edge edges[2][2])
{
    for (int e = 0; e < 4; e++) edges[e / 2][e % 2] = kn_edge_of(shell, e / 2, e % 2);
}
