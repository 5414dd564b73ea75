// SPDX-License-Identifier: Apache-2.0
// A body for kn_step_host made by hand: a box of 4 x 4 x 2 without its lid, whose border is cut in the middles, and four
// patches for the lid.
#ifndef TESTS_SUPPORT_HOST_H
#define TESTS_SUPPORT_HOST_H

#include <knurl/step.h>

typedef struct test_host {
    kn_step_host host;
    kn_step_shell shell;
    kn_step_seed seed[8];
    kn_bezier lid[4];
    uint32_t faces[5];
    int shell_of[1];
    char *text;
} test_host;

// The lid rises to z = 3 in its middle, bilinear patch by patch: together 36 of volume. degree: of the lid's patches.
void test_host_make(kn_ctx *ctx, test_host *h, int degree);
void test_host_clear(kn_ctx *ctx, test_host *h);

#endif
