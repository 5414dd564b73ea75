// SPDX-License-Identifier: Apache-2.0
// STEP, IGES and BREP files with something wrong in them, read one after the other in a process forked from one that has
// OCCT ready; when it ends, another goes on behind the file. No answer is a crash of knurl's own code, or a model that
// is none, and nothing takes longer or more than it may. OCCT itself does crash on some: that ends the process, which is
// why knurl has one for it.
//
// A long run counts what became of the files, and keeps those that took too long (OCCT's memory needs no sanitizer):
//
//     MMGT_OPT=1 ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1:malloc_context_size=1:quarantine_size_mb=4
//     KN_TEST_SCALE=2000 KN_TEST_SEED=7 KN_TEST_TMP=FOLDER t_occt_mutated step_files
#ifndef _GNU_SOURCE
#define _GNU_SOURCE // the place of a crash: ucontext.h
#endif
#include "tests/support/support.h"

#if KN_WITH_OCCT
#include "bridges/occt/cad_read.h"
#include "bridges/occt/occt_knob.h"
#include "bridges/occt/occt_probe.h"
#include "tests/bridges/mutate.h"
#include "tests/support/patches.h"
#include "tests/support/scene.h"

#include <knurl/iges.h>
#include <knurl/step.h>

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <ucontext.h>
#include <unistd.h>

// What became of a file, or how its process ended: by a crash or the limit of time, in knurl's own code or elsewhere.
enum { ACCEPTED, REFUSED, STARVED, NO_MODEL, TOO_MUCH, CRASHED_THERE = 40, CRASHED_HERE, ENDED_THERE, ENDED_HERE };
#if defined(__SANITIZE_ADDRESS__)
#include <dlfcn.h>
#include <execinfo.h>
enum { CPU_SECONDS = 2, MOST_MEGABYTES = 3000 };
#else
enum { CPU_SECONDS = 2, MOST_MEGABYTES = 2000 };
#endif
enum { PATIENCE = 120, MOST_BYTES = 1 << 20, BATCH = 200 };

// Where the processes are, in memory that they share.
typedef struct board {
    volatile int at; // the file in work, counted from 0
    volatile int count[STARVED + 1];
    int crashed, ended, findings;
} board;

extern char __executable_start, etext; // of the linker

static bool is_ours(uintptr_t at)
{
    return at >= (uintptr_t)&__executable_start && at < (uintptr_t)&etext;
}

static bool is_here(const void *context)
{
    uintptr_t at = 0;
#if defined(__x86_64__)
    at = (uintptr_t)((const ucontext_t *)context)->uc_mcontext.gregs[REG_RIP];
#else
    (void)context;
#endif
    return is_ours(at);
}

#if defined(__SANITIZE_ADDRESS__)
// The sanitizer calls it behind its report. What OCCT does with memory by functions of the C library is watched, too:
// that is a crash of OCCT.
__attribute__((visibility("default"))) void __asan_on_error(void);
void __asan_on_error(void)
{
    void *frame[64];
    int n = backtrace(frame, 64), i = 2; // behind the sanitizer's backtrace and this
    for (; i < n; i++) {
        Dl_info info;
        if (!dladdr(frame[i], &info) || !info.dli_fname || !strstr(info.dli_fname, "libasan")) break;
    }
    if (i < n && !is_ours((uintptr_t)frame[i])) _exit(CRASHED_THERE);
}
#endif

static void on_crash(int number, siginfo_t *info, void *context)
{
    (void)number, (void)info;
    _exit(is_here(context) ? CRASHED_HERE : CRASHED_THERE);
}

static void on_time(int number, siginfo_t *info, void *context)
{
    (void)number, (void)info;
    _exit(is_here(context) ? ENDED_HERE : ENDED_THERE);
}

static void limit(void)
{
    static char stack[1 << 16];
    sigaltstack(&(stack_t){.ss_sp = stack, .ss_size = sizeof stack}, NULL);
    struct sigaction action = {.sa_sigaction = on_crash, .sa_flags = SA_SIGINFO | SA_ONSTACK};
    const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    for (size_t i = 0; i < sizeof crashes / sizeof *crashes; i++) sigaction(crashes[i], &action, NULL);
    action.sa_sigaction = on_time;
    sigaction(SIGPROF, &action, NULL);
#if !defined(__SANITIZE_ADDRESS__) // which takes terabytes of addresses
    setrlimit(RLIMIT_AS, &(struct rlimit){(rlim_t)3 << 30, (rlim_t)3 << 30});
#endif
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    int nowhere = open("/dev/null", O_WRONLY); // where OCCT says what it finds
    if (nowhere >= 0) dup2(nowhere, STDOUT_FILENO);
}

