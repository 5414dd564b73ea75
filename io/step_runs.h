// SPDX-License-Identifier: Apache-2.0
// Inside the STEP writer: the faces of one part, of which there may be millions, in few bytes.
#ifndef IO_STEP_RUNS_H
#define IO_STEP_RUNS_H

#include <knurl/base.h>

// Numbers that grow, in runs `stride` apart; the same for all calls. Patches of a part mostly follow one another in a
// cell, and one cell's are like the next one's: equal runs at equal distances are three numbers together. Where cells
// have their own colours each change is some five bytes. Zero: none.
typedef struct kn_step_runs {
    unsigned char *data; // skip, count, times, seven bits a byte: what ended
    size_t bytes, room;
    uint64_t last;               // number before the runs below, the last one of those in data
    uint64_t skip, count, times; // times runs of count numbers, each begins skip behind the last number before it
    uint64_t grows_from, grows_count; // the run that grows; count 0: none
} kn_step_runs;
KN_CHECKED kn_status kn_step_runs_add(kn_ctx *ctx, kn_step_runs *runs, uint64_t number, uint64_t stride);
// All that grew is in data.
KN_CHECKED kn_status kn_step_runs_end(kn_ctx *ctx, kn_step_runs *runs, uint64_t stride);
void kn_step_runs_clear(kn_ctx *ctx, kn_step_runs *runs);

// A place among the numbers of runs that have ended; zero: before the first.
typedef struct kn_step_place {
    size_t at;
    uint64_t number, skip, count, times, left; // left: numbers of the run that are still to come
} kn_step_place;
bool kn_step_runs_next(uint64_t *number, kn_step_place *place, const kn_step_runs *runs, uint64_t stride);

#endif
