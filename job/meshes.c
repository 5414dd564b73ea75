// SPDX-License-Identifier: Apache-2.0
// Mesh parts of a tile, mapped into a cell.
#include "job/internal.h"

kn_status kn_job_map_meshes(kn_ctx *ctx, kn_job_cell_plan *plan, const kn_job_instance *instance)
{
    (void)ctx, (void)plan, (void)instance;
    return KN_OK;
}
