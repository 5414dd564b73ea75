// SPDX-License-Identifier: Apache-2.0
// kn_bezier_substitute: one variable replaced by a function of it.
#include "compose/substitute.h"
#include "bezier/shape.h"
#include "compose/nest.h"
#include "kernel/bernstein.h"
#include "kernel/binomial.h"

#include <knurl/compose.h>

#include <string.h>

kn_status kn_substitution_check(kn_ctx *ctx, const char *call, int p, int nvars, int dim, int degree)
{
    if (nvars != 1 || dim != 1)
        return kn_fail(ctx, KN_EDOMAIN, "%s: a function of %d variables with %d components", call, nvars, dim);
    if (p * degree > KN_MAX_DEGREE) return kn_fail(ctx, KN_ELIMIT, "%s: degree %d", call, p * degree);
    return KN_OK;
}

// The basis is the composition with p + 1 components, component c having the coefficients (0 .. 1 .. 0).
kn_status kn_substitution_init(kn_ctx *ctx, kn_substitution *out, int p, const kn_bezier *g, double lo, double hi)
{
    size_t m = (size_t)g->degree[0] + 1, columns = (size_t)p + 1, rows = (size_t)(p * g->degree[0]) + 1;
    kn_bezier unit = {.nvars = 1, .ncomp = p + 1, .degree = {p}};
    *out = (kn_substitution){.p = p, .rows = (int)rows};
    out->matrix = kn_scratch(ctx, rows * columns, sizeof *out->matrix);
    out->weight = g->rational ? kn_scratch(ctx, rows, sizeof *out->weight) : NULL;
    if (!out->matrix || (g->rational && !out->weight)) return KN_ENOMEM;
    kn_mark mark = kn_scratch_mark(ctx);
    kn_nest *nest = kn_scratch(ctx, 1, sizeof *nest);
    double *factor = kn_scratch(ctx, 2 * m, sizeof *factor), *value = NULL;
    unit.coef = kn_scratch(ctx, columns * columns, sizeof *unit.coef);
    kn_status status = nest && factor && unit.coef ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (size_t i = 0; i < columns * columns; i++) unit.coef[i] = i % (columns + 1) == 0;
        kn_nest_plan(nest, &unit, g);
        value = kn_scratch(ctx, columns * nest->room[p], sizeof *value);
        status = value ? kn_nest_factors(ctx, factor, nest, g, &lo, &hi) : KN_ENOMEM;
    }
    if (status == KN_OK) status = kn_nest_run(ctx, value, nest, &unit, factor);
    for (size_t i = 0; status == KN_OK && i < columns; i++)
        for (size_t k = 0; k < rows; k++) out->matrix[k * columns + i] = value[i * nest->room[p] + k];
    if (status == KN_OK && g->rational) {
        status = kn_nest_power(ctx, value, nest, g->coef + m);
        memcpy(out->weight, value, rows * sizeof *value);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

void kn_substitution_apply(double *out, const double *in, size_t inner, const kn_substitution *map)
{
    kn_bernstein_transform(out, in, 1, map->rows, map->p + 1, inner, map->matrix);
    for (int k = 0; k < map->rows; k++)
        for (size_t j = 0; j < inner; j++) out[(size_t)k * inner + j] /= kn_binomial(map->rows - 1, k);
}

void kn_substitution_weight(double *out, size_t inner, const kn_substitution *map)
{
    for (int k = 0; k < map->rows; k++)
        for (size_t j = 0; j < inner; j++)
            out[(size_t)k * inner + j] = map->weight[k] / kn_binomial(map->rows - 1, k);
}

// value = a's components with the variable replaced, and the weight that a lacks.
static void replace(double *value, const kn_bezier *a, int var, const kn_substitution *map, bool weight)
{
    kn_axis axis = kn_bezier_axis(a, var);
    size_t from = ((size_t)map->p + 1) * axis.inner, to = (size_t)map->rows * axis.inner;
    for (size_t o = 0; o < axis.outer; o++)
        kn_substitution_apply(value + o * to, a->coef + o * from, axis.inner, map);
    for (size_t o = axis.outer; weight && o < axis.outer / (size_t)a->ncomp * ((size_t)a->ncomp + 1); o++)
        kn_substitution_weight(value + o * to, axis.inner, map);
}

static kn_status substitute(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var, const kn_bezier *g)
{
    bool weight = g->rational && !a->rational;
    kn_bezier result = *a;
    result.rational = a->rational || g->rational;
    result.ncomp += weight;
    result.degree[var] *= g->degree[0];
    kn_status status = kn_bezier_check(ctx, "substitute", result.nvars, result.ncomp, result.rational, result.degree);
    if (status != KN_OK) return status;
    kn_substitution map;
    status = kn_substitution_init(ctx, &map, a->degree[var], g, 0.0, 1.0);
    if (status == KN_OK) status = kn_bezier_begin(ctx, &result, out, kn_bezier_is(out, a), "substitute");
    if (status != KN_OK) return status;
    replace(result.coef, a, var, &map, weight);
    kn_bezier_end(ctx, out, &result);
    return KN_OK;
}

kn_status kn_bezier_substitute(kn_ctx *ctx, kn_bezier *out, const kn_bezier *a, int var, const kn_bezier *g)
{
    kn_status status = kn_bezier_check_operand(ctx, "substitute", a);
    if (status == KN_OK) status = kn_bezier_check_operand(ctx, "substitute", g);
    if (status == KN_OK) status = kn_bezier_check_var(ctx, "substitute", a, var);
    if (status == KN_OK)
        status = kn_substitution_check(ctx, "substitute", a->degree[var], g->nvars, kn_bezier_dim(g), g->degree[0]);
    if (status != KN_OK) return status;
    kn_mark mark = kn_scratch_mark(ctx);
    status = substitute(ctx, out, a, var, g);
    kn_scratch_release(ctx, mark);
    return status;
}
