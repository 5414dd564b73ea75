// SPDX-License-Identifier: Apache-2.0
// The pieces of cells that follow one another, without an object for each.
#include "kernel/bernstein.h"
#include "kernel/context.h"
#include "trivar/piece.h"

#include <limits.h>
#include <string.h>

// A term of T: its polynomials over the intervals between breaks, restricted along u where the last cell lay.
typedef struct source {
    const kn_bezier *pieces;
    double *const *breaks;
    int columns; // intervals along v
    bool of_normal;
    const kn_bezier *piece; // NULL: none yet
    double *half;           // it, restricted along u
} source;

// What restricts along v, transposed; terms of one degree over one interval have it in common.
typedef struct turned {
    double lo, hi;
    int degree; // -1: none yet
    double *matrix;
} turned;

typedef struct walk {
    const kn_shell *shell;
    kn_piece_box along_u; // KN_PIECE_BOX placed along u
    source source[KN_SHELL_TERMS];
    int count;
    turned v;
    double *work; // of a restriction
} walk;

static source of_spans(const kn_shell *s, const kn_bezier *span)
{
    return (source){.pieces = span, .breaks = s->knot, .columns = s->nknots[1] - 1};
}

// Whether T's terms are splines as they are, without a product of two.
static bool list_sources(walk *w)
{
    const kn_shell *s = w->shell;
    if (!kn_shell_has_terms(s)) return false;
    bool weighted = s->span[0].rational && !s->homogeneous;
    w->source[w->count++] = of_spans(s, s->span);
    if (s->kind == KN_SHELL_NORMAL) {
        if (s->thickness.whole.coef) return false;
        w->source[w->count++] = (source){
            .pieces = s->normal_piece, .breaks = s->cut, .columns = s->ncuts[1] - 1, .of_normal = true};
    }
    for (int k = 0; k < s->nfields; k++) w->source[w->count++] = of_spans(s, s->field[k].span);
    return !weighted || w->count == 1;
}

static size_t larger(size_t a, size_t b)
{
    return a > b ? a : b;
}

static kn_status make_room(kn_ctx *ctx, walk *w, const kn_shell_piece *like)
{
    size_t most = 0, side = 0;
    for (int t = 0; t < like->nterms; t++) {
        const kn_bezier *f = &like->term[t];
        size_t n = (size_t)f->ncomp * kn_bezier_count(f);
        most = larger(most, n);
        side = larger(side, (size_t)larger((size_t)f->degree[0], (size_t)f->degree[1]) + 1);
        w->source[t].half = kn_scratch(ctx, n, sizeof *w->source[t].half);
        if (!w->source[t].half) return KN_ENOMEM;
    }
    w->work = kn_scratch(ctx, side * side, sizeof *w->work);
    w->v = (turned){.degree = -1, .matrix = kn_scratch(ctx, side * side, sizeof *w->v.matrix)};
    return w->work && w->v.matrix ? KN_OK : KN_ENOMEM;
}

// The polynomial of a term where the box lies; NULL when it is not of the shape that is asked for.
static const kn_bezier *find_piece(const source *from, const kn_piece_box *b, const kn_bezier *like)
{
    const int *at = from->of_normal ? b->cut : b->span;
    const kn_bezier *p = &from->pieces[(size_t)at[0] * (size_t)from->columns + (size_t)at[1]];
    bool same = p->ncomp == like->ncomp && p->degree[0] == like->degree[0] && p->degree[1] == like->degree[1];
    return same ? p : NULL;
}

