// SPDX-License-Identifier: Apache-2.0
// Running a job: blocks of cells are composed on any thread and committed in order.
#include "job/internal.h"
#include "kernel/gemm.h"
#include "kernel/parallel.h"

#include <stdlib.h>
#include <string.h>

enum {
    BLOCK_NUMBERS = 1 << 18, // coefficients of a block's patches, about: 2 MiB, which a second cache holds
    LEAST_USES = 4,          // of a key that is no whole cell's, below which its matrix costs more than it saves
};

// What composes all patches of a key: [M0 | M1 ..] transposed and packed, k x n. NULL: symbolically.
typedef struct matrix {
    double *packed;
    size_t k, n;
} matrix;

// Cells of one surface.
typedef struct range {
    size_t first_cell, ncells, first_patch, npatches, numbers;
} range;

typedef struct runner {
    const kn_job *job;
    kn_sink *sinks;
    int nsinks;
    matrix *matrices; // one for each key
    range *blocks;
    size_t nblocks;
} runner;

// ---- matrices ----

static kn_status make_matrix(kn_ctx *ctx, void *user, size_t index)
{
    const runner *r = user;
    const kn_job_key *key = &r->job->keys[index];
    if (r->job->options.symbolic || (!key->whole && r->job->uses[index] < LEAST_USES)) return KN_OK;
    kn_bezier d = {0};
    kn_compose_matrix m[KN_SHELL_TERMS] = {{.m = NULL}};
    matrix made = {0};
    double lo[2], hi[2], *all = NULL;
    int rows[KN_JOB_VARS];
    kn_job_degree(r->job, key, rows);
    kn_status status = kn_job_in_box(ctx, &d, lo, hi, r->job, key);
    for (int t = 0; status == KN_OK && t < key->nterms; t++) {
        const int degree[2] = {key->degree[t][0], key->degree[t][1]};
        status = kn_compose_matrix_init(ctx, &m[t], &d, degree, key->power[t], rows);
        made.k += m[t].cols;
        made.n = m[t].rows;
    }
    if (status == KN_OK) all = kn_alloc(ctx, made.k * made.n, sizeof *all);
    if (all) made.packed = kn_alloc(ctx, kn_gemm_room(made.k, made.n), sizeof *made.packed);
    if (status == KN_OK && !made.packed) status = KN_ENOMEM;
    if (status == KN_OK) {
        double *to = all;
        for (size_t q = 0; q < made.n; q++)
            for (int t = 0; t < key->nterms; to += m[t++].cols)
                memcpy(to, m[t].m + q * m[t].cols, m[t].cols * sizeof *all);
        kn_gemm_pack(made.packed, all, made.k, made.n, 1, made.k);
        r->matrices[index] = made;
    }
    kn_free(ctx, all);
    for (int t = 0; t < key->nterms; t++) kn_compose_matrix_clear(ctx, &m[t]);
    kn_bezier_clear(ctx, &d);
    return status;
}

// ---- blocks ----

static int components(const kn_job_surface *s)
{
    return kn_shell_surface(s->shell)->rational ? 4 : 3;
}

static size_t cell_numbers(const kn_job *job, const kn_job_cell *cell, int ncomp)
{
    size_t sum = 0;
    for (uint32_t i = 0; i < cell->count; i++) {
        int degree[KN_JOB_VARS];
        kn_job_degree(job, &job->keys[job->leaves[cell->first + i]], degree);
        sum += (size_t)ncomp * (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1) * (size_t)(degree[2] + 1);
    }
    return sum;
}

