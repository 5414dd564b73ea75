// SPDX-License-Identifier: Apache-2.0
// Inside the renderer: stratified sample points of a pixel, the same whatever thread asks.
// Source: Burley, Practical hash-based Owen scrambling, JCGT 9(4), 2020.
#ifndef BRIDGES_EMBREE_SAMPLER_H
#define BRIDGES_EMBREE_SAMPLER_H

#include <cstdint>

namespace knr
{

inline uint32_t hash(uint32_t x)
{
    x ^= x >> 16, x *= 0x7feb352du;
    x ^= x >> 15, x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

inline uint32_t hash(uint32_t a, uint32_t b)
{
    return hash(a ^ (hash(b) + 0x9e3779b9u + (a << 6) + (a >> 2)));
}

inline uint32_t reverse_bits(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
    x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
    return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// A random nested permutation of binary digits, least significant first: digit k of the result depends on the digits
// below it alone.
inline uint32_t permute(uint32_t x, uint32_t seed)
{
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ (x * 0x8d22f6e6u);
}

struct point2 {
    float x, y;
};

// The points of one pixel, index 0 .. mask (a power of two less one): point(pair) is a Sobol (0,2) point in [0,1)^2,
// scrambled and shuffled for each pair.
struct sampler {
    uint32_t seed, index, mask;

    point2 point(uint32_t pair) const
    {
        uint32_t s = hash(seed, pair);
        uint32_t i = reverse_bits(permute(reverse_bits(index), s)) & mask, first = i, second = 0;
        for (uint32_t rest = i, v = 1u << 31; rest; rest >>= 1, v ^= v >> 1)
            if (rest & 1) second ^= v;
        return {unit(permute(first, s ^ 0x51633e2du)), unit(permute(reverse_bits(second), s ^ 0x68bc21ebu))};
    }
    static float unit(uint32_t reversed)
    {
        return static_cast<float>(reverse_bits(reversed) >> 8) * 0x1p-24f;
    }
};

} // namespace knr

#endif
