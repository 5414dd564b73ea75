// SPDX-License-Identifier: Apache-2.0
#include "kernel/convolve.h"
#include "kernel/bernstein.h"

size_t kn_convolve_work(int nvars, const int *da, const int *db)
{
    (void)nvars, (void)da, (void)db;
    return 0;
}

// Variable by variable, the first one outermost; the places in c add as the indices do.
void kn_convolve_plain(double *c, int nvars, const double *a, const int *da, const double *b, const int *db,
                       double sign)
{
    if (nvars == 0) {
        c[0] += sign * (a[0] * b[0]);
        return;
    }
    size_t step_a = kn_bernstein_count(nvars - 1, da + 1), step_b = kn_bernstein_count(nvars - 1, db + 1), step_c = 1;
    for (int d = 1; d < nvars; d++) step_c *= (size_t)da[d] + (size_t)db[d] + 1;
    for (size_t i = 0; i <= (size_t)da[0]; i++)
        for (size_t j = 0; j <= (size_t)db[0]; j++)
            kn_convolve_plain(c + (i + j) * step_c, nvars - 1, a + i * step_a, da + 1, b + j * step_b, db + 1, sign);
}

void kn_convolve(double *c, int nvars, const double *a, const int *da, const double *b, const int *db, double sign,
                 double *work)
{
    (void)work;
    kn_convolve_plain(c, nvars, a, da, b, db, sign);
}
