// SPDX-License-Identifier: Apache-2.0
// Composing the cells of one block.
#include "job/looks.h"
#include "job/run.h"
#include "kernel/gemm.h"

#include <stdlib.h>
#include <string.h>

typedef struct composer {
    const kn_job *job;
    const kn_job_matrix *matrices;
    int surface, ncomp;
    kn_job_bands bands;
    int left;             // cells from the current one on that share its list and its row
    kn_job_pieces pieces; // of the current cell
    const double **rows;  // of these pieces, as many as have been asked for
    int nrows, rows_room;
    kn_job_product *product;
    uint64_t *order;         // key << 32 | patch, for those that a matrix composes
    const double **operand;  // ncomp rows for each patch, one after the other: where they start
    size_t norder, at, used; // patches and coefficients made
    size_t npatches, numbers;
    int *steps; // of the current cell's colours: kn_job_find_steps
} composer;

enum {
    MOST_KEPT = 1 << 20, // numbers, and patches / 16, of a product that is kept for another block
    LINE = 8,            // numbers of a line of the caches
};

void kn_job_product_clear(kn_ctx *ctx, kn_job_product *p)
{
    for (size_t i = 0; i < p->nplans; i++) kn_job_cell_plan_clear(ctx, &p->plans[i]);
    kn_free(ctx, p->plans);
    kn_free(ctx, p->patches);
    kn_free(ctx, p->memory);
    *p = (kn_job_product){0};
}

void kn_job_product_empty(kn_ctx *ctx, kn_job_product *p)
{
    if (p->coef_room > MOST_KEPT || p->patches_room > MOST_KEPT / 16) {
        kn_job_product_clear(ctx, p);
        return;
    }
    for (size_t i = 0; i < p->nplans; i++) kn_job_cell_plan_clear(ctx, &p->plans[i]);
    p->nplans = 0;
    p->block = (kn_patch_block){0};
}

// An empty product with room for the block's patches, which are zero, and their control points, which are not.
static kn_status make_room(kn_ctx *ctx, kn_job_product *p, const kn_job_block *b)
{
    if (b->npatches > p->patches_room) {
        kn_free(ctx, p->patches);
        p->patches = kn_alloc(ctx, b->npatches, sizeof *p->patches);
        p->patches_room = p->patches ? b->npatches : 0;
    }
    if (b->numbers > p->coef_room) {
        kn_free(ctx, p->memory);
        p->memory = kn_alloc(ctx, b->numbers + LINE, sizeof *p->memory);
        p->coef_room = p->memory ? b->numbers : 0;
        size_t past = (uintptr_t)p->memory / sizeof *p->memory % LINE;
        p->coef = p->memory ? p->memory + (past > 0 ? LINE - past : 0) : NULL;
    }
    if ((!p->patches && b->npatches > 0) || (!p->coef && b->numbers > 0)) return KN_ENOMEM;
    if (b->npatches > 0) memset(p->patches, 0, b->npatches * sizeof *p->patches);
    return KN_OK;
}

// The control points of a piece, a row of [term 0 | term 1 ..] for each component; in scratch memory.
static const double *piece_rows(kn_ctx *ctx, const kn_shell_piece *piece, int ncomp)
{
    size_t row = 0;
    for (int t = 0; t < piece->nterms; t++) row += kn_bezier_count(&piece->term[t]);
    double *rows = kn_scratch(ctx, (size_t)ncomp * row, sizeof *rows), *to = rows;
    for (size_t c = 0; rows && c < (size_t)ncomp; c++)
        for (int t = 0; t < piece->nterms; t++) {
            size_t n = kn_bezier_count(&piece->term[t]);
            memcpy(to, piece->term[t].coef + c * n, n * sizeof *rows);
            to += n;
        }
    return rows;
}

static kn_status compose_symbolic(kn_ctx *ctx, const composer *c, const kn_bezier *d, const kn_shell_piece *piece,
                                  const kn_patch *patch)
{
    kn_bezier out = {0};
    kn_status status = kn_compose_piece(ctx, &out, piece, d);
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &out, &out, patch->bezier.degree);
    if (status == KN_OK)
        memcpy(patch->bezier.coef, out.coef, (size_t)c->ncomp * kn_bezier_count(&out) * sizeof *out.coef);
    kn_bezier_clear(ctx, &out);
    return status;
}