// As kn_bezier_restrict does: an axis that stays as it is keeps its bits.
static void restrict_u(walk *w, source *from, const kn_piece_box *b, const kn_bezier *piece)
{
    const int *at = from->of_normal ? b->cut : b->span;
    int m = piece->degree[0] + 1;
    size_t n = (size_t)piece->degree[1] + 1, outer = (size_t)piece->ncomp;
    double lo, hi;
    kn_piece_local(&lo, &hi, b, 0, from->breaks[0], at[0]);
    from->piece = piece;
    if (lo == 0.0 && hi == 1.0) {
        memcpy(from->half, piece->coef, outer * (size_t)m * n * sizeof *from->half);
        return;
    }
    kn_bernstein_restriction(w->work, m - 1, lo, hi);
    kn_bernstein_transform(from->half, piece->coef, outer, m, m, n, w->work);
}

// What restricts to the box along v; NULL: nothing is to be done.
static const double *matrix_v(walk *w, const source *from, const kn_piece_box *b, int degree)
{
    const int *at = from->of_normal ? b->cut : b->span;
    double lo, hi;
    kn_piece_local(&lo, &hi, b, 1, from->breaks[1], at[1]);
    if (lo == 0.0 && hi == 1.0) return NULL;
    turned *v = &w->v;
    if (v->degree == degree && v->lo == lo && v->hi == hi) return v->matrix;
    size_t side = (size_t)degree + 1;
    kn_bernstein_restriction(w->work, degree, lo, hi);
    for (size_t r = 0; r < side; r++)
        for (size_t k = 0; k < side; k++) v->matrix[k * side + r] = w->work[r * side + k];
    v->lo = lo, v->hi = hi, v->degree = degree;
    return v->matrix;
}

// One cell; false: its piece is to be had in another way.
static bool write_cell(walk *w, double *rows, const kn_shell_piece *like, size_t row, int cell)
{
    kn_piece_box b = w->along_u;
    const kn_bezier *piece[KN_SHELL_TERMS];
    kn_piece_place(&b, w->shell, 1, cell, 0.0, 1.0);
    if (b.crosses[0] || b.crosses[1] || !b.plain) return false;
    for (int t = 0; t < w->count; t++)
        if (!(piece[t] = find_piece(&w->source[t], &b, &like->term[t]))) return false;
    size_t first = 0;
    for (int t = 0; t < w->count; t++) {
        source *from = &w->source[t];
        if (from->piece != piece[t]) restrict_u(w, from, &b, piece[t]);
        int m = piece[t]->degree[0] + 1, n = piece[t]->degree[1] + 1;
        size_t count = (size_t)m * (size_t)n;
        const double *v = matrix_v(w, from, &b, n - 1);
        for (size_t c = 0; c < (size_t)piece[t]->ncomp; c++) {
            double *to = rows + c * row + first;
            const double *half = from->half + c * count;
            if (v)
                kn_bernstein_transform_rows(to, half, (size_t)m, n, n, v);
            else
                memcpy(to, half, count * sizeof *to);
        }
        first += count;
    }
    return true;
}

kn_status kn_shell_piece_rows(kn_ctx *ctx, double *rows, int *made, const kn_shell *shell, const kn_shell_piece *like,
                              const int cell[2], int n)
{
    walk w = {.shell = shell, .along_u = KN_PIECE_BOX};
    size_t row = 0;
    if (n < 0 || cell[1] > INT_MAX - n || like->nterms < 1 || like->nterms > KN_SHELL_TERMS)
        return kn_fail(ctx, KN_EDOMAIN, "shell piece: rows of %d cells with %d terms", n, like->nterms);
    if (!list_sources(&w) || w.count != like->nterms) {
        *made = 0;
        return KN_OK;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = make_room(ctx, &w, like);
    for (int t = 0; t < like->nterms; t++) row += kn_bezier_count(&like->term[t]);
    if (status == KN_OK) kn_piece_place(&w.along_u, shell, 0, cell[0], 0.0, 1.0);
    size_t each = row * (size_t)like->term[0].ncomp;
    int k = 0;
    while (status == KN_OK && k < n && write_cell(&w, rows + (size_t)k * each, like, row, cell[1] + k)) k++;
    if (status == KN_OK) *made = k;
    kn_scratch_release(ctx, mark);
    return status;
}
