// SPDX-License-Identifier: Apache-2.0
// kn_tile_cover_faces: which faces of volumes lie on faces of others.
#include "tile/internal.h"

#include <math.h>
#include <stdlib.h>

// Coordinates this near, beside the largest, are equal: some roundings of what was modelled to be equal.
static const double near = 1e-12;

// Face 2 var + end of volume `of`. Turned faces have the same mean of w, and whole numbers of cells between their
// means of u and of v.
typedef struct face {
    size_t of;
    int var, end;
    double mean[3];
} face;

// Coefficient (i, j) of the face, in the order of the other two variables.
static size_t place(const kn_bezier *b, const face *f, int i, int j)
{
    int at[3], a = f->var == 0 ? 1 : 0, c = 3 - f->var - a;
    at[f->var] = f->end * b->degree[f->var];
    at[a] = i;
    at[c] = j;
    return ((size_t)at[0] * (size_t)(b->degree[1] + 1) + (size_t)at[1]) * (size_t)(b->degree[2] + 1) + (size_t)at[2];
}

static void sides(int degree[2], const kn_bezier *b, int var)
{
    degree[0] = b->degree[var == 0 ? 1 : 0];
    degree[1] = b->degree[var == 2 ? 1 : 2];
}

static void take_mean(face *f, const kn_bezier *b)
{
    int m[2];
    size_t n = kn_bezier_count(b);
    sides(m, b, f->var);
    for (int c = 0; c < 3; c++) {
        double sum = 0.0;
        for (int i = 0; i <= m[0]; i++)
            for (int j = 0; j <= m[1]; j++) sum += b->coef[(size_t)c * n + place(b, f, i, j)];
        f->mean[c] = sum / ((m[0] + 1) * (m[1] + 1));
    }
}

// Whether q, run through in way k of eight, is p moved by -cell.
static bool same_face(const kn_bezier *a, const face *p, const kn_bezier *b, const face *q, int k, const int cell[2],
                      double tol)
{
    int m[2], o[2];
    size_t na = kn_bezier_count(a), nb = kn_bezier_count(b);
    bool turned = (k & 4) != 0;
    sides(m, a, p->var);
    sides(o, b, q->var);
    if (m[0] != o[turned] || m[1] != o[!turned]) return false;
    for (int i = 0; i <= m[0]; i++)
        for (int j = 0; j <= m[1]; j++) {
            int x = k & 1 ? m[0] - i : i, y = k & 2 ? m[1] - j : j;
            const double *one = a->coef + place(a, p, i, j);
            const double *other = b->coef + (turned ? place(b, q, y, x) : place(b, q, x, y));
            for (size_t c = 0; c < 3; c++) {
                double moved = other[c * nb] + (c < 2 ? cell[c] : 0);
                if (!(fabs(one[c * na] - moved) <= tol)) return false;
            }
        }
    return true;
}

static void match(kn_tile_cover *cover, const kn_bezier *list, const face *p, const face *q, double tol)
{
    int cell[2];
    for (int c = 0; c < 2; c++) {
        double step = p->mean[c] - q->mean[c], whole = round(step);
        if (!(fabs(step - whole) <= tol) || fabs(whole) > 1e6) return;
        cell[c] = (int)whole;
    }
    if (p->of == q->of && cell[0] == 0 && cell[1] == 0) return; // a face that is folded onto another of its own
    kn_tile_cover *one = &cover[6 * p->of + 2 * (size_t)p->var + (size_t)p->end];
    kn_tile_cover *other = &cover[6 * q->of + 2 * (size_t)q->var + (size_t)q->end];
    if (one->covered || other->covered) return;
    for (int k = 0; k < 8; k++) {
        if (!same_face(&list[p->of], p, &list[q->of], q, k, cell, tol)) continue;
        *one = (kn_tile_cover){.covered = true, .by = q->of, .cell = {cell[0], cell[1]}};
        *other = (kn_tile_cover){.covered = true, .by = p->of, .cell = {-cell[0], -cell[1]}};
        return;
    }
}

static int compare(const void *a, const void *b)
{
    const face *x = a, *y = b;
    if (x->mean[2] != y->mean[2]) return x->mean[2] < y->mean[2] ? -1 : 1;
    return x->of != y->of ? (x->of > y->of) - (x->of < y->of) : 2 * (x->var - y->var) + x->end - y->end;
}

kn_status kn_tile_cover_faces(kn_ctx *ctx, kn_tile_cover *cover, const kn_bezier *list, size_t n)
{
    double most = 1.0;
    size_t nfaces = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    face *faces = kn_scratch(ctx, 6 * n + 1, sizeof *faces);
    if (!faces) return KN_ENOMEM;
    for (size_t i = 0; i < 6 * n; i++) cover[i] = (kn_tile_cover){0};
    for (size_t i = 0; i < n; i++) {
        if (list[i].nvars != 3 || list[i].ncomp != 3 || list[i].rational) continue;
        size_t count = 3 * kn_bezier_count(&list[i]);
        for (size_t k = 0; k < count; k++) most = fmax(most, fabs(list[i].coef[k]));
        for (int k = 0; k < 6; k++) {
            faces[nfaces] = (face){.of = i, .var = k / 2, .end = k % 2};
            take_mean(&faces[nfaces++], &list[i]);
        }
    }
    qsort(faces, nfaces, sizeof *faces, compare);
    double tol = near * most;
    kn_status status = KN_OK;
    for (size_t i = 0; status == KN_OK && i < nfaces; i++) {
        for (size_t j = i + 1; j < nfaces && faces[j].mean[2] - faces[i].mean[2] <= tol; j++)
            match(cover, list, &faces[i], &faces[j], tol);
        if (i % 256 == 255) status = kn_progress(ctx, "faces", (double)i / (double)nfaces);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