// Consecutive cells of one surface, as many as fill a block; list NULL: only counts.
static size_t make_blocks(const kn_job *job, range *list)
{
    size_t n = 0, patch = 0;
    for (int s = 0; s < job->nsurfaces; s++) {
        const kn_job_surface *surface = &job->surfaces[s];
        size_t cells = (size_t)surface->cells[0] * (size_t)surface->cells[1], numbers = 0;
        range b = {.first_cell = surface->first_cell, .first_patch = patch};
        const kn_job_cell *before = NULL;
        for (size_t i = 0; i < cells; i++) {
            const kn_job_cell *cell = &job->cells[surface->first_cell + i];
            if (!before || before->first != cell->first) numbers = cell_numbers(job, cell, components(surface));
            before = cell;
            b.ncells++;
            b.npatches += cell->count;
            b.numbers += numbers;
            if (b.numbers < BLOCK_NUMBERS && i + 1 < cells) continue;
            if (list) list[n] = b;
            n++;
            patch = b.first_patch + b.npatches;
            b = (range){.first_cell = surface->first_cell + i + 1, .first_patch = patch};
        }
    }
    return n;
}

typedef struct product {
    kn_patch_block block;
    kn_patch *patches;
    double *coef;
    void **of_sink;
    int nworked; // sinks whose product is in of_sink
} product;

static void product_free(kn_ctx *ctx, const runner *r, product *p, int first_sink)
{
    for (int k = first_sink; p->of_sink && k < p->nworked; k++)
        if (r->sinks[k].discard && p->of_sink[k]) r->sinks[k].discard(ctx, r->sinks[k].user, p->of_sink[k]);
    kn_free(ctx, p->patches);
    kn_free(ctx, p->coef);
    kn_free(ctx, p->of_sink);
    kn_free(ctx, p);
}

static kn_status product_init(kn_ctx *ctx, product **out, const runner *r, const range *b)
{
    product *p = kn_alloc_zero(ctx, 1, sizeof *p);
    if (!p) return KN_ENOMEM;
    p->patches = kn_alloc_zero(ctx, b->npatches, sizeof *p->patches);
    p->coef = kn_alloc_zero(ctx, b->numbers, sizeof *p->coef);
    p->of_sink = kn_alloc_zero(ctx, (size_t)r->nsinks, sizeof *p->of_sink);
    p->block = (kn_patch_block){b->first_patch, b->npatches, p->patches};
    if (p->patches && p->coef && p->of_sink) {
        *out = p;
        return KN_OK;
    }
    product_free(ctx, r, p, 0);
    return KN_ENOMEM;
}

// ---- composing a block ----

typedef struct composer {
    const runner *run;
    int surface_index, ncomp;
    kn_job_pieces pieces; // of the current cell
    const double **rows;  // of these pieces, as many as have been asked for
    int nrows;
    product *product;
    uint64_t *order;         // key << 32 | patch, for those that a matrix composes
    const double **operand;  // ncomp rows for each patch, one after the other: where they start
    size_t norder, at, used; // patches and coefficients made
} composer;

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

static kn_status compose_symbolic(kn_ctx *ctx, const composer *c, const kn_job_key *key, const kn_shell_piece *piece,
                                  const kn_patch *patch)
{
    kn_bezier d = {0}, out = {0};
    double lo[2], hi[2];
    kn_status status = kn_job_in_box(ctx, &d, lo, hi, c->run->job, key);
    if (status == KN_OK) status = kn_compose_piece(ctx, &out, piece, &d);
    if (status == KN_OK) status = kn_bezier_elevate(ctx, &out, &out, patch->bezier.degree);
    if (status == KN_OK)
        memcpy(patch->bezier.coef, out.coef, (size_t)c->ncomp * kn_bezier_count(&out) * sizeof *out.coef);
    kn_bezier_clear(ctx, &d);
    kn_bezier_clear(ctx, &out);
    return status;
}

