// SPDX-License-Identifier: Apache-2.0
// Points of the tiling by where they are.
#include "tile/net.h"

#include <math.h>

enum { BOXES = 1 << 16 }; // of one cell, in each direction

// The box of a coordinate: of u and v within the cell, where both ends are one.
static int64_t box_of(double x, bool wraps)
{
    if (wraps) return (int64_t)floor((x - floor(x)) * BOXES) & (BOXES - 1);
    return (int64_t)fmax(fmin(floor(x * BOXES), 0x1p60), -0x1p60);
}

static size_t slot_of(const kn_tile_places *places, const int64_t box[3])
{
    uint64_t h = 0;
    for (int c = 0; c < 3; c++) {
        h = (h ^ (uint64_t)box[c]) * 0x9E3779B97F4A7C15u;
        h ^= h >> 29;
    }
    return (size_t)(h & (places->nheads - 1));
}

kn_status kn_tile_places_make(kn_ctx *ctx, kn_tile_places *out, const double (*points)[3], int n)
{
    kn_tile_places places = {.points = points, .nheads = 16, .most = 200 * (size_t)n + 1000000};
    while (places.nheads < (size_t)n) places.nheads *= 2;
    places.head = kn_alloc(ctx, places.nheads, sizeof *places.head);
    places.next = kn_alloc(ctx, (size_t)n + 1, sizeof *places.next);
    if (!places.head || !places.next) {
        kn_tile_places_clear(ctx, &places);
        return KN_ENOMEM;
    }
    for (size_t i = 0; i < places.nheads; i++) places.head[i] = -1;
    for (int i = n - 1; i >= 0; i--) { // from the back: chains run in ascending order
        int64_t box[3] = {box_of(points[i][0], true), box_of(points[i][1], true), box_of(points[i][2], false)};
        size_t slot = slot_of(&places, box);
        places.next[i] = places.head[slot];
        places.head[slot] = i;
    }
    *out = places;
    return KN_OK;
}

void kn_tile_places_clear(kn_ctx *ctx, kn_tile_places *places)
{
    kn_free(ctx, places->head);
    kn_free(ctx, places->next);
    *places = (kn_tile_places){0};
}

// The reach is far below a box, so that each coordinate lies in one box or two.
kn_status kn_tile_places_near(kn_ctx *ctx, kn_tile_places *places, const double point[3], double reach,
                              kn_status (*visit)(void *user, int j), void *user)
{
    size_t seen[8];
    int nseen = 0;
    for (int corner = 0; corner < 8; corner++) {
        int64_t box[3];
        for (int c = 0; c < 3; c++) box[c] = box_of(point[c] + (corner >> c & 1 ? reach : -reach), c < 2);
        size_t slot = slot_of(places, box);
        bool again = false;
        for (int k = 0; k < nseen; k++) again = again || seen[k] == slot;
        if (again) continue;
        seen[nseen++] = slot;
        for (int j = places->head[slot]; j >= 0; j = places->next[j]) {
            if (places->visits++ > places->most)
                return kn_fail(ctx, KN_ELIMIT, "tile: too many edges in one place, near (%g, %g, %g)", point[0],
                               point[1], point[2]);
            kn_status status = visit(user, j);
            if (status != KN_OK) return status;
        }
    }
    return KN_OK;
}