// The way of a file: read, written as a stream, and that parsed.
static int look(const char *path)
{
    kn_ctx *ctx = NULL;
    kn_ctx_options options = {.threads = 1};
    if (kn_ctx_create(&ctx, &options) != KN_OK) return STARVED;
    kn_cad cad = {0}, again = {0};
    unsigned char *data = NULL;
    size_t bytes = 0;
    int code = NO_MODEL;
    kn_status status = kn_occt_read(ctx, &cad, path);
    if (status == KN_ENOMEM) {
        code = STARVED;
    } else if (status != KN_OK) {
        code = kn_ctx_message(ctx)[0] && !strchr(kn_ctx_message(ctx), '\n') && cad.nfaces == 0 ? REFUSED : NO_MODEL;
    } else if (cad.nfaces > 0 && kn_cad_write(ctx, &data, &bytes, &cad) == KN_OK &&
               kn_cad_parse(ctx, &again, "pipe", data, bytes) == KN_OK) {
        code = again.nfaces == cad.nfaces ? ACCEPTED : NO_MODEL;
    }
    kn_cad_clear(ctx, &cad);
    kn_cad_clear(ctx, &again);
    kn_free(ctx, data);
    kn_ctx_destroy(ctx);
    struct rusage used;
    getrusage(RUSAGE_SELF, &used);
    return used.ru_maxrss / 1024 > MOST_MEGABYTES ? TOO_MUCH : code;
}

typedef struct seed {
    char *text, *copy;
    size_t bytes;
    uint64_t salt;
    char path[TEST_PATH_BYTES]; // of what is made of it
} seed;

static void make_file(const seed *s, int i)
{
    test_rng rng = {s->salt + 0x9e3779b97f4a7c15u * (uint64_t)(i + 1)};
    memcpy(s->copy, s->text, s->bytes);
    test_write_file(s->path, s->copy, test_mutate(&rng, s->copy, s->bytes, MOST_BYTES));
}

// In the child: files from number b->at on.
static void serve(const seed *s, board *b, int n)
{
    limit();
    for (int left = BATCH; left > 0 && b->at < n; left--) {
        make_file(s, b->at);
        alarm(PATIENCE);
        setitimer(ITIMER_PROF, &(struct itimerval){.it_value = {.tv_sec = CPU_SECONDS}}, NULL);
        int code = look(s->path);
        if (code > STARVED) _exit(50 + code);
        b->count[code]++;
        b->at++;
    }
    _exit(ACCEPTED);
}

// A file that took too long, or worse, goes under a name of its own in a long run.
static void keep(const seed *s, int i, int code)
{
    char name[TEST_PATH_BYTES + 32];
    if (test_scale(1) == 1) return;
    make_file(s, i);
    snprintf(name, sizeof name, "%s.%d.%d", s->path, i, code);
    assert_int_equal(rename(s->path, name), 0);
}

static void judge(const seed *s, board *b, int how)
{
    int code = WIFEXITED(how) ? WEXITSTATUS(how) : -WTERMSIG(how);
    if (code == ACCEPTED) return; // the end of a batch
    if (code != CRASHED_THERE) keep(s, b->at, code);
    if (code == CRASHED_THERE) {
        b->crashed++;
    } else if (code == ENDED_THERE) {
        b->ended++;
    } else { // a hang (SIGALRM), a crash of ours, a report of the sanitizer, no model, too much memory
        print_message("%s: file %d: %d\n", s->path, b->at, code);
        b->findings++;
    }
    b->at++;
}

