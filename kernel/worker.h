// SPDX-License-Identifier: Apache-2.0
// Contexts for the threads that work on behalf of one context.
#ifndef KERNEL_WORKER_H
#define KERNEL_WORKER_H

#include "kernel/context.h"

// A context with parent's allocator and counters, scratch of its own, one thread and no callbacks. NULL (and
// KN_ENOMEM recorded in parent) without memory. Destroyed by kn_ctx_destroy, before parent.
kn_ctx *kn_worker_create(kn_ctx *parent);
// Records worker's first error in ctx (where the first error is kept) and answers status. A worker that failed
// without a record gives a record without a message of its own.
kn_status kn_worker_report(kn_ctx *ctx, const kn_ctx *worker, kn_status status);

#endif
