// SPDX-License-Identifier: Apache-2.0
// Seeded random numbers, files and small helpers.
#include "tests/support/support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

// Steele, Lea, Flood, Fast splittable pseudorandom number generators, OOPSLA 2014.
uint64_t test_bits(test_rng *rng)
{
    uint64_t z = rng->state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

test_rng test_random(uint64_t salt)
{
    const char *text = getenv("KN_TEST_SEED");
    uint64_t seed = text && *text ? strtoull(text, NULL, 10) : 1;
    static atomic_flag told = ATOMIC_FLAG_INIT;
    if (!atomic_flag_test_and_set(&told)) printf("# KN_TEST_SEED=%llu\n", (unsigned long long)seed);
    test_rng rng = {seed};
    rng.state = test_bits(&rng) ^ salt;
    test_bits(&rng);
    return rng;
}

double test_uniform(test_rng *rng, double lo, double hi)
{
    double unit = (double)(test_bits(rng) >> 11) * 0x1p-53;
    return lo + unit * (hi - lo);
}

int test_int(test_rng *rng, int lo, int hi)
{
    uint64_t range = (uint64_t)((int64_t)hi - lo) + 1;
    return (int)(lo + (int64_t)(test_bits(rng) % range));
}

int test_scale(int n)
{
    const char *text = getenv("KN_TEST_SCALE");
    double scale = text && *text ? strtod(text, NULL) : 1.0;
    double scaled = n * scale;
    return scaled < 1.0 ? 1 : scaled > 1e9 ? 1000000000 : (int)scaled;
}

int test_cases(int n)
{
    int scaled = test_scale(n);
    return scaled < n ? scaled : n;
}

double test_max_difference(const double *a, const double *b, size_t n)
{
    double most = 0.0;
    for (size_t i = 0; i < n; i++) {
        double difference = fabs(a[i] - b[i]);
        if (!isfinite(difference)) return INFINITY;
        most = fmax(most, difference);
    }
    return most;
}

void test_tmp_path(char path[TEST_PATH_BYTES], const char *name)
{
    const char *folder = getenv("KN_TEST_TMP");
    if (!folder || !*folder) folder = getenv("TMPDIR");
    if (!folder || !*folder) folder = "/tmp";
    int length = snprintf(path, TEST_PATH_BYTES, "%s/knurl-%ld-%s", folder, (long)getpid(), name);
    assert_true(length > 0 && length < TEST_PATH_BYTES);
}

char *test_read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    size_t size = 0, room = 4096;
    char *data = malloc(room);
    while (data) {
        size += fread(data + size, 1, room - size, file);
        if (size < room) break;
        char *more = realloc(data, room *= 2);
        if (!more) free(data);
        data = more;
    }
    bool bad = ferror(file);
    fclose(file);
    if (data && bad) {
        free(data);
        data = NULL;
    }
    if (data) data[size] = 0;
    if (data && bytes) *bytes = size;
    return data;
}

void test_write_file(const char *path, const void *data, size_t bytes)
{
    FILE *file = fopen(path, "wb");
    if (!file) fail_msg("cannot open %s", path);
    size_t written = fwrite(data, 1, bytes, file);
    int closed = fclose(file);
    if (written != bytes || closed) fail_msg("cannot write %s", path);
}
