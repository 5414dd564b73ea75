// SPDX-License-Identifier: Apache-2.0
// Where the edges of a patch go through a plane: from the edge's control points alone, whichever patch has them.
#include "slice/internal.h"

#include "kernel/bernstein.h"

#include <string.h>

// Sides as kn_solve_trace has them.
void kn_slice_take_edge(kn_slice_edge *e, const kn_bezier *p, int side)
{
    size_t n = kn_bezier_count(p), row = (size_t)p->degree[1] + 1;
    bool along_t = side < 2;
    size_t start = side == 1 ? (size_t)p->degree[0] * row : side == 3 ? row - 1 : 0, step = along_t ? 1 : row;
    e->degree = p->degree[along_t ? 1 : 0];
    e->reversed = false;
    int order = 0;
    for (int i = 0; order == 0 && 2 * i < e->degree; i++)
        for (int c = 0; order == 0 && c < p->ncomp; c++) {
            double a = p->coef[(size_t)c * n + start + (size_t)i * step];
            double b = p->coef[(size_t)c * n + start + (size_t)(e->degree - i) * step];
            order = (a > b) - (a < b);
        }
    e->reversed = order > 0;
    for (int c = 0; c < p->ncomp; c++)
        for (int i = 0; i <= e->degree; i++) {
            int from = e->reversed ? e->degree - i : i;
            e->coef[c][i] = p->coef[(size_t)c * n + start + (size_t)from * step];
        }
}

static void edge_point(double out[2], const kn_slice_edge *e, double t, bool rational)
{
    double basis[KN_MAX_DEGREE + 1], w = 1.0;
    size_t m = (size_t)e->degree + 1;
    kn_bernstein_basis(basis, e->degree, t);
    if (rational) kn_bernstein_contract(&w, e->coef[3], 1, (int)m, 1, basis);
    for (int c = 0; c < 2; c++) {
        kn_bernstein_contract(&out[c], e->coef[c], 1, (int)m, 1, basis);
        out[c] /= w;
    }
}

kn_status kn_slice_cut_edge(kn_ctx *ctx, kn_slice_edge *e, size_t *doubtful, double z, bool rational)
{
    for (int i = 0; i <= e->degree; i++) e->f[i] = e->coef[2][i] - z * (rational ? e->coef[3][i] : 1.0);
    e->changes.count = 0;
    kn_status status = kn_solve_sign_changes(ctx, &e->changes, doubtful, e->f, e->degree);
    size_t n = e->changes.count;
    if (status != KN_OK || n == 0) return status;
    e->points = kn_scratch(ctx, n, sizeof *e->points);
    if (!e->points) return KN_ENOMEM;
    for (size_t i = 0; i < n; i++) edge_point(e->points[i], e, e->changes.list[i].at, rational);
    for (size_t i = 0, j = n; e->reversed && i < j--; i++) {
        kn_sign_change a = e->changes.list[i], b = e->changes.list[j];
        double p[2];
        memcpy(p, e->points[i], sizeof p);
        memcpy(e->points[i], e->points[j], sizeof p);
        memcpy(e->points[j], p, sizeof p);
        e->changes.list[i] = (kn_sign_change){1.0 - b.at, !b.rise};
        e->changes.list[j] = (kn_sign_change){1.0 - a.at, !a.rise};
    }
    return KN_OK;
}

bool kn_slice_known_point(double out[2], const kn_slice_edge *edges, const double at[2])
{
    for (int side = 0; side < 4; side++) {
        if (at[side / 2] != (double)(side % 2)) continue;
        for (size_t i = 0; i < edges[side].changes.count; i++)
            if (edges[side].changes.list[i].at == at[1 - side / 2]) {
                memcpy(out, edges[side].points[i], 2 * sizeof *out);
                return true;
            }
    }
    return false;
}
