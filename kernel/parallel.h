// SPDX-License-Identifier: Apache-2.0
// Work over an index range on the threads of a context.
#ifndef KERNEL_PARALLEL_H
#define KERNEL_PARALLEL_H

#include <knurl/base.h>

// Does item `index` with a context of its own (same allocator, no callbacks, one thread). Results must depend on
// index alone, never on which worker ran it or when.
typedef kn_status (*kn_task)(kn_ctx *worker, void *user, size_t index);

// Runs task for index 0 .. n-1 on kn_ctx_threads(ctx) threads, the calling one among them, handing out indices in
// order. The error reported is the one of the lowest failing index; after a failure no new index starts. The calling
// thread reports progress under `stage` (NULL: none), after each index of its own. Cancelling stops likewise and
// answers KN_ECANCELLED. KN_ENOMEM when there is no memory for the threads' contexts; a thread that the system
// refuses is done without.
kn_status kn_parallel(kn_ctx *ctx, size_t n, kn_task task, void *user, const char *stage);

// The same as a pipeline with bounded memory: work(index) on any thread fills *product, commit(index) runs on the
// calling thread in index order. At most `ahead` products exist at a time (0 means 1). A work that fails leaves no
// product. commit owns its product, also when it fails. All indices below the lowest failing one are committed before
// its error is reported; drop(product) (NULL: nothing to do) is for products that are never committed. Progress is
// reported after each commit.
typedef struct kn_pipeline {
    void *user;
    kn_status (*work)(kn_ctx *worker, void *user, size_t index, void **product);
    kn_status (*commit)(kn_ctx *ctx, void *user, size_t index, void *product);
    void (*drop)(kn_ctx *ctx, void *user, void *product);
} kn_pipeline;
kn_status kn_pipeline_run(kn_ctx *ctx, const kn_pipeline *pipeline, size_t n, size_t ahead, const char *stage);

#endif
