// SPDX-License-Identifier: Apache-2.0
// Dense coefficient arrays turned, mirrored and mapped.
#include "kernel/array.h"

#include <string.h>

#include <knurl/base.h>

void kn_array_reverse(double *out, const double *in, size_t outer, size_t n, size_t inner)
{
    for (size_t o = 0; o < outer; o++)
        for (size_t i = 0; i < n; i++)
            memcpy(out + (o * n + i) * inner, in + (o * n + n - 1 - i) * inner, inner * sizeof *out);
}

bool kn_array_is_order(int nvars, const int *order)
{
    bool seen[KN_MAX_VARS] = {false};
    for (int d = 0; d < nvars; d++) {
        if (order[d] < 0 || order[d] >= nvars || seen[order[d]]) return false;
        seen[order[d]] = true;
    }
    return true;
}

// Counts up out's indices; `from` follows by the steps that they have in the array in.
void kn_array_permute(double *out, const double *in, size_t ncomp, int nvars, const int *count, const int *order)
{
    size_t step_in[KN_MAX_VARS], step[KN_MAX_VARS], size = 1;
    int index[KN_MAX_VARS] = {0};
    for (int d = nvars - 1; d >= 0; d--) {
        step_in[d] = size;
        size *= (size_t)count[d];
    }
    for (int d = 0; d < nvars; d++) step[d] = step_in[order[d]];
    for (size_t done = 0, from = 0; done < ncomp * size; done++) {
        if (done % size == 0) from = done;
        out[done] = in[from];
        for (int d = nvars - 1; d >= 0; d--) {
            from += step[d];
            if (++index[d] < count[order[d]]) break;
            from -= (size_t)index[d] * step[d];
            index[d] = 0;
        }
    }
}

void kn_array_affine(double *out, const double *in, size_t n, int rows, int columns, const double *matrix,
                     const double *offset, const double *weight)
{
    for (int r = 0; r < rows; r++, out += n) {
        int c = 0;
        while (c < columns && matrix[r * columns + c] == 0.0) c++;
        for (size_t i = 0; i < n; i++) out[i] = c < columns ? matrix[r * columns + c] * in[(size_t)c * n + i] : 0.0;
        for (c++; c < columns; c++) {
            double m = matrix[r * columns + c];
            const double *from = in + (size_t)c * n;
            for (size_t i = 0; i < n && m != 0.0; i++) out[i] += m * from[i];
        }
        for (size_t i = 0; i < n && offset && offset[r] != 0.0; i++) out[i] += offset[r] * (weight ? weight[i] : 1.0);
    }
}

double kn_array_weighted_sum(const double *in, int nvars, const int *count, const double *const *weight)
{
    if (nvars == 0) return in[0];
    size_t inner = 1;
    double sum = 0.0;
    for (int d = 1; d < nvars; d++) inner *= (size_t)count[d];
    for (int i = 0; i < count[0]; i++) {
        double part = kn_array_weighted_sum(in + (size_t)i * inner, nvars - 1, count + 1, weight + 1);
        sum += weight[0] ? weight[0][i] * part : part;
    }
    return sum;
}
