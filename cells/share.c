// SPDX-License-Identifier: Apache-2.0
// How many cells each knot span gets.
#include "cells/internal.h"

#include <math.h>

// What the floors of the shares leave over goes to the largest remainders, what the minimum of one took too much
// comes from the smallest.
void kn_cells_share(int *parts, const double *sums, int spans, int count)
{
    double total = sums[spans] - sums[0];
    int sum = 0;
    for (int i = 0; i < spans; i++) {
        double part = floor(count * ((sums[i + 1] - sums[i]) / total));
        parts[i] = part < 1.0 ? 1 : (int)part;
        sum += parts[i];
    }
    for (; sum != count; sum += sum < count ? 1 : -1) {
        int best = -1;
        double most = 0.0;
        for (int i = 0; i < spans; i++) {
            double rest = count * ((sums[i + 1] - sums[i]) / total) - parts[i], value = sum < count ? rest : -rest;
            if (sum > count && parts[i] == 1) continue;
            if (best < 0 || value > most) best = i, most = value;
        }
        parts[best] += sum < count ? 1 : -1;
    }
}
