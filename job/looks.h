// SPDX-License-Identifier: Apache-2.0
// Inside job: colours by fields.
#ifndef JOB_LOOKS_H
#define JOB_LOOKS_H

#include "job/vary.h"

// kn_job_look_tile's parts: those of the tile, in their order, each as often as it has colours.
typedef struct kn_job_looks {
    kn_field *field; // of each rule (kn_job_options.color)
    int *steps;
    int nrules;
    unsigned needs;
    int *rule, *first; // of each part of the tile: its rule, or -1; its first look
    kn_tile tile;      // parts borrow from job->tile
} kn_job_looks;

// job->looks, from the options' colours; NULL where there are none.
kn_status kn_job_looks_init(kn_ctx *ctx, kn_job *job);
void kn_job_looks_clear(kn_ctx *ctx, kn_job *job);
// step[k] = the step of rule k in a cell. Nothing is written where there are no rules.
kn_status kn_job_find_steps(kn_ctx *ctx, int *step, const kn_job *job, int surface, const int cell[2]);
// The look of a part of the tile in a cell with these steps.
int kn_job_look_of(const kn_job *job, int part, const int *step);

#endif
