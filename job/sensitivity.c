// SPDX-License-Identifier: Apache-2.0
// How the control points of a composed patch change with parameters of the tile, and with control points of the base.
//
// A patch is C = T(D), D the tile's. With a parameter x of the tile D moves by M = dD/dx, and in Bernstein form, term
// by term of the piece T = sum_t term_t(u,v) w^p_t,
//     dC/dx = (T_u o D) M_u + (T_v o D) M_v + (T_w o D) M_w.
// T is S + .. with S = sum_i P_i N_i, so that dC/dP_i = N_i(u,v) o D, the same for every coordinate.
#include "job/internal.h"
#include "job/vary.h"

#include <string.h>

// The leaf behind a patch, with its cell's plan.
typedef struct found {
    kn_job_cell_plan plan;
    const kn_job_leaf *leaf;
    kn_job_instance instance;
} found;

static void found_clear(kn_ctx *ctx, found *f)
{
    kn_job_cell_plan_clear(ctx, &f->plan);
}

static kn_status find_instance(kn_ctx *ctx, found *f, const kn_job *job, int id)
{
    kn_job_instance_list list = {0};
    kn_status status = kn_job_instances(ctx, &list, job, f->plan.surface, f->plan.cell);
    for (int i = 0; i < list.count; i++)
        if (list.list[i].id == id) f->instance = list.list[i];
    kn_free(ctx, list.list);
    if (status == KN_OK) status = kn_job_vary_instance(ctx, &f->instance, job, f->plan.surface, f->plan.cell);
    return status;
}

static kn_status find(kn_ctx *ctx, found *f, const kn_job *job, const kn_patch_id *id)
{
    size_t index;
    *f = (found){.leaf = NULL};
    if (!kn_job_find_cell(&index, job, id)) return kn_fail(ctx, KN_EDOMAIN, "job: no such patch");
    kn_status status = kn_job_plan_cell(ctx, &f->plan, job, index, false);
    if (status == KN_OK) f->leaf = kn_job_find_leaf(&f->plan, id);
    if (status == KN_OK && !f->leaf) status = kn_fail(ctx, KN_EDOMAIN, "job: no such patch");
    if (status == KN_OK && (f->leaf->made.coef || f->leaf->piece < 0))
        status = kn_fail(ctx, KN_EDOMAIN, "job: the patch is approximated, and no composition");
    if (status == KN_OK) status = find_instance(ctx, f, job, id->instance);
    if (status != KN_OK) found_clear(ctx, f);
    return status;
}

// The part of a patch that a leaf is of; d holds vectors: nothing is added.
static kn_status to_leaf(kn_ctx *ctx, kn_bezier *d, const found *f)
{
    const kn_job_leaf *leaf = f->leaf;
    const kn_job_patch *patch = kn_job_leaf_patch(&f->plan, leaf);
    const kn_job_piece *piece = &f->plan.pieces.list[leaf->piece];
    double map[3][4], zero[3] = {0.0, 0.0, 0.0};
    for (int c = 0; c < 3; c++)
        for (int k = 0; k < 4; k++) map[c][k] = k < 3 ? f->instance.map[c][k] : 0.0;
    kn_job_map_patch(d, (const double(*)[4])map);
    kn_status status = kn_bezier_restrict(ctx, d, d, patch->lo, patch->hi);
    if (status != KN_OK) return status;
    kn_job_patch vectors = {.d = *d};
    *d = (kn_bezier){0};
    status = kn_job_restrict(ctx, d, &vectors, leaf->key.rect, leaf->key.turn);
    kn_bezier_clear(ctx, &vectors.d);
    if (status != KN_OK) return status;
    kn_job_turn(zero, 1, 1, leaf->key.turn);
    size_t n = kn_bezier_count(d);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < n; i++) {
            double x = d->coef[c * n + i] - zero[c];
            d->coef[c * n + i] = c < 2 ? x / (piece->hi[c] - piece->lo[c]) : x;
        }
    return KN_OK;
}

// The derivative of a piece by u, v or w, of its homogeneous coordinates one by one; empty where it is 0.
static kn_status derive(kn_ctx *ctx, kn_shell_piece *out, const kn_shell_piece *piece, int var)
{
    kn_status status = KN_OK;
    *out = (kn_shell_piece){.nterms = 0};
    for (int t = 0; status == KN_OK && t < piece->nterms; t++) {
        kn_bezier term = piece->term[t], *to = &out->term[out->nterms];
        term.rational = false; // borrowed
        if (var == 2 && piece->power[t] == 0) continue;
        status = var < 2 ? kn_bezier_derivative(ctx, to, &term, var)
                         : kn_bezier_scale(ctx, to, &term, piece->power[t]);
        out->power[out->nterms++] = piece->power[t] - (var == 2);
    }
    return status;
}

