// SPDX-License-Identifier: Apache-2.0
// kn_compose_matrix: the composition of one tile patch with every cell at once.
#include "compose/basis.h"

#include <knurl/compose.h>

#include <math.h>
#include <string.h>

enum { VARS = 3 };

// One column to the rows that a tile (a patch, or one of its faces, edges, corners) stands for: row (i_0, i_1, ..) of
// its own coefficients is row first + sum of i_v step[v] of the matrix, a step < 0 where it is seen backwards.
typedef struct target {
    kn_compose_matrix *matrix;
    ptrdiff_t first, step[VARS];
    int rows_degree[VARS];
    bool whole; // all rows, as they are
} target;

static void write_column(const target *to, const kn_bezier *b, size_t column)
{
    const int *last = to->rows_degree; // 0 in variables that b has not
    const double *from = b->coef;
    double *m = to->matrix->m + column * to->matrix->rows + to->first;
    if (to->whole) {
        memcpy(m, from, to->matrix->rows * sizeof *m);
        return;
    }
    for (int i = 0; i <= last[0]; i++)
        for (int j = 0; j <= last[1]; j++)
            for (int k = 0; k <= last[2]; k++) m[i * to->step[0] + j * to->step[1] + k * to->step[2]] = *from++;
}

// The components of a tile, or of a part of one, each of the least degree in each variable that it has but for
// rounding: where u runs along r alone and v along t alone, products have much lower degrees than those of the tile, and
// along an edge between cells, where one of them is constant, they do not depend on S's degree across it. Of u and v the
// rounding of numbers near 1 counts, of w that of its own size.
typedef struct components {
    kn_bezier x[3];
} components;

static void components_clear(kn_ctx *ctx, components *c)
{
    for (int k = 0; k < 3; k++) kn_bezier_clear(ctx, &c->x[k]);
}

// most: degrees that are not passed; NULL: any.
static kn_status components_init(kn_ctx *ctx, components *c, const kn_bezier *tile, const int most[3][VARS])
{
    const double rounding = 0x1p-48;
    kn_status status = KN_OK;
    for (int k = 0; k < 3 && status == KN_OK; k++) {
        int degree[KN_MAX_VARS];
        double size = k < 2 ? 1.0 : 0.0;
        status = kn_bezier_components(ctx, &c->x[k], tile, k, 1);
        size_t n = status == KN_OK ? kn_bezier_count(&c->x[k]) : 0;
        for (size_t i = 0; i < n; i++) size = fmax(size, fabs(c->x[k].coef[i]));
        if (status == KN_OK && tile->nvars > 0)
            status = kn_bezier_least_degree(ctx, degree, &c->x[k], rounding * size);
        bool lower = false;
        for (int v = 0; v < tile->nvars && status == KN_OK; v++) {
            if (most && degree[v] > most[k][v]) degree[v] = most[k][v];
            lower = lower || degree[v] < tile->degree[v];
        }
        if (status == KN_OK && lower) status = kn_bezier_reduce(ctx, &c->x[k], NULL, &c->x[k], degree);
    }
    return status;
}

typedef struct factors {
    kn_bezier *u, *v; // B_a(u) w^power and B_b(v)
    const int *degree;
} factors;

static kn_status make_factors(kn_ctx *ctx, factors *f, const components *c, int power)
{
    kn_bezier *wk = kn_compose_list(ctx, power + 1);
    kn_status status = wk ? kn_compose_basis(ctx, f->u, f->degree[0], &c->x[0], NULL) : KN_ENOMEM;
    if (status == KN_OK) status = kn_compose_basis(ctx, f->v, f->degree[1], &c->x[1], NULL);
    if (status == KN_OK) status = kn_compose_powers(ctx, wk, power, &c->x[2]);
    for (int a = 0; status == KN_OK && power > 0 && a <= f->degree[0]; a++)
        status = kn_bezier_product(ctx, &f->u[a], &f->u[a], &wk[power]);
    kn_compose_list_clear(ctx, wk, power + 1);
    return status;
}

// All columns, for a tile of any number of variables.
static kn_status fill(kn_ctx *ctx, const target *to, const components *c, const int degree[2], int power)
{
    factors f = {kn_compose_list(ctx, degree[0] + 1), kn_compose_list(ctx, degree[1] + 1), degree};
    kn_bezier column = {0};
    kn_status status = f.u && f.v ? make_factors(ctx, &f, c, power) : KN_ENOMEM;
    size_t at = 0;
    for (int a = 0; status == KN_OK && a <= degree[0]; a++)
        for (int b = 0; status == KN_OK && b <= degree[1]; b++) {
            status = kn_bezier_product(ctx, &column, &f.u[a], &f.v[b]);
            if (status == KN_OK) status = kn_bezier_elevate(ctx, &column, &column, to->rows_degree);
            if (status == KN_OK) write_column(to, &column, at++);
        }
    kn_bezier_clear(ctx, &column);
    kn_compose_list_clear(ctx, f.u, degree[0] + 1);
    kn_compose_list_clear(ctx, f.v, degree[1] + 1);
    return status;
}

