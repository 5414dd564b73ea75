// SPDX-License-Identifier: Apache-2.0
// kn_compose_matrix: the composition of one tile patch with every cell at once.
#include "compose/basis.h"

#include <knurl/compose.h>

// One column to the rows that `tile` (a patch, or one of its edges) stands for: row q of the tile's own coefficients
// is row first + q * step of the matrix, `step` < 0 for an edge that is seen backwards.
typedef struct target {
    kn_compose_matrix *matrix;
    size_t first;
    ptrdiff_t step;
} target;

static void write_column(const target *to, const kn_bezier *b, size_t column)
{
    ptrdiff_t n = (ptrdiff_t)kn_bezier_count(b), row = (ptrdiff_t)to->first;
    for (ptrdiff_t q = 0; q < n; q++, row += to->step)
        to->matrix->m[(size_t)row * to->matrix->cols + column] = b->coef[q];
}

typedef struct factors {
    kn_bezier *u, *v; // B_a(u) w^power and B_b(v)
    const int *degree;
} factors;

static kn_status make_factors(kn_ctx *ctx, factors *f, const kn_bezier *tile, int power)
{
    kn_bezier x = {0}, w = {0}, *wk = kn_compose_list(ctx, power + 1);
    kn_status status = wk ? kn_bezier_components(ctx, &x, tile, 0, 1) : KN_ENOMEM;
    if (status == KN_OK) status = kn_compose_basis(ctx, f->u, f->degree[0], &x, NULL);
    if (status == KN_OK) status = kn_bezier_components(ctx, &x, tile, 1, 1);
    if (status == KN_OK) status = kn_compose_basis(ctx, f->v, f->degree[1], &x, NULL);
    if (status == KN_OK) status = kn_bezier_components(ctx, &w, tile, 2, 1);
    if (status == KN_OK) status = kn_compose_powers(ctx, wk, power, &w);
    for (int a = 0; status == KN_OK && power > 0 && a <= f->degree[0]; a++)
        status = kn_bezier_product(ctx, &f->u[a], &f->u[a], &wk[power]);
    kn_bezier_clear(ctx, &x);
    kn_bezier_clear(ctx, &w);
    kn_compose_list_clear(ctx, wk, power + 1);
    return status;
}

// All columns, for a tile of one or two variables.
static kn_status fill(kn_ctx *ctx, const target *to, const kn_bezier *tile, const int degree[2], int power,
                      const int *rows_degree)
{
    factors f = {kn_compose_list(ctx, degree[0] + 1), kn_compose_list(ctx, degree[1] + 1), degree};
    kn_bezier column = {0};
    kn_status status = f.u && f.v ? make_factors(ctx, &f, tile, power) : KN_ENOMEM;
    size_t at = 0;
    for (int a = 0; status == KN_OK && a <= degree[0]; a++)
        for (int b = 0; status == KN_OK && b <= degree[1]; b++) {
            status = kn_bezier_product(ctx, &column, &f.u[a], &f.v[b]);
            if (status == KN_OK) status = kn_bezier_elevate(ctx, &column, &column, rows_degree);
            if (status == KN_OK) write_column(to, &column, at++);
        }
    kn_bezier_clear(ctx, &column);
    kn_compose_list_clear(ctx, f.u, degree[0] + 1);
    kn_compose_list_clear(ctx, f.v, degree[1] + 1);
    return status;
}

// Whether (u, v, w)(1 - x) comes before (u, v, w)(x) in the lexicographic order of coefficients.
static bool runs_backwards(const kn_bezier *edge)
{
    size_t n = (size_t)edge->degree[0] + 1;
    for (int c = 0; c < edge->ncomp; c++)
        for (size_t i = 0; i < n; i++) {
            double forward = edge->coef[(size_t)c * n + i], backward = edge->coef[(size_t)c * n + n - 1 - i];
            if (forward != backward) return backward < forward;
        }
    return false;
}

static void reverse(kn_bezier *edge)
{
    size_t n = (size_t)edge->degree[0] + 1;
    for (int c = 0; c < edge->ncomp; c++)
        for (size_t i = 0; i < n / 2; i++) {
            double *a = &edge->coef[(size_t)c * n + i], *b = &edge->coef[(size_t)c * n + n - 1 - i], t = *a;
            *a = *b;
            *b = t;
        }
}

