// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target without libFuzzer: every file of a folder, every prefix of the shortest one, then N mutations.
//
//     fuzz_x FOLDER N      KN_TEST_SEED seeds the mutations; the input that crashes is left in ./crash-input
//
// A target is tests/fuzz/fuzz_<name>.c and defines LLVMFuzzerTestOneInput; its seeds lie in
// tests/fuzz/corpus/<name>/.
#include <dirent.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
void __sanitizer_set_death_callback(void (*callback)(void)) __attribute__((weak));

enum { MOST_BYTES = 1 << 16, MOST_SEEDS = 256, MOST_PREFIXES = 512 };

typedef struct input {
    uint8_t *data;
    size_t size;
} input;

typedef struct corpus {
    input seed[MOST_SEEDS];
    int count;
} corpus;

static input current; // what the target is looking at, for the death callback

static void save_current(void)
{
    FILE *file = fopen("crash-input", "wb");
    if (!file) return;
    fwrite(current.data, 1, current.size, file);
    fclose(file);
}

static void *need(void *block)
{
    if (block) return block;
    fprintf(stderr, "out of memory\n");
    exit(1);
}

// On a block of exactly size bytes, so that reading one byte too far is seen.
static void run(const uint8_t *data, size_t size)
{
    current = (input){.data = need(malloc(size ? size : 1)), .size = size};
    if (size) memcpy(current.data, data, size);
    LLVMFuzzerTestOneInput(current.data, size);
    free(current.data);
    current = (input){0};
}

static uint64_t next(uint64_t *state) // SplitMix64
{
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

static size_t below(uint64_t *state, size_t n)
{
    return n ? (size_t)(next(state) % n) : 0;
}

static bool load(corpus *c, const char *folder, const char *name)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    if (!file) return false;
    input *seed = &c->seed[c->count];
    seed->data = need(malloc(MOST_BYTES));
    seed->size = fread(seed->data, 1, MOST_BYTES, file);
    c->count += ferror(file) ? 0 : 1;
    fclose(file);
    return true;
}

static int by_name(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static void load_all(corpus *c, const char *folder)
{
    struct dirent **entries = NULL;
    int n = scandir(folder, &entries, NULL, by_name);
    for (int i = 0; i < n; i++) {
        if (entries[i]->d_name[0] != '.' && c->count < MOST_SEEDS) load(c, folder, entries[i]->d_name);
        free(entries[i]);
    }
    free(entries);
    if (c->count == 0) c->seed[c->count++] = (input){.data = need(calloc(MOST_BYTES, 1)), .size = 1};
}

// Replaces data[at .. at+cut-1] by n bytes of text; the buffer holds MOST_BYTES.
static size_t splice(uint8_t *data, size_t size, size_t at, size_t cut, const void *text, size_t n)
{
    if (cut > size - at) cut = size - at;
    if (size - cut + n > MOST_BYTES) return size;
    memmove(data + at + n, data + at + cut, size - at - cut);
    memcpy(data + at, text, n);
    return size - cut + n;
}

static size_t token(const uint8_t *data, size_t size, size_t *at)
{
    while (*at > 0 && data[*at - 1] > ' ') --*at;
    size_t n = 0;
    while (*at + n < size && data[*at + n] > ' ') n++;
    return n;
}

static size_t mutate(uint8_t *data, size_t size, const corpus *c, uint64_t *state)
{
    static const char *const words[] = {
        "0", "-1", "1e999", "nan", "-inf", "1000000000", "0.5", "1e-320", "", "2147483648", "18446744073709551616",
        "x"};
    size_t at = below(state, size), n = below(state, 16);
    const input *other = &c->seed[below(state, (size_t)c->count)];
    uint8_t byte = (uint8_t)below(state, 256);
    switch (size ? below(state, 7) : 0) {
    case 0: return splice(data, size, at, 0, &byte, 1);
    case 1: data[at] ^= (uint8_t)(1u << below(state, 8)); return size;
    case 2: data[at] = byte; return size;
    case 3: return splice(data, size, at, n, "", 0);
    case 4: return below(state, 8) ? size : at;
    case 5: {
        const char *word = words[below(state, sizeof words / sizeof *words)];
        size_t cut = token(data, size, &at);
        return splice(data, size, at, cut, word, strlen(word));
    }
    default: {
        size_t from = below(state, other->size);
        return splice(data, size, at, n, other->data + from, below(state, other->size - from + 1) % 256);
    }
    }
}

int main(int argc, char **argv)
{
    static corpus all;
    static uint8_t buffer[MOST_BYTES];
    const char *seed = getenv("KN_TEST_SEED");
    uint64_t state = seed && *seed ? strtoull(seed, NULL, 10) : 1;
    long runs = argc > 2 ? strtol(argv[2], NULL, 10) : 1000;
    if (__sanitizer_set_death_callback) __sanitizer_set_death_callback(save_current);
    load_all(&all, argc > 1 ? argv[1] : ".");

    run(buffer, 0);
    int shortest = 0;
    for (int i = 0; i < all.count; i++) {
        run(all.seed[i].data, all.seed[i].size);
        if (all.seed[i].size < all.seed[shortest].size) shortest = i;
    }
    size_t prefixes = all.seed[shortest].size < MOST_PREFIXES ? all.seed[shortest].size : MOST_PREFIXES;
    for (size_t n = 1; n < prefixes; n++) run(all.seed[shortest].data, n);
    for (long i = 0; i < runs; i++) {
        const input *from = &all.seed[below(&state, (size_t)all.count)];
        size_t size = from->size;
        memcpy(buffer, from->data, size);
        for (size_t k = 1 + below(&state, 4); k > 0; k--) size = mutate(buffer, size, &all, &state);
        run(buffer, size);
    }
    printf("%d seeds, %zu prefixes, %ld mutations\n", all.count, prefixes, runs);
    for (int i = 0; i < all.count; i++) free(all.seed[i].data);
    return 0;
}