// How many of the files are findings.
static int run(const char *path, const char *ending, int n)
{
    char name[32];
    seed s = {.copy = malloc(MOST_BYTES)};
    board *b = mmap(NULL, sizeof *b, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    assert_non_null(s.copy);
    assert_ptr_not_equal(b, MAP_FAILED);
    s.text = test_read_file(path, &s.bytes);
    assert_non_null(s.text);
    assert_true(s.bytes < MOST_BYTES);
    test_rng rng = test_random(s.bytes);
    s.salt = test_bits(&rng);
    snprintf(name, sizeof name, "mutated%s", ending);
    test_tmp_path(s.path, name);
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (int how = 0; b->at < n; judge(&s, b, how)) {
        fflush(stdout);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) serve(&s, b, n);
        assert_int_equal(waitpid(child, &how, 0), child);
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    if (test_scale(1) > 1) // a long run is one to look at
        print_message("# %s, %zu bytes: %d files: %d accepted, %d refused, %d out of memory, OCCT crashed on %d, "
                      "%d took too long; %d findings; %ld s\n",
                      path, s.bytes, n, b->count[ACCEPTED], b->count[REFUSED], b->count[STARVED], b->crashed,
                      b->ended, b->findings, (long)(end.tv_sec - begin.tv_sec));
    int findings = b->findings;
    remove(s.path);
    munmap(b, sizeof *b);
    free(s.text), free(s.copy);
    return findings;
}

// ---- seeds ----

typedef kn_status (*seed_maker)(kn_ctx *ctx, const char *path, int which);

static kn_status by_occt(kn_ctx *ctx, const char *path, int which)
{
    return kn_occt_make(ctx, (kn_occt_kind)which, path);
}

static kn_status knob(kn_ctx *ctx, const char *path, int which)
{
    (void)which;
    return kn_occt_write_knob(ctx, path); // a part with names and colours
}

// By knurl: boxes on a plane, solids; in STEP they may be instances in an assembly, in IGES surfaces alone.
static kn_status boxes(kn_ctx *ctx, const char *path, int which)
{
    kn_job *job = NULL;
    kn_sink sink = {0};
    kn_spline base = {0};
    kn_tile tile = {0};
    kn_job_options options = {.count = {2, 1}};
    scene_multilinear(ctx, &base, 2, (double[]){0, 0, 0, 0, 5, 0, 5, 0, 0, 5, 5, 0});
    scene_box(ctx, &tile);
    kn_status status = kn_job_create(ctx, &job, &base, 1, &tile, &options);
    if (status == KN_OK)
        status = strstr(path, ".igs") ? kn_iges_sink(ctx, &sink, path, &(kn_iges_options){.surfaces = which})
                                      : kn_step_sink(ctx, &sink, path,
                                                     &(kn_step_options){.schema = KN_STEP_AP242, .instances = which});
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 1);
    if (sink.commit) kn_sink_close(ctx, &sink);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
    return status;
}

// By knurl: two trimmed patches, one with a hole, and a whole one, rational.
static kn_status trimmed(kn_ctx *ctx, const char *path, int which)
{
    kn_sink sink;
    test_tile tile;
    kn_patch patch[3];
    kn_bezier f = {0};
    kn_trim side[2] = {0}, whole = {0};
    kn_trim_cut_report cut;
    test_rng rng = test_random(11);
    static const double square[3] = {0.25, -0.25, 0.25};
    test_tile_make(&tile, 2);
    assert_int_equal(kn_bezier_init(ctx, &f, 2, 1, false, (int[]){2, 2}), KN_OK);
    for (int i = 0; i < 9; i++) f.coef[i] = square[i / 3] + square[i % 3] - 0.1;
    assert_int_equal(kn_trim_cut(ctx, &side[0], &side[1], &cut, &whole, &f, 5e-2), KN_OK);
    for (int i = 0; i < 3; i++) {
        test_patch(ctx, &patch[i], &rng, 2, 1 + i, i == 2, 2.0 * i, 0.1);
        patch[i].trim = i < 2 ? &side[i] : NULL;
        patch[i].look = patch[i].id.part = i % 2;
    }
    kn_job_report report = test_report(3, 3, 3);
    kn_status status = strstr(path, ".igs")
                           ? kn_iges_sink(ctx, &sink, path, &(kn_iges_options){.surfaces = which})
                           : kn_step_sink(ctx, &sink, path, &(kn_step_options){.schema = KN_STEP_AP203});
    for (int i = 0; i < 2; i++) { // what the sink is told beforehand
        report.trim_curves = side[i].ncurves > (int)report.trim_curves ? (size_t)side[i].ncurves : report.trim_curves;
        report.trim_spans += 1000;
    }
    if (status == KN_OK) {
        status = test_feed(ctx, &sink, &tile.tile, &report, patch, 3, 3);
        kn_sink_close(ctx, &sink);
    }
    for (int i = 0; i < 3; i++) kn_bezier_clear(ctx, &patch[i].bezier);
    for (int i = 0; i < 2; i++) kn_trim_clear(ctx, &side[i]);
    kn_bezier_clear(ctx, &f);
    return status;
}

typedef struct seed_kind {
    seed_maker make;
    int which;
    int thousandths; // of the files of its format
} seed_kind;

// Made in a process of its own, so that those of the files take little to fork.
static void make_seed(const seed_kind *kind, const char *path)
{
    fflush(stdout);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        kn_ctx *ctx = NULL;
        kn_status status = kn_ctx_create(&ctx, NULL);
        if (status == KN_OK) status = kind->make(ctx, path, kind->which);
        if (status != KN_OK) fprintf(stderr, "%s\n", kn_ctx_message(ctx));
        _exit(status != KN_OK);
    }
    int how = 0;
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_true(WIFEXITED(how) && WEXITSTATUS(how) == 0);
}

