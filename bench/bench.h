// SPDX-License-Identifier: Apache-2.0
// What the benchmarks share: a clock, medians of runs taken in turn, and the machine's own limits, measured.
//
// Rivals run alternately in one process (bench_compare), so that a busy or throttled machine slows all of them; quote
// the ratio, which is the median of the rounds' ratios. Rates of arithmetic and memory mean little without the
// machine's peak, which bench_peak_flops and bench_peak_bytes measure on one thread in the same process.
#ifndef BENCH_BENCH_H
#define BENCH_BENCH_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

// Wall time for work on several threads; the calling thread's processor time for work on it alone, which does not
// count what other programs take.
typedef enum bench_clock { BENCH_WALL, BENCH_THREAD } bench_clock;

static inline double bench_now(bench_clock which)
{
    struct timespec t;
    clock_gettime(which == BENCH_WALL ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static inline int bench_by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// Sorts x.
static inline double bench_median(double *x, int n)
{
    qsort(x, (size_t)n, sizeof *x, bench_by_value);
    return n % 2 ? x[n / 2] : 0.5 * (x[n / 2 - 1] + x[n / 2]);
}

typedef struct bench_rival {
    const char *name;
    void (*work)(void *user);
    void *user;
    double seconds; // out: median of its runs
    double ratio;   // out: median over the rounds of rival 0's time / this one's time; above 1 is faster
} bench_rival;

enum { BENCH_ROUNDS = 15 };

// One warming round, then BENCH_ROUNDS rounds of all rivals in turn.
static inline void bench_compare(bench_rival *rivals, int n, bench_clock which)
{
    double *seconds = malloc((size_t)n * BENCH_ROUNDS * sizeof *seconds), column[BENCH_ROUNDS];
    if (!seconds) exit(1);
    for (int round = -1; round < BENCH_ROUNDS; round++)
        for (int i = 0; i < n; i++) {
            double start = bench_now(which);
            rivals[i].work(rivals[i].user);
            if (round >= 0) seconds[i * BENCH_ROUNDS + round] = bench_now(which) - start;
        }
    for (int i = n - 1; i >= 0; i--) {
        double *own = seconds + i * BENCH_ROUNDS;
        for (int r = 0; r < BENCH_ROUNDS; r++) column[r] = seconds[r] / own[r];
        rivals[i].ratio = bench_median(column, BENCH_ROUNDS);
        memcpy(column, own, sizeof column);
        rivals[i].seconds = bench_median(column, BENCH_ROUNDS);
    }
    free(seconds);
}

// ---- peak arithmetic of one thread: independent chains of multiply and add ----

enum { BENCH_CHAINS = 10, BENCH_STEPS = 200000 };

// Flops done; *sink keeps the compiler honest.
typedef double (*bench_flops)(double *sink);

static inline double bench_flops_plain(double *sink)
{
    double a[BENCH_CHAINS];
    for (int k = 0; k < BENCH_CHAINS; k++) a[k] = k;
    for (int i = 0; i < BENCH_STEPS; i++)
        for (int k = 0; k < BENCH_CHAINS; k++) a[k] = a[k] * 0.999 + 1e-3;
    for (int k = 0; k < BENCH_CHAINS; k++) *sink += a[k];
    return 2.0 * BENCH_CHAINS * BENCH_STEPS;
}

#if defined(__x86_64__)
__attribute__((target("avx2,fma"))) static inline double bench_flops_avx2(double *sink)
{
    __m256d a[BENCH_CHAINS], m = _mm256_set1_pd(0.999), c = _mm256_set1_pd(1e-3);
    double out[4];
    for (int k = 0; k < BENCH_CHAINS; k++) a[k] = _mm256_set1_pd(k);
    for (int i = 0; i < BENCH_STEPS; i++)
        for (int k = 0; k < BENCH_CHAINS; k++) a[k] = _mm256_fmadd_pd(a[k], m, c);
    for (int k = 0; k < BENCH_CHAINS; k++) {
        _mm256_storeu_pd(out, a[k]);
        *sink += out[0];
    }
    return 8.0 * BENCH_CHAINS * BENCH_STEPS;
}

__attribute__((target("avx512f"))) static inline double bench_flops_avx512(double *sink)
{
    __m512d a[BENCH_CHAINS], m = _mm512_set1_pd(0.999), c = _mm512_set1_pd(1e-3);
    double out[8];
    for (int k = 0; k < BENCH_CHAINS; k++) a[k] = _mm512_set1_pd(k);
    for (int i = 0; i < BENCH_STEPS; i++)
        for (int k = 0; k < BENCH_CHAINS; k++) a[k] = _mm512_fmadd_pd(a[k], m, c);
    for (int k = 0; k < BENCH_CHAINS; k++) {
        _mm512_storeu_pd(out, a[k]);
        *sink += out[0];
    }
    return 16.0 * BENCH_CHAINS * BENCH_STEPS;
}
#endif

// The widest of them that the machine has.
static inline bench_flops bench_peak_work(const char **isa)
{
    bench_flops work = bench_flops_plain;
    *isa = "scalar, not fused";
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) work = bench_flops_avx2, *isa = "AVX2 FMA";
    if (__builtin_cpu_supports("avx512f")) work = bench_flops_avx512, *isa = "AVX-512 FMA";
#endif
    return work;
}

// Flop/s of one thread with fused multiply-adds in the widest vectors of the machine (a multiplication and an
// addition that are not fused reach half of it). The best of a few runs.
static inline double bench_peak_flops(const char **isa)
{
    bench_flops work = bench_peak_work(isa);
    double sink = 0.0, best = 0.0;
    for (int i = 0; i < 9; i++) {
        double start = bench_now(BENCH_THREAD), flops = work(&sink), rate = flops / (bench_now(BENCH_THREAD) - start);
        if (rate > best) best = rate;
    }
    return sink == 0.125 ? 0.0 : best;
}

// Bytes/s of one thread through memory, read and written: copying 64 MiB. The best of a few runs; 0 without memory.
static inline double bench_peak_bytes(void)
{
    size_t n = (size_t)64 << 20;
    char *a = malloc(n), *b = malloc(n);
    double best = 0.0;
    if (a && b) {
        memset(a, 1, n);
        memset(b, 2, n);
        for (int i = 0; i < 5; i++) {
            double start = bench_now(BENCH_THREAD);
            memcpy(b, a, n);
            double rate = 2.0 * (double)n / (bench_now(BENCH_THREAD) - start);
            if (rate > best && b[n / 2] == 1) best = rate;
        }
    }
    free(a);
    free(b);
    return best;
}

#endif
