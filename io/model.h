// SPDX-License-Identifier: Apache-2.0
// Inside io: building a model while reading it.
#ifndef IO_MODEL_H
#define IO_MODEL_H

#include <knurl/io.h>

typedef kn_status kn_model_parser(kn_ctx *ctx, kn_model *out, const char *name, const char *text, size_t bytes);

// Appends *spline, whose content moves into the model: it is empty afterwards, or unchanged on KN_ENOMEM.
KN_CHECKED kn_status kn_model_append(kn_ctx *ctx, kn_model *model, kn_spline *spline);
// *out gives up what it held and takes what *from held.
void kn_model_move(kn_ctx *ctx, kn_model *out, kn_model *from);
// Opens path and parses its bytes.
KN_CHECKED kn_status kn_read_with(kn_ctx *ctx, kn_model *out, const char *path, kn_model_parser *parse);
// A surface in the plane or in space that covers no area whatever the parameters: all control points on one line, or
// a net that does not change along one variable. Curves, volumes and other dimensions: false.
bool kn_spline_no_area(const kn_spline *s);

#endif
