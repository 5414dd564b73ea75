// SPDX-License-Identifier: Apache-2.0
// What every test program shares: allocators that count and fail, seeded random numbers, small random splines.
//
// Include this alone; it brings cmocka in. A test program is tests/<module>/t_<name>.c:
//
//     static void doubles(void **state) { ... assert_true(x == 2.0); }
//     int main(void)
//     {
//         const struct CMUnitTest tests[] = {cmocka_unit_test(doubles)};
//         return cmocka_run_group_tests_name("module/name", tests, NULL, NULL);
//     }
//
// Programs run with the repository's root as working directory. Environment, set by `make check`:
//     KN_TEST_SEED   seed of test_random (default 1)
//     KN_TEST_SCALE  multiplies the amount of random testing (default 1); test_scale
//     KN_TEST_TMP    a folder for files, removed afterwards; test_tmp_path
//     KNURL          the command, for tests/cli
#ifndef TESTS_SUPPORT_H
#define TESTS_SUPPORT_H

// clang-format off
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
// clang-format on

#include <stdatomic.h>
#include <stdbool.h>

#include <knurl/base.h>
#include <knurl/bezier.h>
#include <knurl/spline.h>

// ---- contexts that count and fail ----

// malloc with counters. The allocation (or growth) numbered fail_at, counted from 0, answers NULL; those before and
// after succeed. Safe from several threads.
typedef struct test_memory {
    atomic_size_t calls; // allocations and resizes asked for so far
    atomic_size_t live;  // blocks held now
    atomic_bool failed;  // the allocation fail_at has happened
    size_t fail_at;      // SIZE_MAX: never
} test_memory;

#define TEST_MEMORY_INIT                                                                                             \
    {                                                                                                                \
        .fail_at = SIZE_MAX                                                                                          \
    }

kn_allocator test_allocator(test_memory *memory);

// A context over *memory with this many threads (0: the default); never NULL, a failure ends the test.
kn_ctx *test_ctx(test_memory *memory, int threads);
// Destroys the context and asserts that no block of its memory is left: call it after the results are cleared.
void test_ctx_end(kn_ctx *ctx, test_memory *memory);

// Runs call(ctx, user) in a fresh one-threaded context with allocation 0 failing, then 1, then 2, ... until it
// answers KN_OK without a failure. Asserts each time: KN_ENOMEM from the call and in kn_ctx_error, and no block left
// once the context is destroyed; and that the call allocates at all. `call` makes its own operands (from user), calls
// what is tested, checks on failure that outputs are as they were, clears everything, and returns the status: of the
// first call that failed. Keep the data small: the cost is quadratic in the number of allocations.
typedef kn_status (*test_call)(kn_ctx *ctx, void *user);
void test_allocation_failures(test_call call, void *user);

// ---- random numbers: SplitMix64 ----

typedef struct test_rng {
    uint64_t state;
} test_rng;

// Depends on KN_TEST_SEED and salt alone; prints the seed once, as a comment that is shown when the
// program fails.
test_rng test_random(uint64_t salt);
uint64_t test_bits(test_rng *rng);
double test_uniform(test_rng *rng, double lo, double hi);
int test_int(test_rng *rng, int lo, int hi); // lo <= result <= hi

// n times KN_TEST_SCALE, at least 1.
int test_scale(int n);
// Of n cases the first test_scale(n), n at most: fewer where the sanitizers look at the paths and other builds at the
// values.
int test_cases(int n);

// ---- shapes: *out is overwritten; clear it. Coefficients are integers in [-bound, bound], weights in [1, bound]
// ----

void test_random_bezier(kn_ctx *ctx, kn_bezier *out, test_rng *rng, int nvars, int ncomp, bool rational,
                        const int *degree, int bound);
// Over [0, n] with integer knots; interior knots have random multiplicity up to degree.
void test_random_spline(kn_ctx *ctx, kn_spline *out, test_rng *rng, int nvars, int ncomp, bool rational,
                        const int *degree, const int *count, int bound);

// ---- small things ----

// max |a[i] - b[i]|; INFINITY when one of them is not finite.
double test_max_difference(const double *a, const double *b, size_t n);

enum { TEST_PATH_BYTES = 512 };
// path = a file name of this process alone in KN_TEST_TMP (else TMPDIR, else /tmp). Nothing is created.
void test_tmp_path(char path[TEST_PATH_BYTES], const char *name);

// A whole file in a new block, a zero byte after it; free() it. NULL when it cannot be read. bytes may be NULL.
char *test_read_file(const char *path, size_t *bytes);
// Ends the test when it cannot be written.
void test_write_file(const char *path, const void *data, size_t bytes);

#endif
