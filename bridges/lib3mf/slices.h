// SPDX-License-Identifier: Apache-2.0
// Slices as a 3MF file with the slice extension, through lib3mf.
#ifndef BRIDGES_LIB3MF_SLICES_H
#define BRIDGES_LIB3MF_SLICES_H

#include <knurl/slice.h>

#ifdef __cplusplus
extern "C" {
#endif

// A stack of slices that grows: a model of one object, whose geometry is the stack (mesh resolution "lowres": the mesh
// beside it is a box around it, for viewers that know no slices).
typedef struct kn_3mf_slices kn_3mf_slices;

// in:    unit_mm: millimetres in one length unit, above 0. bottom: z under the first layer, and above: how far the top
//        of a layer lies above its contours' z; length units.
// fails: KN_EDOMAIN, KN_EIO (the folder refuses a file), KN_ENOMEM; *out unchanged.
KN_CHECKED kn_status kn_3mf_slices_create(kn_ctx *ctx, kn_3mf_slices **out, const char *path, double unit_mm,
                                          double bottom, double above);
// Appends a layer's closed contours, as the material up to its top; a kn_slice_fn, user is the stack.
// fails: KN_EDOMAIN z that does not increase, a coordinate beyond single precision; KN_EIO what lib3mf refuses.
KN_CHECKED kn_status kn_3mf_slices_add(kn_ctx *ctx, void *stack, const kn_slice *layer);
// Writes the file, which appears whole or not at all. *bytes: its size (NULL: not wanted).
KN_CHECKED kn_status kn_3mf_slices_write(kn_ctx *ctx, kn_3mf_slices *stack, size_t *bytes);
// NULL is fine. memory: all slices are held until the end, single precision: lib3mf writes no streams.
void kn_3mf_slices_destroy(kn_ctx *ctx, kn_3mf_slices *stack);

// What lib3mf itself reads in a file of slices, for tests.
typedef struct kn_3mf_slices_facts {
    size_t slices, polygons, vertices; // of the first object's stack
    double top;                        // z of the last slice
} kn_3mf_slices_facts;
// fails: KN_EIO what lib3mf refuses, or no slices; KN_ENOMEM.
KN_CHECKED kn_status kn_3mf_slices_look(kn_ctx *ctx, kn_3mf_slices_facts *out, const char *path);

#ifdef __cplusplus
}
#endif
#endif
