// SPDX-License-Identifier: Apache-2.0
// The matrices of a run: one for each key that is worth it.
#include "job/run.h"
#include "kernel/gemm.h"
#include "kernel/parallel.h"

enum {
    LEAST_USES = 4,         // of a key that is no whole cell's, below which its matrix costs more than it saves
    MOST_NUMBERS = 1 << 24, // in all matrices: 128 MiB
};

typedef struct matrices {
    const kn_job *job;
    kn_job_matrix *list;
    size_t least; // uses below which there is none
} matrices;

static size_t wanted(const matrices *m, size_t index)
{
    const kn_job *job = m->job;
    const kn_job_key *key = &job->keys.list[index];
    if (job->options.symbolic || (!key->whole && job->keys.uses[index] < LEAST_USES)) return 0;
    if (job->keys.uses[index] < m->least) return 0;
    int rows[KN_JOB_VARS];
    kn_job_degree(key, rows);
    return kn_job_columns(key) * kn_job_numbers(rows);
}

kn_status kn_job_make_matrix(kn_ctx *ctx, kn_job_matrix *out, const kn_bezier *d, const kn_job *job,
                             const kn_job_patch *patch, const kn_job_key *key)
{
    int least[3][KN_JOB_VARS], rows[KN_JOB_VARS];
    kn_job_least_degrees(least, job, patch, key->whole);
    kn_job_degree(key, rows);
    kn_job_matrix made = {.k = kn_job_columns(key), .n = kn_job_numbers(rows)};
    made.packed = kn_alloc(ctx, kn_gemm_room(made.k, made.n), sizeof *made.packed);
    kn_status status = made.packed ? KN_OK : KN_ENOMEM;
    size_t first = 0;
    for (int t = 0; status == KN_OK && t < key->nterms; t++) {
        const int degree[2] = {key->degree[t][0], key->degree[t][1]};
        kn_compose_matrix m = {0};
        status = kn_compose_matrix_init(ctx, &m, d, degree, key->power[t], rows, (const int(*)[KN_JOB_VARS])least);
        if (status == KN_OK) kn_gemm_pack_some(made.packed, m.m, made.k, first, m.cols, made.n, m.rows, 1);
        first += m.cols;
        kn_compose_matrix_clear(ctx, &m);
    }
    if (status == KN_OK)
        *out = made;
    else
        kn_free(ctx, made.packed);
    return status;
}

static kn_status make_one(kn_ctx *ctx, void *user, size_t index)
{
    const matrices *all_of = user;
    const kn_job_key *key = &all_of->job->keys.list[index];
    const kn_job_patch *patch = &all_of->job->patches[key->patch];
    if (wanted(all_of, index) == 0) return KN_OK;
    kn_bezier d = {0};
    double lo[2], hi[2];
    kn_status status = kn_job_in_box(ctx, &d, lo, hi, patch, key);
    if (status == KN_OK) status = kn_job_make_matrix(ctx, &all_of->list[index], &d, all_of->job, patch, key);
    kn_bezier_clear(ctx, &d);
    return status;
}

// The least number of uses for which all matrices fit: powers of two.
static void choose_least(matrices *m)
{
    for (m->least = 1;; m->least *= 2) {
        size_t sum = 0;
        for (size_t i = 0; i < m->job->keys.count && sum <= MOST_NUMBERS; i++) sum += wanted(m, i);
        if (sum <= MOST_NUMBERS || m->least > m->job->ncells) return;
    }
}

kn_status kn_job_make_matrices(kn_ctx *ctx, kn_job_matrix **out, const kn_job *job)
{
    matrices m = {.job = job, .list = kn_alloc_zero(ctx, job->keys.count, sizeof *m.list)};
    if (!m.list) return KN_ENOMEM;
    choose_least(&m);
    kn_status status = kn_parallel(ctx, job->keys.count, make_one, &m, "matrices");
    if (status == KN_OK)
        *out = m.list;
    else
        kn_job_free_matrices(ctx, job, m.list);
    return status;
}

void kn_job_free_matrices(kn_ctx *ctx, const kn_job *job, kn_job_matrix *list)
{
    for (size_t i = 0; list && i < job->keys.count; i++) kn_free(ctx, list[i].packed);
    kn_free(ctx, list);
}