// The patch behind a leaf, and the degrees of u, v and w in which it composes.
typedef struct source {
    kn_bezier d;
    int least[3][KN_JOB_VARS];
} source;

// out, of degrees at least those of the composition, += (piece)(D), with the matrices that compose the patch itself.
static kn_status add_composed(kn_ctx *ctx, kn_bezier *out, const kn_shell_piece *piece, const source *from)
{
    kn_status status = KN_OK;
    for (int t = 0; t < piece->nterms && status == KN_OK; t++) {
        const kn_bezier *term = &piece->term[t];
        kn_compose_matrix m = {0};
        status = kn_compose_matrix_init(ctx, &m, &from->d, term->degree, piece->power[t], out->degree,
                                        (const int(*)[KN_JOB_VARS])from->least);
        for (size_t c = 0; c < (size_t)out->ncomp && status == KN_OK; c++)
            for (size_t j = 0; j < m.cols; j++)
                for (size_t i = 0; i < m.rows; i++)
                    out->coef[c * m.rows + i] += m.m[j * m.rows + i] * term->coef[c * m.cols + j];
        kn_compose_matrix_clear(ctx, &m);
    }
    return status;
}

static kn_status init_zero(kn_ctx *ctx, kn_bezier *out, int nvars, int ncomp, const int *degree)
{
    kn_status status = kn_bezier_init(ctx, out, nvars, ncomp, false, degree);
    if (status == KN_OK) memset(out->coef, 0, (size_t)ncomp * kn_bezier_count(out) * sizeof *out->coef);
    return status;
}

// out += (d_var T)(D) M_var in the composed degree. M_var has the degrees of the component that it moves.
static kn_status add_part(kn_ctx *ctx, kn_bezier *out, const kn_shell_piece *piece, const source *from,
                          const kn_bezier *move, int var)
{
    kn_shell_piece slope = {.nterms = 0};
    kn_bezier along = {0}, one = {0};
    int degree[KN_JOB_VARS] = {0};
    kn_status status = derive(ctx, &slope, piece, var);
    for (int t = 0; t < slope.nterms && status == KN_OK; t++)
        kn_job_raise(degree, (const int(*)[KN_JOB_VARS])from->least, slope.term[t].degree, slope.power[t]);
    if (status == KN_OK && slope.nterms > 0) {
        status = init_zero(ctx, &along, out->nvars, out->ncomp, degree);
        if (status == KN_OK) status = add_composed(ctx, &along, &slope, from);
        if (status == KN_OK) status = kn_bezier_components(ctx, &one, move, var, 1);
        if (status == KN_OK) status = kn_bezier_reduce(ctx, &one, NULL, &one, from->least[var]);
        if (status == KN_OK) status = kn_bezier_product(ctx, &along, &along, &one);
        if (status == KN_OK) status = kn_bezier_elevate(ctx, &along, &along, out->degree);
        size_t n = (size_t)out->ncomp * kn_bezier_count(out);
        for (size_t i = 0; status == KN_OK && i < n; i++) out->coef[i] += along.coef[i];
    }
    kn_bezier_clear(ctx, &along);
    kn_bezier_clear(ctx, &one);
    kn_shell_piece_clear(ctx, &slope);
    return status;
}

static kn_status find_source(kn_ctx *ctx, source *out, const found *f)
{
    kn_job_least_degrees(out->least, f->plan.job, kn_job_leaf_patch(&f->plan, f->leaf), f->leaf->key.whole);
    return kn_job_leaf_source(ctx, &out->d, &f->plan, f->leaf);
}

kn_status kn_job_parameter_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_job *job, const kn_patch_id *id,
                                       int parameter)
{
    if (parameter < 0 || parameter >= job->tile.nparameters)
        return kn_fail(ctx, KN_EDOMAIN, "job: no parameter %d: the tile has %d", parameter, job->tile.nparameters);
    found f;
    kn_status status = find(ctx, &f, job, id);
    if (status != KN_OK) return status;
    const kn_job_patch *patch = kn_job_leaf_patch(&f.plan, f.leaf);
    const kn_shell_piece *piece = &f.plan.pieces.list[f.leaf->piece].piece;
    kn_bezier move = {0}, sum = {0};
    source from = {.d = {0}};
    int degree[KN_JOB_VARS];
    kn_job_leaf_degree(f.leaf, degree);
    status = kn_job_vary_slope(ctx, &move, job, f.plan.surface, f.plan.cell, &f.instance, patch->part, patch->spline,
                               patch->patch, parameter);
    if (status == KN_OK) status = to_leaf(ctx, &move, &f);
    if (status == KN_OK) status = find_source(ctx, &from, &f);
    if (status == KN_OK) status = init_zero(ctx, &sum, from.d.nvars, piece->term[0].ncomp, degree);
    for (int var = 0; status == KN_OK && var < 3; var++) status = add_part(ctx, &sum, piece, &from, &move, var);
    if (status == KN_OK) kn_bezier_swap(out, &sum);
    kn_bezier_clear(ctx, &move);
    kn_bezier_clear(ctx, &from.d);
    kn_bezier_clear(ctx, &sum);
    found_clear(ctx, &f);
    return status;
}

