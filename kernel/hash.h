// SPDX-License-Identifier: Apache-2.0
// Chance that is the same on every machine, in any order and on any thread: numbers hashed from what they belong to.
#ifndef KERNEL_HASH_H
#define KERNEL_HASH_H

#include <stdint.h>

// One step of SplitMix64 (Steele, Lea & Flood, Fast splittable pseudorandom number generators, OOPSLA 2014): a
// permutation of the 64-bit numbers.
static inline uint64_t kn_hash_mix(uint64_t x)
{
    x += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

// What h and one more number make together.
static inline uint64_t kn_hash_add(uint64_t h, uint64_t x)
{
    return kn_hash_mix(h ^ kn_hash_mix(x));
}

// A number in [0,1) of 53 bits.
static inline double kn_hash_unit(uint64_t h)
{
    return (double)(h >> 11) * 0x1p-53;
}

#endif
