// SPDX-License-Identifier: Apache-2.0
// The plan of one cell: its leaves, and what belongs to them.
#include "job/internal.h"

#include <math.h>

static void worsen(kn_normal_certificate *worst, const kn_normal_certificate *with)
{
    worst->length_error = fmax(worst->length_error, with->length_error);
    worst->angle_error = fmax(worst->angle_error, with->angle_error);
    worst->certified = worst->certified && with->certified;
}

const kn_job_patch *kn_job_leaf_patch(const kn_job_cell_plan *plan, const kn_job_leaf *leaf)
{
    return leaf->own ? &plan->own.list[leaf->key.patch] : &plan->job->patches[leaf->key.patch];
}

void kn_job_leaf_degree(const kn_job_leaf *leaf, int degree[KN_JOB_VARS])
{
    if (leaf->made.coef) {
        for (int d = 0; d < KN_JOB_VARS; d++) degree[d] = d < leaf->made.nvars ? leaf->made.degree[d] : 0;
        return;
    }
    kn_job_degree(&leaf->key, degree);
}

static void take_terms(kn_job_key *key, const kn_shell_piece *piece)
{
    key->exact = piece->exact;
    key->nterms = (uint8_t)piece->nterms;
    for (int t = 0; t < piece->nterms; t++) {
        for (int d = 0; d < 2; d++) key->degree[t][d] = (uint8_t)piece->term[t].degree[d];
        key->power[t] = (uint8_t)piece->power[t];
    }
}

// The largest degree of all terms, also of those that surfaces beyond shared edges have.
static void set_composed(kn_job_key *key, const kn_job *job, const kn_job_surface *s, const kn_job_patch *patch)
{
    int least[3][KN_JOB_VARS], degree[KN_JOB_VARS] = {0};
    kn_job_least_degrees(least, job, patch, key->whole);
    for (int v = 0; v < patch->d.nvars; v++) degree[v] = 1;
    for (int t = 0; t < key->nterms; t++) {
        const int term[2] = {key->degree[t][0], key->degree[t][1]};
        kn_job_raise(degree, (const int(*)[KN_JOB_VARS])least, term, key->power[t]);
    }
    for (int t = 0; t < s->nterms && key->whole && key->exact; t++) {
        const kn_job_term *shared = &job->terms[s->first_term + (size_t)t];
        const int term[2] = {shared->degree[0], shared->degree[1]};
        kn_job_raise(degree, (const int(*)[KN_JOB_VARS])least, term, shared->power);
    }
    for (int v = 0; v < KN_JOB_VARS; v++) key->composed[v] = (uint8_t)degree[v];
}

static void count_trim(kn_job_cell_plan *plan, const kn_trim *trim)
{
    size_t curves = (size_t)trim->ncurves, spans = 0;
    for (int k = 0; k < trim->ncurves; k++)
        spans += (size_t)kn_spline_spans(&trim->curves[k], 0) * (trim->curves[k].degree[0] > 1 ? 8 : 1);
    plan->trim_curves = curves > plan->trim_curves ? curves : plan->trim_curves;
    plan->trim_spans = spans > plan->trim_spans ? spans : plan->trim_spans;
}

kn_status kn_job_add_leaf(kn_ctx *ctx, kn_job_cell_plan *plan, kn_job_leaf *leaf)
{
    if (plan->count == plan->room) {
        int room = plan->room > 0 ? 2 * plan->room : 16;
        kn_job_leaf *leaves = kn_resize(ctx, plan->leaves, (size_t)room, sizeof *leaves);
        if (!leaves) return KN_ENOMEM;
        plan->leaves = leaves;
        plan->room = room;
    }
    if (leaf->piece >= 0) {
        const kn_shell_piece *piece = &plan->pieces.list[leaf->piece].piece;
        const kn_job_surface *surface = &plan->job->surfaces[plan->pieces.list[leaf->piece].surface];
        const kn_job_patch *patch = kn_job_leaf_patch(plan, leaf);
        take_terms(&leaf->key, piece);
        set_composed(&leaf->key, plan->job, surface, patch);
        worsen(&plan->normal, &piece->normal);
        plan->stand_in = fmax(plan->stand_in, piece->deviation * patch->top);
    }
    bool shifted = leaf->shift[0] != 0 || leaf->shift[1] != 0;
    if (leaf->own || leaf->alone || shifted || leaf->trim.nloops > 0 || leaf->made.coef || leaf->mesh.position)
        plan->shared = false;
    count_trim(plan, &leaf->trim);
    plan->leaves[plan->count++] = *leaf;
    leaf->trim = (kn_trim){0};
    leaf->made = (kn_bezier){0};
    leaf->mesh = (kn_mesh){0};
    return KN_OK;
}

kn_status kn_job_leaf_source(kn_ctx *ctx, kn_bezier *out, const kn_job_cell_plan *plan, const kn_job_leaf *leaf)
{
    const kn_job_piece *piece = &plan->pieces.list[leaf->piece];
    kn_bezier d = {0};
    kn_status status = kn_job_restrict(ctx, &d, kn_job_leaf_patch(plan, leaf), leaf->key.rect, leaf->key.turn);
    if (status != KN_OK) return status;
    size_t n = kn_bezier_count(&d);
    for (size_t c = 0; c < 2; c++) {
        double lo = piece->lo[c] + leaf->shift[c], width = piece->hi[c] - piece->lo[c];
        for (size_t i = 0; i < n; i++) d.coef[c * n + i] = (d.coef[c * n + i] - lo) / width;
    }
    kn_bezier_swap(out, &d);
    kn_bezier_clear(ctx, &d);
    return KN_OK;
}

void kn_job_cell_plan_clear(kn_ctx *ctx, kn_job_cell_plan *plan)
{
    for (int i = 0; i < plan->count; i++) {
        kn_trim_clear(ctx, &plan->leaves[i].trim);
        kn_bezier_clear(ctx, &plan->leaves[i].made);
        kn_mesh_clear(ctx, &plan->leaves[i].mesh);
    }
    kn_free(ctx, plan->leaves);
    kn_job_patches_clear(ctx, &plan->own);
    kn_job_pieces_end(ctx, &plan->pieces);
    *plan = (kn_job_cell_plan){0};
}
