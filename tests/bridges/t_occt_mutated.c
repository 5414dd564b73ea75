// SPDX-License-Identifier: Apache-2.0
// STEP, IGES and BREP files with something wrong in them, read in a process each, forked from one that has OCCT
// ready: no answer is a crash of knurl's own code, or a model that is none, and nothing takes longer or more than it
// may. OCCT itself does crash on some: that ends the process, which is why knurl has one for it.
//
//     KN_TEST_SCALE=100 KN_TEST_SEED=7 t_occt_mutated
#ifndef _GNU_SOURCE
#define _GNU_SOURCE // the place of a crash: ucontext.h
#endif
#include "tests/support/support.h"

#if KN_WITH_OCCT
#include "bridges/occt/cad_read.h"
#include "bridges/occt/occt_probe.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <ucontext.h>
#include <unistd.h>

enum { ACCEPTED = 0, REFUSED = 3, STARVED = 4, NO_MODEL = 9, CRASHED_HERE = 40, CRASHED_THERE = 41 };
enum { CPU_SECONDS = 4, PATIENCE = 120, MOST_BYTES = 1 << 20 };

extern char __executable_start, etext; // of the linker

static void on_crash(int number, siginfo_t *info, void *context)
{
    (void)number, (void)info;
    uintptr_t at = 0;
#if defined(__x86_64__)
    at = (uintptr_t)((ucontext_t *)context)->uc_mcontext.gregs[REG_RIP];
#else
    (void)context;
#endif
    _exit(at >= (uintptr_t)&__executable_start && at < (uintptr_t)&etext ? CRASHED_HERE : CRASHED_THERE);
}

static void limit(void)
{
    static char stack[1 << 16];
    sigaltstack(&(stack_t){.ss_sp = stack, .ss_size = sizeof stack}, NULL);
    struct sigaction action = {.sa_sigaction = on_crash, .sa_flags = SA_SIGINFO | SA_ONSTACK};
    const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    for (size_t i = 0; i < sizeof crashes / sizeof *crashes; i++) sigaction(crashes[i], &action, NULL);
#if !defined(__SANITIZE_ADDRESS__) // which takes terabytes of addresses; what it finds ends with a code of its own
    setrlimit(RLIMIT_AS, &(struct rlimit){(rlim_t)3 << 30, (rlim_t)3 << 30});
#endif
    setrlimit(RLIMIT_CPU, &(struct rlimit){CPU_SECONDS, CPU_SECONDS});
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    alarm(PATIENCE);
    int nowhere = open("/dev/null", O_WRONLY); // where OCCT says what it finds
    if (nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
}

// In the child: what became of the file.
static int look(const char *path)
{
    kn_ctx *ctx = NULL;
    kn_ctx_options options = {.threads = 1};
    if (kn_ctx_create(&ctx, &options) != KN_OK) return STARVED;
    kn_cad cad = {0}, again = {0};
    unsigned char *data = NULL;
    size_t bytes = 0;
    kn_status status = kn_occt_read(ctx, &cad, path);
    if (status == KN_ENOMEM) return STARVED;
    if (status != KN_OK) return kn_ctx_message(ctx)[0] && cad.nfaces == 0 ? REFUSED : NO_MODEL;
    if (cad.nfaces < 1 || kn_cad_write(ctx, &data, &bytes, &cad) != KN_OK) return NO_MODEL;
    if (kn_cad_parse(ctx, &again, "pipe", data, bytes) != KN_OK) return NO_MODEL;
    kn_cad_clear(ctx, &cad);
    kn_cad_clear(ctx, &again);
    kn_free(ctx, data);
    return ACCEPTED;
}

static size_t place(test_rng *rng, size_t n)
{
    return n > 0 ? (size_t)(test_bits(rng) % n) : 0;
}

// A number in the text becomes another.
static size_t renumber(test_rng *rng, char *text, size_t n)
{
    static const char *const numbers[] = {"0",       "-1", "1.E308", "99999999", "0.", "-0.",
                                          "1.E-300", "1",  "17",     ".T.",      "$"};
    size_t at = place(rng, n), end, k = place(rng, sizeof numbers / sizeof *numbers), m = strlen(numbers[k]);
    while (at < n && (text[at] < '0' || text[at] > '9')) at++;
    for (end = at; end < n && ((text[end] >= '0' && text[end] <= '9') || text[end] == '.');) end++;
    if (at == n || n + m > MOST_BYTES) return n;
    memmove(text + at + m, text + end, n - end);
    memcpy(text + at, numbers[k], m);
    return n - (end - at) + m;
}

static size_t mutate(test_rng *rng, char *text, size_t n)
{
    static const char letters[] = "#0123456789().,;'$*E+- \nABCDEFGHIJKLMNOPQRSTUVWXYZ\377\0";
    char chunk[256];
    size_t a = place(rng, n), b = place(rng, n), m = 1 + place(rng, sizeof chunk - 1);
    switch (place(rng, 8)) {
    case 0:
        for (size_t i = 0; i <= m % 4; i++) text[place(rng, n)] = letters[place(rng, sizeof letters)];
        return n;
    case 1: // a piece less
        if (a + m > n) return n;
        memmove(text + a, text + a + m, n - a - m);
        return n - m;
    case 2: // a piece twice
        if (a + m > n || n + m > MOST_BYTES) return n;
        memcpy(chunk, text + a, m);
        memmove(text + b + m, text + b, n - b);
        memcpy(text + b, chunk, m);
        return n + m;
    case 3: // two pieces in each other's place
        if (a + m > n || b + m > n || (a < b + m && b < a + m)) return n;
        memcpy(chunk, text + a, m);
        memcpy(text + a, text + b, m);
        memcpy(text + b, chunk, m);
        return n;
    case 4: // the end in the middle
        if (n < 64 || a > n - 32) return n;
        memmove(text + a, text + n - 26, 26);
        return a + 26;
    default: return renumber(rng, text, n);
    }
}

typedef struct counts {
    int accepted, refused, starved, ended, crashed;
} counts;

static void judge(counts *c, int how, const char *path)
{
    int code = WIFEXITED(how) ? WEXITSTATUS(how) : -1;
    if (code == NO_MODEL || code == CRASHED_HERE) print_message("%s: %d\n", path, code);
    assert_int_not_equal(code, NO_MODEL);
    assert_int_not_equal(code, CRASHED_HERE);
    if (WIFSIGNALED(how)) assert_int_not_equal(WTERMSIG(how), SIGALRM); // a hang
    c->accepted += code == ACCEPTED;
    c->refused += code == REFUSED;
    c->starved += code == STARVED;
    c->ended += WIFSIGNALED(how) && (WTERMSIG(how) == SIGXCPU || WTERMSIG(how) == SIGKILL);
    c->crashed += code == CRASHED_THERE || (WIFSIGNALED(how) && WTERMSIG(how) != SIGXCPU && WTERMSIG(how) != SIGKILL);
    // under the sanitizer a defect of ours ends with its own code
    assert_true(WIFSIGNALED(how) || code == ACCEPTED || code == REFUSED || code == STARVED || code == CRASHED_THERE);
}

static void run(const char *seed, const char *ending, int n)
{
    size_t bytes = 0;
    char *text = test_read_file(seed, &bytes), path[TEST_PATH_BYTES], name[32], *copy = malloc(MOST_BYTES);
    assert_non_null(text);
    assert_non_null(copy);
    snprintf(name, sizeof name, "mutated%s", ending);
    test_tmp_path(path, name);
    test_rng rng = test_random(bytes);
    counts c = {0};
    for (int i = 0; i < n; i++) {
        size_t size = bytes < MOST_BYTES ? bytes : MOST_BYTES;
        memcpy(copy, text, size);
        for (size_t k = 1 + place(&rng, 3); k > 0; k--) size = mutate(&rng, copy, size);
        test_write_file(path, copy, size);
        fflush(stdout);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            limit();
            _exit(look(path));
        }
        int how = 0;
        assert_int_equal(waitpid(child, &how, 0), child);
        judge(&c, how, path);
    }
    if (test_scale(1) > 1) // a long run is one to look at
        print_message("# %s: %d files: %d accepted, %d refused, %d out of memory, %d ended, OCCT crashed on %d\n",
                      seed, n, c.accepted, c.refused, c.starved, c.ended, c.crashed);
    remove(path);
    free(text), free(copy);
}