// OCCT is ready when it has read one of the format.
static void warm(const char *path)
{
    kn_ctx *ctx = NULL;
    kn_cad cad = {0};
    assert_int_equal(kn_ctx_create(&ctx, NULL), KN_OK);
    kn_status status = kn_occt_read(ctx, &cad, path);
    assert_string_equal(kn_ctx_message(ctx), "");
    assert_int_equal(status, KN_OK);
    kn_cad_clear(ctx, &cad);
    kn_ctx_destroy(ctx);
#if defined(__SANITIZE_ADDRESS__)
    void *frame[1];
    assert_int_equal(backtrace(frame, 1), 1); // the first call loads what it needs
#endif
}

static void of_kinds(const char *ending, const seed_kind *kinds, int nkinds, int n)
{
    int all = test_scale(n), findings = 0;
    for (int k = 0; k < nkinds; k++) {
        char path[TEST_PATH_BYTES], name[32];
        int files = (int)((long long)all * kinds[k].thousandths / 1000);
        snprintf(name, sizeof name, "seed%d%s", k, ending);
        test_tmp_path(path, name);
        make_seed(&kinds[k], path);
        if (k == 0) warm(path);
        findings += run(path, ending, files > 0 ? files : 1);
        remove(path);
    }
    assert_int_equal(findings, 0);
}

static void step_files(void **state)
{
    (void)state;
    static const seed_kind kinds[] = {{by_occt, KN_OCCT_CYLINDER, 250},
                                      {by_occt, KN_OCCT_TORUS, 250},
                                      {by_occt, KN_OCCT_SECTOR, 150},
                                      {by_occt, KN_OCCT_EXTRUDED, 150},
                                      {trimmed, 0, 60},
                                      {boxes, 1, 60},
                                      {by_occt, KN_OCCT_BOX, 50},
                                      {boxes, 0, 10},
                                      {knob, 0, 10},
                                      {by_occt, KN_OCCT_DRILLED, 5},
                                      {by_occt, KN_OCCT_KNOB, 5}};
    of_kinds(".step", kinds, sizeof kinds / sizeof *kinds, 50);
}

static void iges_files(void **state)
{
    (void)state;
    static const seed_kind kinds[] = {{by_occt, KN_OCCT_CYLINDER, 250},
                                      {by_occt, KN_OCCT_TORUS, 250},
                                      {by_occt, KN_OCCT_SECTOR, 150},
                                      {by_occt, KN_OCCT_EXTRUDED, 150},
                                      {by_occt, KN_OCCT_SPHERE, 80},
                                      {trimmed, 0, 30},
                                      {trimmed, 1, 30},
                                      {boxes, 0, 20},
                                      {boxes, 1, 20},
                                      {by_occt, KN_OCCT_BOX, 10},
                                      {by_occt, KN_OCCT_DRILLED, 5},
                                      {by_occt, KN_OCCT_KNOB, 5}};
    of_kinds(".igs", kinds, sizeof kinds / sizeof *kinds, 50);
}

static void brep_files(void **state)
{
    (void)state;
    static const seed_kind kinds[] = {
        {by_occt, KN_OCCT_CYLINDER, 400}, {by_occt, KN_OCCT_DRILLED, 400}, {by_occt, KN_OCCT_KNOB, 200}};
    of_kinds(".brep", kinds, sizeof kinds / sizeof *kinds, 25);
}

// Written by other programs, where they are present.
static void real_files(void **state)
{
    (void)state;
    static const struct {
        const char *path, *ending;
        int thousandths;
    } files[] = {{"../shared/data/splinecage.stp", ".stp", 1500},
                 {"../shared/data/surf114.igs", ".igs", 1000},
                 {"../shared/data/as1-oc-214.stp", ".stp", 100}};
    int present = 0, findings = 0;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        if (access(files[i].path, R_OK) != 0) continue;
        present++;
        warm(files[i].path);
        int n = (int)((long long)test_scale(1000) * files[i].thousandths / 1000000);
        findings += run(files[i].path, files[i].ending, n > 0 ? n : 1);
    }
    assert_int_equal(findings, 0);
    if (present > 0) return;
    print_message("../shared/data is not here: skipped\n");
    skip();
}

int main(int argc, char **argv)
{
    if (argc > 1) cmocka_set_test_filter(argv[1]);
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