// ---- the base ----

// N_i over the box of a piece.
static kn_status basis_function(kn_ctx *ctx, kn_bezier *out, const kn_job *job, const kn_job_piece *piece,
                                const int index[2])
{
    const kn_job_surface *s = &job->surfaces[piece->surface];
    const kn_spline *base = kn_shell_surface(s->shell);
    const double *knots[2] = {base->knots[0], base->knots[1]};
    double lo[2], hi[2];
    kn_spline one = {0};
    kn_bezier *pieces = NULL;
    size_t n = 0;
    for (int d = 0; d < 2; d++) {
        int cell = piece->cell[d], cells = s->cells[d];
        if (s->closed[d]) cell = (cell % cells + cells) % cells;
        if (cell < 0) cell = 0;
        if (cell >= cells) cell = cells - 1;
        double from = s->lines[d][cell], step = s->lines[d][cell + 1] - from;
        lo[d] = from + (piece->lo[d] + (s->closed[d] ? 0 : piece->cell[d] - cell)) * step;
        hi[d] = from + (piece->hi[d] + (s->closed[d] ? 0 : piece->cell[d] - cell)) * step;
    }
    kn_status status = kn_spline_init(ctx, &one, 2, 1, false, base->degree, base->count, knots, NULL);
    if (status == KN_OK) one.coef[(size_t)index[0] * (size_t)base->count[1] + (size_t)index[1]] = 1.0;
    if (status == KN_OK) status = kn_spline_restrict(ctx, &one, &one, lo, hi);
    if (status == KN_OK) status = kn_spline_to_bezier(ctx, &pieces, &n, &one);
    if (status == KN_OK && n != 1) status = kn_fail(ctx, KN_EDOMAIN, "job: the patch crosses a knot of the base");
    if (status == KN_OK) kn_bezier_swap(out, &pieces[0]);
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    kn_spline_clear(ctx, &one);
    return status;
}

kn_status kn_job_base_sensitivity(kn_ctx *ctx, kn_bezier *out, const kn_job *job, const kn_patch_id *id, int surface,
                                  const int index[2])
{
    const kn_shell *shell = kn_job_shell(job, surface);
    if (!shell) return kn_fail(ctx, KN_EDOMAIN, "job: no surface %d", surface);
    const kn_spline *base = kn_shell_surface(shell);
    double w[2];
    kn_shell_heights(shell, w);
    if (w[0] == 0.0) return kn_fail(ctx, KN_EDOMAIN, "job: a volume has no surface whose control points would move");
    for (int d = 0; d < 2; d++)
        if (index[d] < 0 || index[d] >= base->count[d])
            return kn_fail(ctx, KN_EDOMAIN, "job: surface %d has no control point %d, %d", surface, index[0],
                           index[1]);
    found f;
    kn_status status = find(ctx, &f, job, id);
    if (status != KN_OK) return status;
    const kn_job_piece *piece = &f.plan.pieces.list[f.leaf->piece];
    kn_shell_piece basis = {.nterms = 1}; // N_i w^0
    kn_bezier made = {0};
    source from = {.d = {0}};
    int degree[KN_JOB_VARS];
    kn_job_leaf_degree(f.leaf, degree);
    status = find_source(ctx, &from, &f);
    if (status == KN_OK) status = init_zero(ctx, &made, from.d.nvars, 1, degree);
    if (status == KN_OK && piece->surface == surface) {
        status = basis_function(ctx, &basis.term[0], job, piece, index);
        if (status == KN_OK) status = add_composed(ctx, &made, &basis, &from);
    }
    if (status == KN_OK) kn_bezier_swap(out, &made);
    kn_shell_piece_clear(ctx, &basis);
    kn_bezier_clear(ctx, &from.d);
    kn_bezier_clear(ctx, &made);
    found_clear(ctx, &f);
    return status;
}
