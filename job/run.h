// SPDX-License-Identifier: Apache-2.0
// Inside job: what composes the blocks of a run.
#ifndef JOB_RUN_H
#define JOB_RUN_H

#include "job/internal.h"

// What composes all patches of a key: [M0 | M1 ..] transposed and packed, k x n. packed NULL: symbolically.
typedef struct kn_job_matrix {
    double *packed;
    size_t k, n;
} kn_job_matrix;

// ---- matrices.c ----
// One for each of job->keys, some of them empty. Their memory is limited.
kn_status kn_job_make_matrices(kn_ctx *ctx, kn_job_matrix **out, const kn_job *job);
// The one that composes d, a patch in the coordinates of its box, as the key says.
kn_status kn_job_make_matrix(kn_ctx *ctx, kn_job_matrix *out, const kn_bezier *d, const kn_job *job,
                             const kn_job_patch *patch, const kn_job_key *key);
void kn_job_free_matrices(kn_ctx *ctx, const kn_job *job, kn_job_matrix *list);

// ---- bands.c ----
// The pieces of whole cells, made for many that follow one another: rows as kn_gemm wants them, in scratch memory.
typedef struct kn_job_band {
    int surface, cell[2], count; // cells (cell[0], cell[1] ..)
    const kn_job_key *like;      // whose terms they have
    const double *rows;          // NULL: they are to be had in another way
    size_t each;                 // numbers of one cell
} kn_job_band;
enum { KN_JOB_BANDS = 16 };
typedef struct kn_job_bands {
    const kn_job *job;
    kn_job_band band[KN_JOB_BANDS]; // the last ones made
    int count, next;
} kn_job_bands;
// *rows = the components of the piece over the whole cell at `place` with the terms of the key, one after the other;
// NULL: kn_job_pieces_get has it. cells: so many, from this one on, will likely be asked for.
kn_status kn_job_bands_get(kn_ctx *ctx, const double **rows, kn_job_bands *bands, const kn_job_place *place,
                           const kn_job_key *key, int cells);

// ---- compose_block.c ----
// The patches of a block with all that they borrow.
typedef struct kn_job_product {
    kn_patch_block block;
    kn_patch *patches;
    double *coef, *memory; // coef: in memory, at a line of the caches
    size_t patches_room, coef_room;
    kn_job_cell_plan *plans; // of cells that have their own
    size_t nplans, plans_room;
} kn_job_product;
// out: zero, or a product whose patches nobody wants any more; its memory is used again, and on failure it is empty.
kn_status kn_job_compose_block(kn_ctx *ctx, kn_job_product *out, const kn_job *job, const kn_job_matrix *matrices,
                               const kn_job_block *block);
void kn_job_product_clear(kn_ctx *ctx, kn_job_product *product);
// Frees what belongs to its cells, and keeps room for the next block's unless that is too much to keep.
void kn_job_product_empty(kn_ctx *ctx, kn_job_product *product);

// ---- state.c ----
// A run between two commits.
typedef struct kn_job_state {
    uint64_t identity;
    size_t done, nblocks;
    const unsigned char *data;
    size_t bytes;
} kn_job_state;
// A number for all that decides what a job composes, and for the caller's own.
uint64_t kn_job_identity(const kn_job *job, uint64_t own);
// *data, for kn_free: the state and that of the sinks.
kn_status kn_job_save_state(kn_ctx *ctx, unsigned char **data, size_t *bytes, const kn_job_state *state,
                            kn_sink *sinks, int nsinks);
// done, and the sinks, from data; identity and nblocks must agree.
kn_status kn_job_restore_state(kn_ctx *ctx, kn_job_state *state, const kn_job *job, kn_sink *sinks, int nsinks);

#endif