// The rows of an edge depend on the edge alone, and edges that two patches share must get the same numbers, whichever
// patch they are computed from and whichever way it runs: so they are computed again from the edge by itself, in the
// direction that comes first in the lexicographic order.
static kn_status fill_edge(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile, int along, bool far,
                           const int degree[2], int power)
{
    kn_bezier edge = {0};
    kn_status status = kn_bezier_init(ctx, &edge, 1, 3, false, &tile->degree[along]);
    if (status != KN_OK) return status;
    size_t n = (size_t)tile->degree[along] + 1, count = kn_bezier_count(tile);
    size_t row = (size_t)tile->degree[1] + 1, step = along == 0 ? row : 1;
    size_t start = !far ? 0 : along == 0 ? row - 1 : count - row;
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < n; i++)
            edge.coef[(size_t)c * n + i] = tile->coef[(size_t)c * count + start + i * step];

    size_t rows_row = (size_t)out->rows_degree[1] + 1, length = (size_t)out->rows_degree[along];
    target to = {out,
                 !far         ? 0
                 : along == 0 ? rows_row - 1
                              : out->rows - rows_row,
                 along == 0 ? (ptrdiff_t)rows_row : 1};
    if (runs_backwards(&edge)) {
        reverse(&edge);
        to.first += length * (size_t)to.step;
        to.step = -to.step;
    }
    status = fill(ctx, &to, &edge, degree, power, &out->rows_degree[along]);
    kn_bezier_clear(ctx, &edge);
    return status;
}

static kn_status check(kn_ctx *ctx, const kn_bezier *tile, const int degree[2], int power, const int rows_degree[2])
{
    if (!tile->coef || tile->nvars != 2 || tile->ncomp != 3 || tile->rational)
        return kn_fail(ctx, KN_EDOMAIN, "compose matrix: a tile patch has two variables and three components");
    if (degree[0] < 0 || degree[1] < 0 || power < 0)
        return kn_fail(ctx, KN_EDOMAIN, "compose matrix: degrees %d, %d, power %d", degree[0], degree[1], power);
    if (degree[0] > KN_MAX_DEGREE || degree[1] > KN_MAX_DEGREE || power > KN_MAX_DEGREE)
        return kn_fail(ctx, KN_ELIMIT, "compose matrix: degrees %d, %d, power %d", degree[0], degree[1], power);
    for (int d = 0; d < 2; d++) {
        int least = tile->degree[d] * (degree[0] + degree[1] + power);
        if (least > KN_MAX_DEGREE || rows_degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "compose matrix: degree %d in variable %d",
                           least > rows_degree[d] ? least : rows_degree[d], d);
        if (rows_degree[d] < least)
            return kn_fail(ctx, KN_EDOMAIN, "compose matrix: degree %d in variable %d, but %d is asked for", least, d,
                           rows_degree[d]);
    }
    return KN_OK;
}

kn_status kn_compose_matrix_init(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile, const int degree[2],
                                 int power, const int rows_degree[2])
{
    kn_status status = check(ctx, tile, degree, power, rows_degree);
    if (status != KN_OK) return status;
    kn_compose_matrix m = {.rows_degree = {rows_degree[0], rows_degree[1]},
                           .rows = (size_t)(rows_degree[0] + 1) * (size_t)(rows_degree[1] + 1),
                           .cols = (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1)};
    m.m = kn_alloc(ctx, m.rows * m.cols, sizeof *m.m);
    if (!m.m) return KN_ENOMEM;
    status = fill(ctx, &(target){&m, 0, 1}, tile, degree, power, rows_degree);
    for (int edge = 0; status == KN_OK && edge < 4; edge++)
        status = fill_edge(ctx, &m, tile, edge >> 1, (edge & 1) != 0, degree, power);
    if (status == KN_OK)
        *out = m;
    else
        kn_compose_matrix_clear(ctx, &m);
    return status;
}

void kn_compose_matrix_clear(kn_ctx *ctx, kn_compose_matrix *matrix)
{
    if (!matrix) return;
    kn_free(ctx, matrix->m);
    *matrix = (kn_compose_matrix){0};
}
