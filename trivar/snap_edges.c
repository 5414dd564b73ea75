// SPDX-License-Identifier: Apache-2.0
// Edges of S that are one point but for noise, as in surfaces from files and from other programs, become one point.
//
// Noise of a unit in the last place has a bound, with which N's factor is found (numerator.c). Coordinates with ten
// digits have more: the edge then is a hole of that size, or a knot of the surface, near which N turns by a right angle
// or vanishes. 1e-9 of the surface's size lies above what ten digits leave, and a thousand times below the default
// tolerance of normals: no texture tells a hole of that size from none.
#include "trivar/internal.h"

#include <math.h>

static const double limit = 1e-9, thin = 1e-4; // of the size of S

typedef struct box {
    double lo[3], hi[3];
} box;

static double spread(const box *b)
{
    return fmax(b->hi[0] - b->lo[0], fmax(b->hi[1] - b->lo[1], b->hi[2] - b->lo[2]));
}

// Grows b by the control points of edge e.
static void add_edge(box *b, const kn_spline *s, int e)
{
    size_t count = kn_spline_count(s);
    kn_row row = kn_edge_row(s->count, e / 2, e % 2);
    for (size_t k = 0; k < row.count; k++) {
        const double *p = s->coef + row.first + k * row.step;
        for (size_t c = 0; c < 3; c++) {
            double x = p[c * count] / (s->rational ? p[3 * count] : 1.0);
            b->lo[c] = fmin(b->lo[c], x), b->hi[c] = fmax(b->hi[c], x);
        }
    }
}

static box edge_box(const kn_spline *s, int e)
{
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    add_edge(&b, s, e);
    return b;
}

static void move_edge(kn_spline *s, int e, const box *b)
{
    size_t count = kn_spline_count(s);
    kn_row row = kn_edge_row(s->count, e / 2, e % 2);
    for (size_t k = 0; k < row.count; k++) {
        double *p = s->coef + row.first + k * row.step;
        for (size_t c = 0; c < 3; c++)
            p[c * count] = (0.5 * b->lo[c] + 0.5 * b->hi[c]) * (s->rational ? p[3 * count] : 1.0);
    }
}

void kn_snap_edges(kn_spline *s)
{
    kn_extent extent = kn_extent_of(s);
    box own[4], all;
    int small = 0;
    bool noisy = false, one[4];
    for (int e = 0; e < 4; e++) {
        own[e] = edge_box(s, e);
        one[e] = spread(&own[e]) <= limit * extent.size;
        if (one[e] && small++ == 0) all = own[e];
        if (one[e]) add_edge(&all, s, e);
        noisy = noisy || (one[e] && spread(&own[e]) > extent.slack);
    }
    if (!noisy || small == 4) return;
    bool meet = (one[0] || one[1]) && (one[2] || one[3]); // they share corners, and are one point together
    for (int e = 0; e < 4; e++)
        if (one[e] && (meet || spread(&own[e]) > extent.slack)) move_edge(s, e, meet ? &all : &own[e]);
}

const char *kn_thin_edge(const kn_shell *shell)
{
    static const char *const names[4] = {
        "; the edge at the low end of u is nearly one point: collapse it or trim it",
        "; the edge at the high end of u is nearly one point: collapse it or trim it",
        "; the edge at the low end of v is nearly one point: collapse it or trim it",
        "; the edge at the high end of v is nearly one point: collapse it or trim it",
    };
    for (int e = 0; e < 4 && shell->surface.coef; e++) {
        box b = edge_box(&shell->surface, e);
        double most = spread(&b);
        if (most > 2.0 * shell->slack && most > limit * shell->size && most <= thin * shell->size) return names[e];
    }
    return "";
}
