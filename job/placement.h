// SPDX-License-Identifier: Apache-2.0
// Inside job: where tiles lie and which cells there are.
#ifndef JOB_PLACEMENT_H
#define JOB_PLACEMENT_H

#include "job/internal.h"

// ---- scatter.c ----
// job->darts, in the order of cells, where the options ask for a scatter; shells and lines are there.
kn_status kn_job_scatter_tiles(kn_ctx *ctx, kn_job *job);
// The first of job->darts that is not of a cell before this one.
size_t kn_job_first_dart(const kn_job *job, size_t cell);

#endif