static void made(const char *ending, const kn_occt_kind *kinds, int nkinds, int n)
{
    kn_ctx *ctx = NULL;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    for (int k = 0; k < nkinds; k++) {
        char path[TEST_PATH_BYTES], name[32];
        snprintf(name, sizeof name, "seed%d%s", k, ending);
        test_tmp_path(path, name);
        assert_int_equal(kn_occt_make(ctx, kinds[k], path), KN_OK);
        kn_cad cad = {0};
        assert_int_equal(kn_occt_read(ctx, &cad, path), KN_OK); // and OCCT is ready
        kn_cad_clear(ctx, &cad);
        run(path, ending, test_scale(n));
        remove(path);
    }
    kn_ctx_destroy(ctx);
}

static const kn_occt_kind kinds[] = {KN_OCCT_DRILLED, KN_OCCT_KNOB};

static void step_files(void **state)
{
    (void)state;
    made(".step", kinds, 2, 14);
}

static void iges_files(void **state)
{
    (void)state;
    made(".igs", kinds, 2, 14);
}

static void brep_files(void **state)
{
    (void)state;
    made(".brep", kinds, 2, 10);
}

// Written by other programs, where they are present.
static void real_files(void **state)
{
    (void)state;
    static const struct {
        const char *path, *ending;
        int n;
    } files[] = {{"../shared/data/splinecage.stp", ".stp", 4},
                 {"../shared/data/surf114.igs", ".igs", 2},
                 {"../shared/data/as1-oc-214.stp", ".stp", 1}};
    kn_ctx *ctx = NULL;
    int present = 0;
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        kn_cad cad = {0};
        if (access(files[i].path, R_OK) != 0) continue;
        present++;
        assert_int_equal(kn_occt_read(ctx, &cad, files[i].path), KN_OK);
        kn_cad_clear(ctx, &cad);
        run(files[i].path, files[i].ending, test_scale(files[i].n));
    }
    kn_ctx_destroy(ctx);
    if (present > 0) return;
    print_message("../shared/data is not here: skipped\n");
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(step_files), cmocka_unit_test(iges_files),
                                       cmocka_unit_test(brep_files), cmocka_unit_test(real_files)};
    return cmocka_run_group_tests_name("bridges/occt_mutated", tests, NULL, NULL);
}

#else

static void left_out(void **state)
{
    (void)state;
    skip();
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(left_out)};
    return cmocka_run_group_tests_name("bridges/occt_mutated", tests, NULL, NULL);
}

#endif
