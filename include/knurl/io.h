// SPDX-License-Identifier: Apache-2.0
// Readers of spline files, the built-in tiles, and streaming writers of composed patches.
#ifndef KNURL_IO_H
#define KNURL_IO_H

#include <knurl/compose.h>
#include <knurl/mesh.h>

#ifdef __cplusplus
extern "C" {
#endif

// What a reader found: splines of any kinds in file order. A zero-initialised kn_model is a valid empty one.
typedef struct kn_model {
    kn_spline *splines;
    int nsplines;
} kn_model;
KN_API void kn_model_clear(kn_ctx *ctx, kn_model *model);

// Each kn_read_x opens path and calls kn_parse_x on its bytes; name stands for the file in messages. text need not
// end in a zero byte. Coordinates become the components, u the first variable. fails: KN_EPARSE ("name:line: what,
// value"), KN_EIO, KN_ELIMIT, KN_ENOMEM; out unchanged. .bpt: a count, then for each Bezier patch "m n" and
// (m+1)(n+1) points, u running fastest (teapot.bpt).
KN_API KN_CHECKED kn_status kn_read_bpt(kn_ctx *ctx, kn_model *out, const char *path);
KN_API KN_CHECKED kn_status kn_parse_bpt(kn_ctx *ctx, kn_model *out, const char *name, const char *text,
                                         size_t bytes);
// GoTools .g2: spline curves (100), surfaces (200) and volumes (700), polynomial or rational.
KN_API KN_CHECKED kn_status kn_read_g2(kn_ctx *ctx, kn_model *out, const char *path);
KN_API KN_CHECKED kn_status kn_parse_g2(kn_ctx *ctx, kn_model *out, const char *name, const char *text, size_t bytes);
// By the ending of path: .bpt or .g2 (KN_EDOMAIN otherwise).
KN_API KN_CHECKED kn_status kn_read_model(kn_ctx *ctx, kn_model *out, const char *path);

// ---- tiles ----
KN_API int kn_builtin_tile_count(void);
KN_API const char *kn_builtin_tile_name(int index); // NULL outside 0 .. count-1. Static storage
// out = the built-in tile of that name (docs/tiles.md); overwritten, not cleared: kn_tile_clear is the caller's.
// fails: KN_EDOMAIN (no such tile), KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_builtin_tile(kn_ctx *ctx, kn_tile *out, const char *name);
// out = a casual tile of one part, named after the file, from all splines of a file that kn_read_model reads.
// in:    cell: u0, v0, u1, v1, u0 < u1, v0 < v1, a rectangle of the file's (u,v) that is mapped to the unit square;
//        NULL: it is that already. w stays as it is; the aspect is 1 / sqrt of the rectangle's area, so that one unit
//        of w looks as long as one unit of u and v.
// out:   overwritten, not cleared.
// fails: KN_EDOMAIN (cell, the path's ending, a spline that is no polynomial surface (u,v,w)), and as kn_read_model;
//        out unchanged.
KN_API KN_CHECKED kn_status kn_read_tile(kn_ctx *ctx, kn_tile *out, const char *path, const double *cell);

// ---- writers: sinks that write to a temporary name beside path, and rename it when the job has ended ----
typedef struct kn_step_options {
    const char *product;   // name in the product structure; NULL: "knurl"
    double unit_mm;        // millimetres in one length unit; 0: 1
    double uncertainty_mm; // UNCERTAINTY_MEASURE_WITH_UNIT; 0: 1e-3
    const char
        *time_stamp; // ISO 8601 for the header; NULL: "1970-01-01T00:00:00", so that equal jobs give equal bytes
} kn_step_options;
KN_API KN_CHECKED kn_status kn_step_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_step_options *options);
KN_API KN_CHECKED kn_status kn_stl_sink(kn_ctx *ctx, kn_sink *out, const char *path);
KN_API KN_CHECKED kn_status kn_obj_sink(kn_ctx *ctx, kn_sink *out, const char *path); // and a .mtl beside it
// Counts bytes and patches, writes nothing.
KN_API KN_CHECKED kn_status kn_null_sink(kn_ctx *ctx, kn_sink *out);

#ifdef __cplusplus
}
#endif
#endif
