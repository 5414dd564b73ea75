// SPDX-License-Identifier: Apache-2.0
// Composition of one patch: kn_bezier_compose against the plain reference and the other nests, by multiply-adds, time
// and error, on one thread; and the machine's peak.
#include "bench/bench.h"

#include "compose/nest.h"
#include "kernel/gemm.h"

#include <knurl/compose.h>
#include <math.h>

typedef struct pairing {
    const char *name;
    kn_bezier outer, inner;
} pairing;

typedef struct task {
    kn_ctx *ctx;
    const pairing *pair;
    kn_bezier out;
    kn_nest *nest; // NULL: the public call
    double *factor, *value;
    int repeat;
    bool failed;
} task;

static double random_number(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

static kn_status make_piece(kn_ctx *ctx, kn_bezier *out, int nvars, int ncomp, const int *degree, uint64_t *state)
{
    kn_status status = kn_bezier_init(ctx, out, nvars, ncomp, false, degree);
    size_t n = status == KN_OK ? kn_bezier_count(out) * (size_t)ncomp : 0;
    for (size_t i = 0; i < n; i++) out->coef[i] = random_number(state);
    return status;
}

static void composed(void *user)
{
    task *t = user;
    for (int i = 0; i < t->repeat; i++)
        if (kn_bezier_compose(t->ctx, &t->out, &t->pair->outer, &t->pair->inner) != KN_OK) t->failed = true;
}

static void plain(void *user)
{
    task *t = user;
    if (kn_compose_plain(t->ctx, &t->out, &t->pair->outer, &t->pair->inner) != KN_OK) t->failed = true;
}

static int measure(kn_ctx *ctx, const pairing *pair, double peak)
{
    kn_nest nest;
    kn_nest_plan(&nest, &pair->outer, &pair->inner);
    double adds = kn_nest_cost(&nest, pair->outer.ncomp);
    task fast = {.ctx = ctx, .pair = pair, .repeat = (int)(2e7 / adds) + 1},
         slow = {.ctx = ctx, .pair = pair, .repeat = 1};
    bench_rival rival[2] = {{"compose", composed, &fast, 0, 0}, {"plain", plain, &slow, 0, 0}};
    bench_compare(rival, 2, BENCH_THREAD);
    double seconds = rival[0].seconds / fast.repeat;
    printf("%-28s %10.0f multiply-adds  %9.2f us  %5.1f GFLOP/s (%2.0f%% of peak)  plain %10.2f us\n", pair->name,
           adds, 1e6 * seconds, 2e-9 * adds / seconds, 200.0 * adds / seconds / peak, 1e6 * rival[1].seconds);
    kn_bezier_clear(ctx, &fast.out);
    kn_bezier_clear(ctx, &slow.out);
    return fast.failed || slow.failed;
}

int main(void)
{
    const char *isa;
    double peak = bench_peak_flops(&isa);
    kn_ctx *ctx = NULL;
    kn_ctx_options options = kn_ctx_defaults();
    options.threads = 1;
    if (kn_ctx_create(&ctx, &options) != KN_OK) return 1;
    printf("peak of one thread: %.1f GFLOP/s (%s)\n", peak * 1e-9, isa);
    static const struct {
        const char *name;
        int vars, outer[3], inner_vars, inner[3];
    } list[] = {{"surface (3,3) in (3,3,1)", 3, {3, 3, 1}, 2, {3, 3, 0}},
                {"surface (3,3) in (5,5,1)", 3, {5, 5, 1}, 2, {3, 3, 0}},
                {"surface (3,3) in (8,8,1)", 3, {8, 8, 1}, 2, {3, 3, 0}},
                {"volume (3,3,3) in (3,3,1)", 3, {3, 3, 1}, 3, {3, 3, 3}},
                {"curve 3 in surface (3,3)", 2, {3, 3, 0}, 1, {3, 0, 0}},
                {"curve 3 in volume (3,3,3)", 3, {3, 3, 3}, 1, {3, 0, 0}},
                {"surface (3,3) in (3,3)", 2, {3, 3, 0}, 2, {3, 3, 0}}};
    int failed = 0;
    uint64_t state = 1;
    for (size_t i = 0; i < sizeof list / sizeof *list; i++) {
        pairing p = {.name = list[i].name};
        failed |= make_piece(ctx, &p.outer, list[i].vars, 3, list[i].outer, &state) != KN_OK;
        failed |= make_piece(ctx, &p.inner, list[i].inner_vars, list[i].vars, list[i].inner, &state) != KN_OK;
        if (!failed) failed |= measure(ctx, &p, peak);
        kn_bezier_clear(ctx, &p.outer);
        kn_bezier_clear(ctx, &p.inner);
    }
    kn_ctx_destroy(ctx);
    return failed;
}
