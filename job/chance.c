// SPDX-License-Identifier: Apache-2.0
// Each casual tile a little different: turned, moved, scaled and raised by chance.
#include "job/internal.h"
#include "job/vary.h"
#include "kernel/hash.h"

#include <math.h>

bool kn_job_has_chance(const kn_job *job)
{
    const kn_job_random *r = &job->options.random;
    return r->angle != 0.0 || r->shift != 0.0 || r->scale != 0.0 || r->height != 0.0;
}

kn_status kn_job_check_chance(kn_ctx *ctx, const kn_job *job)
{
    const kn_job_random *r = &job->options.random;
    if (!kn_job_has_chance(job)) return KN_OK;
    if (!(r->angle >= 0.0) || isinf(r->angle) || !(r->shift >= 0.0) || !(r->shift <= KN_JOB_MAX_REACH) ||
        !(r->scale >= 0.0 && r->scale < 1.0) || !(r->height >= 0.0) || isinf(r->height))
        return kn_fail(
            ctx, KN_EDOMAIN,
            "job: changes by chance of angle %g, shift %g, scale %g, height %g: scale below 1, none negative",
            r->angle, r->shift, r->scale, r->height);
    if (job->tile.covering)
        return kn_fail(ctx, KN_EDOMAIN,
                       "job: tile \"%s\" covers its cell: only casual tiles can be changed by chance",
                       job->tile.name);
    return KN_OK;
}

// A number in [-1,1] that belongs to the tile and to what it is for.
static double draw(uint64_t tile, int what)
{
    return 2.0 * kn_hash_unit(kn_hash_add(tile, (uint64_t)what)) - 1.0;
}

// What the map does follows what chance does: about the middle of the cell, and w about the offset.
void kn_job_change_by_chance(kn_job_instance *instance, const kn_job *job, int surface, const int cell[2])
{
    const kn_job_random *r = &job->options.random;
    const kn_job_surface *s = &job->surfaces[surface];
    uint64_t h = kn_hash_add(r->seed, (uint64_t)s->origin);
    for (int d = 0; d < 2; d++) h = kn_hash_add(h, (uint64_t)(s->origin_cell[d] + cell[d]));
    h = kn_hash_add(h, (uint64_t)instance->id);
    double angle = r->angle * draw(h, 0), scale = 1.0 + r->scale * draw(h, 1), raise = 1.0 + r->height * draw(h, 2);
    double c = scale * cos(angle), t = scale * sin(angle);
    const double own[3][4] = {{c, -t, 0.0, 0.5 - 0.5 * c + 0.5 * t + r->shift * draw(h, 3)},
                              {t, c, 0.0, 0.5 - 0.5 * t - 0.5 * c + r->shift * draw(h, 4)},
                              {0.0, 0.0, raise, (1.0 - raise) * job->options.offset}};
    double map[3][4];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) {
            map[i][j] = j == 3 ? instance->map[i][3] : 0.0;
            for (int k = 0; k < 3; k++) map[i][j] += instance->map[i][k] * own[k][j];
        }
    for (int i = 0; i < 12; i++) instance->map[i / 4][i % 4] = map[i / 4][i % 4];
    instance->plain = false;
}