// ---- faces, edges and corners ----

// A way to run through a part of a patch: variable v of the way is free variable of[v] of the patch, backwards or not.
typedef struct way {
    int nvars, of[VARS];
    bool back[VARS];
} way;

// Where the coefficients of the part lie: at the ends that are fixed, and along the ways.
typedef struct layout {
    ptrdiff_t first, step[VARS];
    int degree[VARS];
} layout;

static layout lay_out(const way *w, const int *degree, int nvars, const int *fixed)
{
    layout l = {0};
    ptrdiff_t stride[VARS], n = 1;
    for (int v = nvars - 1; v >= 0; n *= degree[v--] + 1) stride[v] = n;
    for (int v = 0; v < nvars; v++)
        if (fixed[v] == 1) l.first += degree[v] * stride[v];
    for (int v = 0; v < w->nvars; v++) {
        l.degree[v] = degree[w->of[v]];
        l.step[v] = w->back[v] ? -stride[w->of[v]] : stride[w->of[v]];
        if (w->back[v]) l.first += l.degree[v] * stride[w->of[v]];
    }
    return l;
}

// The part of the tile, run through that way.
static kn_status part_of(kn_ctx *ctx, kn_bezier *out, const kn_bezier *tile, const way *w, const int *fixed)
{
    layout l = lay_out(w, tile->degree, tile->nvars, fixed);
    kn_bezier part = {0};
    kn_status status = kn_bezier_init(ctx, &part, w->nvars, 3, false, l.degree);
    if (status != KN_OK) return status;
    size_t n = kn_bezier_count(tile), at = 0;
    for (size_t c = 0; c < 3; c++)
        for (int i = 0; i <= l.degree[0]; i++)
            for (int j = 0; j <= l.degree[1]; j++)
                for (int k = 0; k <= l.degree[2]; k++) {
                    ptrdiff_t from = l.first + i * l.step[0] + j * l.step[1] + k * l.step[2];
                    part.coef[at++] = tile->coef[c * n + (size_t)from];
                }
    kn_bezier_swap(out, &part);
    kn_bezier_clear(ctx, &part);
    return KN_OK;
}

// Degrees, then coefficients, in lexicographic order.
static bool comes_before(const kn_bezier *a, const kn_bezier *b)
{
    for (int v = 0; v < a->nvars; v++)
        if (a->degree[v] != b->degree[v]) return a->degree[v] < b->degree[v];
    size_t n = 3 * kn_bezier_count(a);
    for (size_t i = 0; i < n; i++)
        if (a->coef[i] != b->coef[i]) return a->coef[i] < b->coef[i];
    return false;
}

// Rows of a face, an edge or a corner depend on it alone, and those that two patches share must get the same numbers,
// whichever patch they are computed from and whichever way it runs: so they are computed again from that part by
// itself, in the way that comes first of all (at most eight). fixed[v]: -1 free, else the end.
static kn_status fill_part(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile, const int most[3][VARS],
                           const int *fixed, const int degree[2], int power)
{
    way w = {0}, best;
    kn_bezier part = {0}, least = {0};
    kn_status status = KN_OK;
    for (int v = 0; v < tile->nvars; v++)
        if (fixed[v] < 0) w.of[w.nvars++] = v;
    best = w;
    int ways = w.nvars == 2 ? 8 : w.nvars == 1 ? 2 : 1;
    for (int k = 0; status == KN_OK && k < ways; k++) {
        for (int v = 0; v < w.nvars; v++) w.back[v] = (k >> v & 1) != 0;
        if (k == 4) {
            int first = w.of[0];
            w.of[0] = w.of[1], w.of[1] = first;
        }
        status = part_of(ctx, &part, tile, &w, fixed);
        if (status != KN_OK || (k > 0 && !comes_before(&part, &least))) continue;
        kn_bezier_swap(&least, &part);
        best = w;
    }
    if (status == KN_OK) {
        layout l = lay_out(&best, out->rows_degree, tile->nvars, fixed);
        target to = {.matrix = out, .first = l.first};
        for (int v = 0; v < best.nvars; v++) to.step[v] = l.step[v], to.rows_degree[v] = l.degree[v];
        int limit[3][VARS];
        components c = {0};
        for (int k = 0; k < 3; k++)
            for (int v = 0; v < best.nvars; v++) limit[k][v] = most[k][best.of[v]];
        status = components_init(ctx, &c, &least, (const int(*)[VARS])limit);
        if (status == KN_OK) status = fill(ctx, &to, &c, degree, power);
        components_clear(ctx, &c);
    }
    kn_bezier_clear(ctx, &part);
    kn_bezier_clear(ctx, &least);
    return status;
}