// The piece that a leaf asks for: the same call as the plan's, and so the same answer.
static kn_status leaf_piece(kn_ctx *ctx, composer *c, int *index, const kn_job_key *key, const int cell[2])
{
    const kn_job_patch *p = &c->run->job->patches[key->patch];
    kn_job_place place = kn_job_find_place(c->run->job, c->surface_index, cell, p->offset);
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

static kn_status compose_leaf(kn_ctx *ctx, composer *c, uint32_t leaf, const int cell[2], const kn_patch_id *before)
{
    const kn_job *job = c->run->job;
    const kn_job_key *key = &job->keys[leaf];
    const kn_job_patch *from = &job->patches[key->patch];
    kn_patch *to = &c->product->patches[c->at];
    bool same = before && before->part == from->part && before->patch == from->patch;
    const kn_job_surface *s = &job->surfaces[c->surface_index];
    const int *first = s->origin_cell;
    to->id = (kn_patch_id){.surface = s->origin,
                           .cell = {first[0] + cell[0], first[1] + cell[1]},
                           .part = from->part,
                           .patch = from->patch,
                           .piece = same ? before->piece + 1 : 0};
    to->bezier = (kn_bezier){.nvars = from->d.nvars, .ncomp = c->ncomp, .rational = c->ncomp == 4};
    kn_job_degree(job, key, to->bezier.degree);
    to->bezier.coef = c->product->coef + c->used;
    to->reversed = job->options.height < 0.0;
    to->exact = key->exact;
    kn_job_segments(job, key, to->segments);
    c->used += (size_t)c->ncomp * kn_bezier_count(&to->bezier);

    int index = 0;
    kn_status status = leaf_piece(ctx, c, &index, key, cell);
    if (status != KN_OK) return status;
    const kn_job_piece *p = &c->pieces.list[index];
    if (!p->fits) return kn_fail(ctx, KN_EUNDECIDED, "job: a piece of the plan no longer fits");
    if (!c->run->matrices[leaf].packed) {
        status = compose_symbolic(ctx, c, key, &p->piece, to);
    } else {
        if (index >= c->nrows) {
            for (; c->nrows <= index; c->nrows++) c->rows[c->nrows] = NULL;
        }
        if (!c->rows[index]) c->rows[index] = piece_rows(ctx, &p->piece, c->ncomp);
        if (!c->rows[index]) return KN_ENOMEM;
        c->operand[c->at] = c->rows[index];
        c->order[c->norder++] = (uint64_t)leaf << 32 | c->at;
    }
    c->at++;
    return status;
}

static int compare_order(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

// Patches of one key, one matrix product: a row for each component of each patch.
static void multiply(const composer *c, const uint64_t *order, size_t n, double **to, const double **from)
{
    const matrix *m = &c->run->matrices[order[0] >> 32];
    size_t ncomp = (size_t)c->ncomp;
    for (size_t i = 0; i < n; i++) {
        size_t patch = order[i] & UINT32_MAX;
        for (size_t k = 0; k < ncomp; k++) {
            to[i * ncomp + k] = c->product->patches[patch].bezier.coef + k * m->n;
            from[i * ncomp + k] = c->operand[patch] + k * m->k;
        }
    }
    kn_gemm(to, from, n * ncomp, m->packed, m->k, m->n);
}

static kn_status multiply_all(kn_ctx *ctx, composer *c)
{
    size_t rows = (size_t)c->ncomp * c->norder;
    double **to = kn_scratch(ctx, rows, sizeof *to);
    const double **from = kn_scratch(ctx, rows, sizeof *from);
    if (!to || !from) return KN_ENOMEM;
    qsort(c->order, c->norder, sizeof *c->order, compare_order);
    for (size_t i = 0, n; i < c->norder; i += n) {
        for (n = 1; i + n < c->norder && c->order[i + n] >> 32 == c->order[i] >> 32;) n++;
        multiply(c, c->order + i, n, to, from);
    }
    return KN_OK;
}

static kn_status compose_cell(kn_ctx *ctx, composer *c, size_t index)
{
    const kn_job *job = c->run->job;
    const kn_job_cell *list = &job->cells[index];
    int cell[2];
    kn_job_locate(job, index, &c->surface_index, cell);
    kn_status status = KN_OK;
    c->nrows = 0;
    for (uint32_t i = 0; status == KN_OK && i < list->count; i++) {
        const kn_patch_id *before = i > 0 ? &c->product->patches[c->at - 1].id : NULL;
        status = compose_leaf(ctx, c, job->leaves[list->first + i], cell, before);
    }
    kn_job_pieces_clear(ctx, &c->pieces);
    return status;
}

static kn_status compose_block(kn_ctx *ctx, const runner *r, const range *b, product *p)
{
    composer c = {.run = r, .product = p};
    int cell[2];
    kn_job_locate(r->job, b->first_cell, &c.surface_index, cell);
    c.pieces.job = r->job;
    c.ncomp = components(&r->job->surfaces[c.surface_index]);
    size_t most = 0; // leaves of a cell, and so pieces
    for (size_t i = 0; i < b->ncells; i++) {
        size_t count = r->job->cells[b->first_cell + i].count;
        most = count > most ? count : most;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    c.rows = kn_scratch(ctx, most + 1, sizeof *c.rows);
    c.order = kn_scratch(ctx, b->npatches, sizeof *c.order);
    c.operand = kn_scratch(ctx, b->npatches, sizeof *c.operand);
    kn_status status = c.rows && c.order && c.operand ? KN_OK : KN_ENOMEM;
    for (size_t i = 0; status == KN_OK && i < b->ncells; i++) status = compose_cell(ctx, &c, b->first_cell + i);
    if (status == KN_OK) status = multiply_all(ctx, &c);
    kn_job_pieces_end(ctx, &c.pieces);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- the pipeline ----

static kn_status work(kn_ctx *worker, void *user, size_t index, void **out)
{
    const runner *r = user;
    product *p = NULL;
    kn_status status = product_init(worker, &p, r, &r->blocks[index]);
    if (status != KN_OK) return status;
    status = compose_block(worker, r, &r->blocks[index], p);
    for (; status == KN_OK && p->nworked < r->nsinks; p->nworked++) {
        const kn_sink *sink = &r->sinks[p->nworked];
        if (sink->work) status = sink->work(worker, sink->user, &p->block, &p->of_sink[p->nworked]);
    }
    if (status == KN_OK)
        *out = p;
    else
        product_free(worker, r, p, 0);
    return status;
}

static kn_status commit(kn_ctx *ctx, void *user, size_t index, void *made)
{
    (void)index;
    const runner *r = user;
    product *p = made;
    kn_status status = KN_OK;
    int k = 0;
    for (; status == KN_OK && k < r->nsinks; k++)
        status = r->sinks[k].commit(ctx, r->sinks[k].user, &p->block, p->of_sink[k]);
    product_free(ctx, r, p, k);
    return status;
}

static void drop(kn_ctx *ctx, void *user, void *made)
{
    product_free(ctx, user, made, 0);
}

static kn_status prepare(kn_ctx *ctx, runner *r)
{
    r->nblocks = make_blocks(r->job, NULL);
    r->blocks = kn_alloc(ctx, r->nblocks, sizeof *r->blocks);
    r->matrices = kn_alloc_zero(ctx, r->job->nkeys, sizeof *r->matrices);
    if (!r->blocks || !r->matrices) return KN_ENOMEM;
    (void)make_blocks(r->job, r->blocks);
    return kn_parallel(ctx, r->job->nkeys, make_matrix, r, "matrices");
}

kn_status kn_job_run(kn_ctx *ctx, const kn_job *job, kn_sink *sinks, int nsinks)
{
    runner r = {.job = job, .sinks = sinks, .nsinks = nsinks};
    const kn_pipeline pipeline = {&r, work, commit, drop};
    for (int k = 0; k < nsinks; k++)
        if (!sinks[k].commit) return kn_fail(ctx, KN_EDOMAIN, "job: sink %d is closed, or has no commit", k);
    kn_status status = prepare(ctx, &r);
    for (int k = 0; status == KN_OK && k < nsinks; k++)
        if (sinks[k].begin) status = sinks[k].begin(ctx, sinks[k].user, &job->tile, &job->report);
    size_t ahead = 2 * (size_t)kn_ctx_threads(ctx) + 1;
    if (status == KN_OK) status = kn_pipeline_run(ctx, &pipeline, r.nblocks, ahead, "compose");
    for (int k = 0; status == KN_OK && k < nsinks; k++)
        if (sinks[k].end) status = sinks[k].end(ctx, sinks[k].user);
    for (size_t i = 0; r.matrices && i < job->nkeys; i++) kn_free(ctx, r.matrices[i].packed);
    kn_free(ctx, r.matrices);
    kn_free(ctx, r.blocks);
    return status;
}
