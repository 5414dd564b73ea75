// SPDX-License-Identifier: Apache-2.0
// Morphs of two meshes while allocations fail.
#include "tests/mesh/starved.h"

#include "tests/support/support.h"

static kn_status morph(kn_ctx *ctx, void *user)
{
    const kn_mesh *const *pair = user;
    kn_mesh both = {0};
    double *target = NULL;
    kn_status status = kn_mesh_morph(ctx, &both, &target, pair[0], pair[1]);
    assert_true((status == KN_OK) == (target != NULL) && (both.ntriangles > 0) == (target != NULL));
    kn_mesh_clear(ctx, &both);
    kn_free(ctx, target);
    return status;
}

void starved_morph(const kn_mesh *a, const kn_mesh *b)
{
    const kn_mesh *pair[2] = {a, b};
    test_allocation_failures(morph, pair);
}
