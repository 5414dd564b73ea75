// SPDX-License-Identifier: Apache-2.0
// Inside knurl: OBJ files whose patches are written in another way than as triangles.
#ifndef IO_OBJ_H
#define IO_OBJ_H

#include <knurl/job.h>

#include "io/text_buffer.h"

// Appends what stands for a patch that is no mesh; indices of vertices count backwards.
typedef kn_status kn_obj_patch(kn_ctx *worker, kn_text *text, const kn_patch *patch);
// As kn_obj_sink; put NULL: triangles.
KN_CHECKED kn_status kn_obj_open(kn_ctx *ctx, kn_sink *out, const char *path, kn_obj_patch *put);

#endif