// A patch that lies in its cell by a matrix of its own: unlike symbolic composition it gives an edge, a corner or a
// face the same bits as any other patch that has it.
static kn_status compose_alone(kn_ctx *ctx, const composer *c, const kn_job_patch *tile, const kn_job_key *key,
                               const kn_bezier *d, const kn_shell_piece *piece, const kn_patch *patch)
{
    kn_job_matrix m = {0};
    kn_mark mark = kn_scratch_mark(ctx);
    const double *from = piece_rows(ctx, piece, c->ncomp);
    kn_status status = from ? kn_job_make_matrix(ctx, &m, d, c->job, tile, key) : KN_ENOMEM;
    double *work = status == KN_OK ? kn_scratch(ctx, m.k, sizeof *work) : NULL;
    if (status == KN_OK && !work) status = KN_ENOMEM;
    for (size_t k = 0; status == KN_OK && k < (size_t)c->ncomp; k++) {
        double *to = patch->bezier.coef + k * m.n;
        const double *row = from + k * m.k;
        kn_gemm(&to, &row, 1, m.packed, m.k, m.n, work);
    }
    kn_free(ctx, m.packed);
    kn_scratch_release(ctx, mark);
    return status;
}

// The next patch of the block, with room for its control points; NULL: the plan is not what it was.
static kn_patch *next_patch(kn_ctx *ctx, composer *c, const kn_job_patch *from, const kn_job_key *key,
                            uint32_t instance, const int cell[2], const int degree[KN_JOB_VARS], int nvars, int ncomp)
{
    size_t numbers = nvars > 0 ? (size_t)ncomp * kn_job_numbers(degree) : 0;
    if (c->at >= c->npatches || numbers > c->numbers - c->used) {
        (void)kn_fail(ctx, KN_EUNDECIDED, "job: cell %d,%d is not what it was in the plan", cell[0], cell[1]);
        return NULL;
    }
    const kn_job_surface *s = &c->job->surfaces[c->surface];
    kn_patch *to = &c->product->patches[c->at++];
    to->id = (kn_patch_id){.surface = s->origin,
                           .cell = {s->origin_cell[0] + cell[0], s->origin_cell[1] + cell[1]},
                           .part = from ? from->part : 0,
                           .patch = from ? from->patch : 0,
                           .instance = (int)instance};
    if (c->at > 1) {
        const kn_patch_id *before = &c->product->patches[c->at - 2].id;
        bool same = before->surface == to->id.surface && before->part == to->id.part &&
                    before->patch == to->id.patch && before->instance == to->id.instance &&
                    before->cell[0] == to->id.cell[0] && before->cell[1] == to->id.cell[1];
        to->id.piece = same ? before->piece + 1 : 0;
    }
    to->body = s->body;
    to->look = kn_job_look_of(c->job, to->id.part, c->steps);
    to->reversed = (c->job->options.height < 0.0) != (from && from->mirrored);
    to->exact = key->exact;
    kn_job_segments(c->job, key, to->segments);
    kn_job_coarsen(c->job, s->first_cell + (size_t)cell[0] * (size_t)s->cells[1] + (size_t)cell[1], to->segments);
    if (nvars > 0) {
        to->bezier = (kn_bezier){.nvars = nvars, .ncomp = ncomp, .rational = ncomp == 4};
        for (int d = 0; d < nvars; d++) to->bezier.degree[d] = degree[d];
        to->bezier.coef = c->product->coef + c->used;
        c->used += numbers;
    }
    return to;
}

// ---- by matrix ----

