// SPDX-License-Identifier: Apache-2.0
// Exchanging two splines.
#include <knurl/spline.h>

void kn_spline_swap(kn_spline *a, kn_spline *b)
{
    kn_spline t = *a;
    *a = *b;
    *b = t;
}
