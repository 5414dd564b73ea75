// SPDX-License-Identifier: Apache-2.0
// Gradient noise.
//
// With s = 6 t^5 - 15 t^4 + 10 t^3, d the offset from a corner of the lattice cell and g the corner's gradient, noise
// is sum over the eight corners of (prod of s or 1 - s) (g . d). With |g| = 1 it is at most sum w |d| <= sqrt(sum w
// |d|^2) (the w sum to 1), and that is sqrt of a sum over the axes of (1 - s) t^2 + s (1 - t)^2 <= 1/4: at most
// sqrt(3)/2. The twelve gradients are the edges' middles of a cube, of length sqrt(2): so the factor is sqrt(2/3).
#include "kernel/hash.h"

#include <knurl/field.h>
#include <math.h>

// g . d for one of the twelve gradients (+-1, +-1, 0), (+-1, 0, +-1), (0, +-1, +-1).
static double along_gradient(uint64_t hash, const double d[3])
{
    unsigned k = (unsigned)((hash >> 32) * 12 >> 32); // 0 .. 11, evenly
    unsigned axis = k / 4;
    double a = d[axis == 0 ? 1 : 0], b = d[axis == 2 ? 1 : 2];
    return ((k & 1) != 0 ? -a : a) + ((k & 2) != 0 ? -b : b);
}

double kn_noise(const double point[3], uint64_t seed)
{
    double t[3], s[3], sum = 0.0;
    uint64_t corner[3][2]; // hashed: exact integers below 2^51
    for (int c = 0; c < 3; c++) {
        if (!(fabs(point[c]) < 0x1p51)) return 0.0;
        double lattice = floor(point[c]);
        t[c] = point[c] - lattice;
        s[c] = t[c] * t[c] * t[c] * (t[c] * (t[c] * 6.0 - 15.0) + 10.0);
        corner[c][0] = (uint64_t)(int64_t)lattice;
        corner[c][1] = corner[c][0] + 1;
    }
    for (int i = 0; i < 2; i++) {
        uint64_t hash_i = kn_hash_add(seed, corner[0][i]);
        for (int j = 0; j < 2; j++) {
            uint64_t hash_ij = kn_hash_add(hash_i, corner[1][j]);
            double weight = (i == 0 ? 1.0 - s[0] : s[0]) * (j == 0 ? 1.0 - s[1] : s[1]);
            for (int k = 0; k < 2; k++) {
                const double d[3] = {t[0] - i, t[1] - j, t[2] - k};
                sum += weight * (k == 0 ? 1.0 - s[2] : s[2]) * along_gradient(kn_hash_add(hash_ij, corner[2][k]), d);
            }
        }
    }
    return sum * 0.81649658092772603; // sqrt(2/3)
}