static kn_status use_matrix(kn_ctx *ctx, composer *c, uint32_t key, int index, const kn_shell_piece *piece)
{
    if (index >= c->rows_room) {
        int room = 2 * index + 16;
        const double **rows = kn_scratch(ctx, (size_t)room, sizeof *rows);
        if (!rows) return KN_ENOMEM;
        if (c->nrows > 0) memcpy(rows, c->rows, (size_t)c->nrows * sizeof *rows);
        c->rows = rows;
        c->rows_room = room;
    }
    for (; c->nrows <= index; c->nrows++) c->rows[c->nrows] = NULL;
    if (!c->rows[index]) c->rows[index] = piece_rows(ctx, piece, c->ncomp);
    if (!c->rows[index]) return KN_ENOMEM;
    c->operand[c->at - 1] = c->rows[index];
    c->order[c->norder++] = (uint64_t)key << 32 | (c->at - 1);
    return KN_OK;
}

static int compare_order(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

// The patch just begun, which lies in a whole cell whose piece comes from a band; *found: it does.
static kn_status use_band(kn_ctx *ctx, composer *c, bool *found, uint32_t key, const int cell[2])
{
    const kn_job_key *k = &c->job->keys.list[key];
    const double *rows;
    kn_job_place place = kn_job_find_place(c->job, c->surface, cell, c->job->patches[k->patch].offset);
    kn_status status = kn_job_bands_get(ctx, &rows, &c->bands, &place, k, c->left);
    if (status != KN_OK) return status;
    *found = rows != NULL;
    if (!rows) return KN_OK;
    c->operand[c->at - 1] = rows;
    c->order[c->norder++] = (uint64_t)key << 32 | (c->at - 1);
    return KN_OK;
}

// Patches of one key, one matrix product: a row for each component of each patch.
static kn_status multiply(kn_ctx *ctx, const composer *c, const uint64_t *order, size_t n)
{
    const kn_job_matrix *m = &c->matrices[order[0] >> 32];
    size_t ncomp = (size_t)c->ncomp, rows = n * ncomp;
    kn_mark mark = kn_scratch_mark(ctx);
    double **to = kn_scratch(ctx, rows, sizeof *to), *work = kn_scratch(ctx, rows * m->k, sizeof *work);
    const double **from = kn_scratch(ctx, rows, sizeof *from);
    for (size_t i = 0; to && from && work && i < n; i++) {
        size_t patch = order[i] & UINT32_MAX;
        for (size_t k = 0; k < ncomp; k++) {
            to[i * ncomp + k] = c->product->patches[patch].bezier.coef + k * m->n;
            from[i * ncomp + k] = c->operand[patch] + k * m->k;
        }
    }
    if (to && from && work) kn_gemm(to, from, rows, m->packed, m->k, m->n, work);
    kn_scratch_release(ctx, mark);
    return to && from && work ? KN_OK : KN_ENOMEM;
}

static kn_status multiply_all(kn_ctx *ctx, composer *c)
{
    bool sorted = true; // as they are where all cells ask for one key
    for (size_t i = 1; i < c->norder; i++) sorted = sorted && c->order[i - 1] < c->order[i];
    if (!sorted) qsort(c->order, c->norder, sizeof *c->order, compare_order);
    kn_status status = KN_OK;
    for (size_t i = 0, n; status == KN_OK && i < c->norder; i += n) {
        for (n = 1; i + n < c->norder && c->order[i + n] >> 32 == c->order[i] >> 32;) n++;
        status = multiply(ctx, c, c->order + i, n);
    }
    return status;
}

// ---- cells that share a list ----

// The piece that a leaf asks for: the same call as the plan's, and so the same answer.
static kn_status leaf_piece(kn_ctx *ctx, composer *c, int *index, const kn_job_key *key, const int cell[2])
{
    const kn_job_patch *p = &c->job->patches[key->patch];
    kn_job_place place = kn_job_find_place(c->job, c->surface, cell, p->offset);
    double lo[2] = {0.0, 0.0}, hi[2] = {1.0, 1.0};
    if (!key->whole) {
        kn_bezier d = {0};
        kn_status status = kn_job_restrict(ctx, &d, p, key->rect, key->turn);
        if (status != KN_OK) return status;
        kn_job_box(lo, hi, &d);
        kn_bezier_clear(ctx, &d);
    }
    return kn_job_pieces_get(ctx, index, &c->pieces, &place, lo, hi);
}

static kn_status compose_ref(kn_ctx *ctx, composer *c, kn_job_ref ref, const int cell[2])
{
    const kn_job_key *key = &c->job->keys.list[ref.key];
    const kn_job_patch *from = &c->job->patches[key->patch];
    int degree[KN_JOB_VARS], index = 0;
    kn_job_degree(key, degree);
    kn_patch *to = next_patch(ctx, c, from, key, ref.instance, cell, degree, from->d.nvars, c->ncomp);
    if (!to) return KN_EUNDECIDED;
    if (from->d.nvars == 3 &&
        kn_job_hide_faces(ctx, &to->hidden, c->job, from, &key->rect, c->surface, cell) != KN_OK)
        return kn_ctx_error(ctx);
    bool found = false;
    kn_status status = KN_OK;
    if (key->whole && c->matrices[ref.key].packed) status = use_band(ctx, c, &found, ref.key, cell);
    if (status == KN_OK && !found) status = leaf_piece(ctx, c, &index, key, cell);
    if (status != KN_OK || found) return status;
    const kn_job_piece *p = &c->pieces.list[index];
    if (!p->fits) return kn_fail(ctx, KN_EUNDECIDED, "job: a piece of the plan no longer fits");
    if (c->matrices[ref.key].packed) return use_matrix(ctx, c, ref.key, index, &p->piece);
    kn_bezier d = {0};
    double lo[2], hi[2];
    bool by_matrix = key->whole && !c->job->options.symbolic;
    status = kn_job_in_box(ctx, &d, lo, hi, from, key);
    if (status == KN_OK && by_matrix) status = compose_alone(ctx, c, from, key, &d, &p->piece, to);
    if (status == KN_OK && !by_matrix) status = compose_symbolic(ctx, c, &d, &p->piece, to);
    kn_bezier_clear(ctx, &d);
    return status;
}

static kn_status compose_shared(kn_ctx *ctx, composer *c, const int cell[2], const kn_job_list *list)
{
    kn_status status = kn_job_find_steps(ctx, c->steps, c->job, c->surface, cell);
    c->nrows = 0;
    for (uint32_t i = 0; status == KN_OK && i < list->count; i++)
        status = compose_ref(ctx, c, c->job->lists.refs[list->first + i], cell);
    kn_job_pieces_clear(ctx, &c->pieces);
    return status;
}

// ---- cells with plans of their own ----

static kn_status compose_leaf(kn_ctx *ctx, composer *c, const kn_job_cell_plan *plan, const kn_job_leaf *leaf)
{
    const kn_job_patch *from = leaf->mesh.position ? NULL : kn_job_leaf_patch(plan, leaf);
    int degree[KN_JOB_VARS] = {0}, nvars = 0, ncomp = leaf->made.coef ? leaf->made.ncomp : c->ncomp;
    if (from) {
        kn_job_leaf_degree(leaf, degree);
        nvars = leaf->made.coef ? leaf->made.nvars : from->d.nvars;
    }
    kn_patch *to = next_patch(ctx, c, from, &leaf->key, (uint32_t)leaf->instance, plan->cell, degree, nvars, ncomp);
    if (!to) return KN_EUNDECIDED;
    if (nvars == 3 &&
        kn_job_hide_faces(ctx, &to->hidden, c->job, from, &leaf->key.rect, c->surface, plan->cell) != KN_OK)
        return kn_ctx_error(ctx);
    if (leaf->trim.nloops > 0) to->trim = &leaf->trim;
    if (leaf->mesh.position) {
        to->id.part = leaf->part, to->id.patch = leaf->patch;
        to->look = kn_job_look_of(c->job, leaf->part, c->steps);
        to->mesh = &leaf->mesh;
        return KN_OK;
    }
    if (leaf->made.coef) {
        memcpy(to->bezier.coef, leaf->made.coef, (size_t)ncomp * kn_job_numbers(degree) * sizeof(double));
        return KN_OK;
    }
    const kn_job_piece *piece = &plan->pieces.list[leaf->piece];
    uint32_t key;
    if (!leaf->own && !leaf->alone && kn_job_keys_find(&key, &c->job->keys, &leaf->key) && c->matrices[key].packed)
        return use_matrix(ctx, c, key, leaf->piece, &piece->piece);
    kn_bezier d = {0};
    kn_status status = kn_job_leaf_source(ctx, &d, plan, leaf);
    bool by_matrix = leaf->key.whole && !leaf->alone && !c->job->options.symbolic;
    if (status == KN_OK && by_matrix) status = compose_alone(ctx, c, from, &leaf->key, &d, &piece->piece, to);
    if (status == KN_OK && !by_matrix) status = compose_symbolic(ctx, c, &d, &piece->piece, to);
    kn_bezier_clear(ctx, &d);
    return status;
}

static kn_status compose_own(kn_ctx *ctx, composer *c, size_t index)
{
    kn_job_product *p = c->product;
    if (p->nplans == p->plans_room) {
        size_t room = 2 * p->plans_room + 8;
        kn_job_cell_plan *plans = kn_resize(ctx, p->plans, room, sizeof *plans);
        if (!plans) return KN_ENOMEM;
        p->plans = plans;
        p->plans_room = room;
    }
    kn_job_cell_plan *plan = &p->plans[p->nplans];
    kn_status status = kn_job_plan_cell(ctx, plan, c->job, index, false);
    if (status != KN_OK) return status;
    p->nplans++;
    c->nrows = 0;
    if (plan->count > 0) status = kn_job_find_steps(ctx, c->steps, c->job, c->surface, plan->cell);
    for (int i = 0; status == KN_OK && i < plan->count; i++) status = compose_leaf(ctx, c, plan, &plan->leaves[i]);
    kn_job_pieces_end(ctx, &plan->pieces);
    return status;
}

// ---- the block ----

static kn_status compose_cells(kn_ctx *ctx, composer *c, const kn_job_block *b)
{
    const kn_job *job = c->job;
    size_t at = kn_job_find_alike(job, b->first_cell);
    kn_status status = KN_OK;
    for (size_t i = b->first_cell; status == KN_OK && i < b->first_cell + b->ncells; i++) {
        while (job->alike[at + 1].first_cell <= i) at++;
        const kn_job_list *list = job->alike[at].list == KN_JOB_OWN ? NULL : &job->lists.list[job->alike[at].list];
        int cell[2];
        if (list && list->count == 0) continue;
        kn_job_locate(job, i, &c->surface, cell);
        size_t row = (size_t)(job->surfaces[c->surface].cells[1] - cell[1]), end = job->alike[at + 1].first_cell;
        if (end > b->first_cell + b->ncells) end = b->first_cell + b->ncells;
        c->left = end - i < row ? (int)(end - i) : (int)row;
        status = list ? compose_shared(ctx, c, cell, list) : compose_own(ctx, c, i);
    }
    if (status == KN_OK && (c->at != c->npatches || c->used != c->numbers))
        status = kn_fail(ctx, KN_EUNDECIDED, "job: cells are not what they were in the plan");
    return status;
}

kn_status kn_job_compose_block(kn_ctx *ctx, kn_job_product *out, const kn_job *job, const kn_job_matrix *matrices,
                               const kn_job_block *b)
{
    composer c = {.job = job, .matrices = matrices, .product = out, .npatches = b->npatches, .numbers = b->numbers};
    int cell[2];
    kn_job_locate(job, b->first_cell, &c.surface, cell);
    c.pieces.job = c.bands.job = job;
    c.ncomp = (int)kn_job_components(&job->surfaces[c.surface]);
    kn_mark mark = kn_scratch_mark(ctx);
    c.order = kn_scratch(ctx, b->npatches, sizeof *c.order);
    c.operand = kn_scratch(ctx, b->npatches, sizeof *c.operand);
    c.steps = kn_scratch(ctx, job->looks ? (size_t)job->looks->nrules : 0, sizeof *c.steps);
    kn_status status = c.order && c.operand && c.steps ? make_room(ctx, out, b) : KN_ENOMEM;
    if (status == KN_OK) status = compose_cells(ctx, &c, b);
    if (status == KN_OK) status = multiply_all(ctx, &c);
    kn_job_pieces_end(ctx, &c.pieces);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK)
        out->block = (kn_patch_block){b->first_patch, b->npatches, out->patches};
    else
        kn_job_product_empty(ctx, out);
    return status;
}
