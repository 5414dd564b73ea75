// SPDX-License-Identifier: Apache-2.0
// The same faces for Open CASCADE's writers as for knurl's: for benchmarks.
#ifndef BRIDGES_OCCT_BENCH_H
#define BRIDGES_OCCT_BENCH_H

#include <knurl/base.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct kn_occt_bench kn_occt_bench;

// One shell of nu x nv bicubic faces with shared edges and vertices, curves in the plane included. net: the 16
// control points of face (i,j), the second variable fastest; those on edges are the same for both faces. *out:
// kn_occt_bench_close. fails: KN_EUNDECIDED (OCCT threw), KN_ENOMEM; *out unchanged.
KN_CHECKED kn_status kn_occt_bench_grid(kn_ctx *ctx, kn_occt_bench **out, int nu, int nv,
                                        void (*net)(double point[16][3], int i, int j));
typedef enum kn_occt_writer {
    KN_OCCT_STEP,      // without curves in the plane
    KN_OCCT_IGES,      // as trimmed surfaces, which is what it does unless told
    KN_OCCT_IGES_BREP, // as a shell
} kn_occt_writer;
// fails: KN_EIO, KN_EUNDECIDED.
KN_CHECKED kn_status kn_occt_bench_write(kn_ctx *ctx, const kn_occt_bench *bench, const char *path,
                                         kn_occt_writer how);
void kn_occt_bench_close(kn_occt_bench *bench); // NULL is fine

#ifdef __cplusplus
}
#endif
#endif