// Parts of ever fewer variables: each replaces what the larger ones have put on it.
static kn_status fill_parts(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile, const int most[3][VARS],
                            const int degree[2], int power)
{
    int parts = tile->nvars == 3 ? 27 : tile->nvars == 2 ? 9 : 3;
    kn_status status = KN_OK;
    for (int nfree = tile->nvars - 1; nfree >= 0; nfree--)
        for (int k = 0; status == KN_OK && k < parts; k++) {
            int fixed[VARS], n = 0;
            for (int v = 0, rest = k; v < tile->nvars; v++, rest /= 3) {
                fixed[v] = rest % 3 - 1;
                n += fixed[v] < 0;
            }
            if (n == nfree) status = fill_part(ctx, out, tile, most, fixed, degree, power);
        }
    return status;
}

static kn_status check(kn_ctx *ctx, const kn_bezier *tile, const int degree[2], int power)
{
    if (!tile->coef || tile->nvars < 1 || tile->nvars > VARS || tile->ncomp != 3 || tile->rational)
        return kn_fail(ctx, KN_EDOMAIN,
                       "compose matrix: a tile patch has one to three variables and three components");
    if (degree[0] < 0 || degree[1] < 0 || power < 0)
        return kn_fail(ctx, KN_EDOMAIN, "compose matrix: degrees %d, %d, power %d", degree[0], degree[1], power);
    if (degree[0] > KN_MAX_DEGREE || degree[1] > KN_MAX_DEGREE || power > KN_MAX_DEGREE)
        return kn_fail(ctx, KN_ELIMIT, "compose matrix: degrees %d, %d, power %d", degree[0], degree[1], power);
    return KN_OK;
}

static kn_status check_rows(kn_ctx *ctx, const components *c, int nvars, const int degree[2], int power,
                            const int *rows_degree)
{
    size_t rows = 1;
    for (int d = 0; d < nvars; d++) {
        int least = c->x[0].degree[d] * degree[0] + c->x[1].degree[d] * degree[1] + c->x[2].degree[d] * power;
        if (least > KN_MAX_DEGREE || rows_degree[d] > KN_MAX_DEGREE)
            return kn_fail(ctx, KN_ELIMIT, "compose matrix: degree %d in variable %d",
                           least > rows_degree[d] ? least : rows_degree[d], d);
        if (rows_degree[d] < least)
            return kn_fail(ctx, KN_EDOMAIN, "compose matrix: degree %d in variable %d, but %d is asked for", least, d,
                           rows_degree[d]);
        rows *= (size_t)rows_degree[d] + 1;
    }
    if (rows > (size_t)KN_MAX_COEFS) return kn_fail(ctx, KN_ELIMIT, "compose matrix: %zu rows", rows);
    return KN_OK;
}

kn_status kn_compose_matrix_init(kn_ctx *ctx, kn_compose_matrix *out, const kn_bezier *tile, const int degree[2],
                                 int power, const int *rows_degree, const int (*most)[3])
{
    kn_compose_matrix m = {.rows = 1, .cols = (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1)};
    target whole = {.matrix = &m, .whole = true};
    components c = {0};
    int found[3][VARS] = {{0}};
    kn_status status = check(ctx, tile, degree, power);
    if (status == KN_OK) status = components_init(ctx, &c, tile, most);
    if (status == KN_OK) status = check_rows(ctx, &c, tile->nvars, degree, power, rows_degree);
    for (int d = tile->nvars - 1; d >= 0 && status == KN_OK; d--) {
        for (int k = 0; k < 3; k++) found[k][d] = c.x[k].degree[d];
        m.rows_degree[d] = whole.rows_degree[d] = rows_degree[d];
        whole.step[d] = (ptrdiff_t)m.rows;
        m.rows *= (size_t)rows_degree[d] + 1;
    }
    if (status == KN_OK && !(m.m = kn_alloc(ctx, m.rows * m.cols, sizeof *m.m))) status = KN_ENOMEM;
    if (status == KN_OK) status = fill(ctx, &whole, &c, degree, power);
    if (status == KN_OK) status = fill_parts(ctx, &m, tile, (const int(*)[VARS])found, degree, power);
    components_clear(ctx, &c);
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
