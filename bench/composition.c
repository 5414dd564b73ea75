// SPDX-License-Identifier: Apache-2.0
// Composition of one patch: kn_bezier_compose against the plain reference, and the nests that docs/composition.md
// compares, by multiply-adds, time and error, on one thread; with the machine's peak.
#include "bench/bench.h"

#include "compose/nest.h"
#include "kernel/binomial.h"
#include "kernel/convolve.h"

#include <knurl/compose.h>
#include <math.h>

enum { MOST = 1 << 16, VARS = 3 };

typedef struct pairing {
    const char *name;
    kn_bezier outer, inner;
} pairing;

// How the last variable of a nest is put in, its coefficients being polynomials.
typedef enum scheme { HALVED, HORNER, CASTELJAU } scheme;

typedef struct task {
    kn_ctx *ctx;
    const pairing *pair;
    kn_bezier out;
    kn_nest nest;
    kn_bezier view; // outer as the nest takes it
    scheme scheme;  // of the last variable; HALVED: the nest does it as well
    double *factor, *value;
    double adds; // counted in the schemes
    int repeat;
    bool failed;
} task;

static double random_number(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 11) / 9007199254740992.0;
}

// Everything is in [0,1], so that errors are relative.
static bool make_piece(kn_ctx *ctx, kn_bezier *out, int nvars, int ncomp, const int *degree, uint64_t *state)
{
    if (kn_bezier_init(ctx, out, nvars, ncomp, false, degree) != KN_OK) return false;
    size_t n = kn_bezier_count(out) * (size_t)ncomp;
    for (size_t i = 0; i < n; i++) out->coef[i] = random_number(state);
    return true;
}

static int total_degree(const kn_bezier *outer)
{
    int sum = 0;
    for (int d = 0; d < outer->nvars; d++) sum += outer->degree[d];
    return sum;
}

static void *scratch(task *t, size_t n)
{
    double *x = kn_scratch(t->ctx, n, sizeof *x);
    if (!x) exit(1);
    memset(x, 0, n * sizeof *x);
    return x;
}

// ---- the other schemes, on `batch` polynomials for each coefficient, of degrees g m ----
static void pack(const kn_convolution *p, double *to, const double *from, bool wide, const kn_nest *nest, int g)
{
    const size_t *step = nest->up[g - 1].sum_step;
    (wide ? kn_convolution_pack_wide : kn_convolution_pack_thin)(p, to, from, step, false);
}

// out += in power, on level k > 1.
static void times_power(task *t, double *out, const double *in, size_t batch, int g, const double *power, int k)
{
    int da[KN_MAX_VARS], db[KN_MAX_VARS];
    const kn_nest *nest = &t->nest;
    kn_convolution p;
    for (int d = 0; d < nest->inner; d++) da[d] = g * nest->m[d], db[d] = k * nest->m[d];
    kn_convolution_init(&p, kn_convolve_best(), nest->inner, da, db);
    kn_mark mark = kn_scratch_mark(t->ctx);
    double *thin = scratch(t, p.thin_room), *wide = scratch(t, p.wide_room);
    pack(&p, p.swapped ? thin : wide, power, !p.swapped, nest, k);
    for (size_t i = 0; i < batch; i++) {
        pack(&p, p.swapped ? wide : thin, in + i * nest->room[g], p.swapped, nest, g);
        kn_convolution_run(&p, out + i * nest->room[g + k], thin, wide, 1.0);
    }
    kn_scratch_release(t->ctx, mark);
    t->adds += (double)batch * nest->count[g] * nest->count[k];
}

static void times(task *t, double *out, const double *in, size_t batch, int g, const double *factor)
{
    if (kn_nest_times(t->ctx, out, &t->nest, in, batch, g, factor) != KN_OK) t->failed = true;
    t->adds += (double)batch * t->nest.count[g] * t->nest.count[1];
}

// h <- h x + f_i s^(p-i), i = p-1 .. 0: with powers of s.
static void horner(task *t, double *out, const double *f, int p, size_t batch, int g, const double *x,
                   const double *s)
{
    const kn_nest *nest = &t->nest;
    double *one = scratch(t, nest->room[0]), *power = scratch(t, nest->room[1]);
    const double *h = f + (size_t)p * batch * nest->room[g];
    one[0] = 1.0;
    times(t, power, one, 1, 0, s);
    for (int k = 1; k <= p; k++) {
        double *next = k == p ? out : scratch(t, batch * nest->room[g + k]);
        const double *term = f + (size_t)(p - k) * batch * nest->room[g];
        times(t, next, h, batch, g + k - 1, x);
        if (k == 1)
            times(t, next, term, batch, g, s);
        else
            times_power(t, next, term, batch, g, power, k);
        if (k < p) {
            double *higher = scratch(t, nest->room[k + 1]);
            times(t, higher, power, 1, k, s);
            power = higher;
        }
        h = next;
    }
}

// b_i <- s b_i + x b_(i+1): here the coefficients come without their binomials.
static void casteljau(task *t, double *out, const double *f, int p, size_t batch, int g, const double *x,
                      const double *s)
{
    const kn_nest *nest = &t->nest;
    const double *b = f;
    for (int level = 1; level <= p; level++, g++) {
        size_t rows = batch * (size_t)(p - level + 1);
        double *next = level == p ? out : scratch(t, rows * nest->room[g + 1]);
        times(t, next, b, rows, g, s);
        times(t, next, b + batch * nest->room[g], rows, g, x);
        b = next;
    }
}

static void run_nest(task *t)
{
    if (t->scheme == HALVED) {
        if (kn_nest_run(t->ctx, t->value, &t->nest, &t->view, t->factor) != KN_OK) t->failed = true;
        return;
    }
    kn_mark mark = kn_scratch_mark(t->ctx);
    int p = t->pair->outer.degree[VARS - 1], g = total_degree(&t->view);
    size_t batch = (size_t)t->pair->outer.ncomp;
    double *f = scratch(t, (size_t)t->view.ncomp * t->nest.room[g]);
    t->nest.outer = VARS - 1;
    if (kn_nest_run(t->ctx, f, &t->nest, &t->view, t->factor) != KN_OK) t->failed = true;
    t->adds = kn_nest_cost(&t->nest, t->view.ncomp);
    t->nest.outer = VARS;
    memset(t->value, 0, batch * t->nest.room[g + p] * sizeof *t->value);
    const double *x = t->factor + 2 * (size_t)(VARS - 1) * kn_bezier_count(&t->pair->inner);
    (t->scheme == HORNER ? horner : casteljau)(t, t->value, f, p, batch, g, x, x + kn_bezier_count(&t->pair->inner));
    kn_scratch_release(t->ctx, mark);
}

static void nested(void *user)
{
    task *t = user;
    for (int i = 0; i < t->repeat; i++) run_nest(t);
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

// ---- the reference: all Bernstein polynomials, in long double ----
static void multiply(long double *c, int nvars, const long double *a, const int *da, const long double *b,
                     const int *db)
{
    if (nvars == 0) {
        c[0] += a[0] * b[0];
        return;
    }
    size_t sa = 1, sb = 1, sc = 1;
    for (int d = 1; d < nvars; d++) {
        sa *= (size_t)da[d] + 1;
        sb *= (size_t)db[d] + 1;
        sc *= (size_t)(da[d] + db[d]) + 1;
    }
    for (size_t i = 0; i <= (size_t)da[0]; i++)
        for (size_t j = 0; j <= (size_t)db[0]; j++)
            multiply(c + (i + j) * sc, nvars - 1, a + i * sa, da + 1, b + j * sb, db + 1);
}

static long double *room(size_t n)
{
    long double *x = malloc(n * sizeof *x);
    if (!x) exit(1);
    return x;
}

// out = sum_i x^i s^(p-i) C(p,i) f(i) by de Casteljau, variable d of outer and those after it; answers the degree.
static int reference_from(const task *t, long double *out, int comp, int d, size_t at)
{
    const kn_bezier *outer = &t->pair->outer, *inner = &t->pair->inner;
    size_t n = kn_bezier_count(inner);
    if (d == outer->nvars) {
        out[0] = outer->coef[(size_t)comp * kn_bezier_count(outer) + at];
        return 0;
    }
    int p = outer->degree[d], g = 0, da[KN_MAX_VARS];
    long double *x = room(2 * n), *s = x + n, *next = room(MOST), *b[KN_MAX_DEGREE + 1] = {room(MOST)};
    for (size_t i = 0; i < n; i++) { // the factors are scaled: their weights from a 1 would be the same
        double value = inner->coef[(size_t)d * n + i], w = 1.0;
        size_t rest = i;
        for (int k = inner->nvars - 1; k >= 0; k--) {
            w *= kn_binomial(inner->degree[k], (int)(rest % (size_t)(inner->degree[k] + 1)));
            rest /= (size_t)(inner->degree[k] + 1);
        }
        x[i] = (long double)w * value;
        s[i] = (long double)w * (1.0L - value);
    }
    for (int i = 0; i <= p; i++) {
        if (i > 0) b[i] = room(MOST);
        g = reference_from(t, b[i], comp, d + 1, at * (size_t)(p + 1) + (size_t)i);
    }
    for (int level = 1; level <= p; level++, g++)
        for (int i = 0; i <= p - level; i++) {
            for (int k = 0; k < inner->nvars; k++) da[k] = g * inner->degree[k];
            for (size_t k = 0; k < (size_t)t->nest.count[g + 1]; k++) next[k] = 0.0L;
            multiply(next, inner->nvars, b[i], da, s, inner->degree);
            multiply(next, inner->nvars, b[i + 1], da, x, inner->degree);
            long double *swap = b[i];
            b[i] = next, next = swap;
        }
    memcpy(out, b[0], (size_t)t->nest.count[g] * sizeof *out);
    for (int i = 1; i <= p; i++) free(b[i]);
    free(b[0]);
    free(next);
    free(x);
    return g;
}

// The largest relative error of coefficients, in units of 2^-53; reference is scaled.
static double error_of(const task *t, const long double *reference)
{
    size_t n = (size_t)t->nest.count[t->nest.sum], ncomp = (size_t)t->pair->outer.ncomp;
    double worst = 0.0, *value = malloc(n * ncomp * sizeof *value);
    if (!value) return INFINITY;
    kn_nest_divide(value, &t->nest, t->value, t->pair->outer.ncomp);
    for (size_t i = 0; i < n * ncomp; i++) {
        long double weight = 1.0L;
        size_t rest = i % n;
        for (int d = t->nest.inner - 1; d >= 0; d--) {
            int p = t->nest.sum * t->nest.m[d];
            weight *= (long double)kn_binomial(p, (int)(rest % (size_t)(p + 1)));
            rest /= (size_t)(p + 1);
        }
        worst = fmax(worst, fabs((double)(value[i] * weight / reference[i] - 1.0L)));
    }
    free(value);
    return worst * 0x1p53;
}

// ---- which nests ----
// Variable d of the copy is variable order[d]: outer's variables and inner's components.
static bool permuted(kn_ctx *ctx, pairing *out, const pairing *pair, const int *order)
{
    int degree[VARS], index[VARS];
    const kn_bezier *outer = &pair->outer, *inner = &pair->inner;
    for (int d = 0; d < VARS; d++) degree[d] = outer->degree[order[d]];
    if (kn_bezier_init(ctx, &out->outer, VARS, outer->ncomp, false, degree) != KN_OK) return false;
    if (kn_bezier_init(ctx, &out->inner, inner->nvars, VARS, false, inner->degree) != KN_OK) return false;
    size_t n = kn_bezier_count(outer), m = kn_bezier_count(inner);
    for (int d = 0; d < VARS; d++)
        memcpy(out->inner.coef + (size_t)d * m, inner->coef + (size_t)order[d] * m, m * sizeof(double));
    for (size_t k = 0; k < n; k++) {
        size_t rest = k, at = 0;
        for (int d = VARS - 1; d >= 0; d--) {
            index[order[d]] = (int)(rest % (size_t)(degree[d] + 1));
            rest /= (size_t)(degree[d] + 1);
        }
        for (int d = 0; d < VARS; d++) at = at * (size_t)(outer->degree[d] + 1) + (size_t)index[d];
        for (size_t c = 0; c < (size_t)outer->ncomp; c++) out->outer.coef[c * n + k] = outer->coef[c * n + at];
    }
    return true;
}

// outer without its last variable, whose coefficients become components, slowest.
static bool make_view(task *t)
{
    const kn_bezier *outer = &t->pair->outer;
    int p = outer->degree[VARS - 1];
    size_t count = kn_bezier_count(outer), ncomp = (size_t)outer->ncomp, rest = count / (size_t)(p + 1);
    if (kn_bezier_init(t->ctx, &t->view, VARS - 1, outer->ncomp * (p + 1), false, outer->degree) != KN_OK)
        return false;
    for (size_t c = 0; c < ncomp; c++)
        for (size_t k = 0; k < count; k++) {
            size_t i = k % (size_t)(p + 1);
            double binomial = t->scheme == HORNER ? kn_binomial(p, (int)i) : 1.0;
            t->view.coef[(i * ncomp + c) * rest + k / (size_t)(p + 1)] = binomial * outer->coef[c * count + k];
        }
    return true;
}

// The first `expanded` variables are expanded, the others put in one by one: halved, or the last one by a scheme.
static bool set_up(task *t, int expanded)
{
    const pairing *pair = t->pair;
    t->nest.expanded = expanded;
    for (int d = 0; d < VARS; d++) t->nest.order[d] = d;
    kn_nest_shape(&t->nest, &pair->outer, &pair->inner);
    t->factor = malloc(2 * VARS * kn_bezier_count(&pair->inner) * sizeof(double));
    t->value = aligned_alloc(64, t->nest.room[t->nest.sum] * (size_t)pair->outer.ncomp * sizeof(double));
    if (!t->factor || !t->value) return false;
    if (kn_nest_factors(t->ctx, t->factor, &t->nest, &pair->inner, NULL, NULL) != KN_OK) return false;
    if (t->scheme == HALVED) {
        t->adds = kn_nest_cost(&t->nest, pair->outer.ncomp);
        return kn_bezier_copy(t->ctx, &t->view, &pair->outer) == KN_OK;
    }
    return make_view(t);
}

typedef struct variant {
    const char *name;
    int order[VARS], expanded;
    scheme scheme;
} variant;

static bool measure_nest(kn_ctx *ctx, const pairing *pair, const variant *v, const long double *reference)
{
    pairing own = {.name = pair->name};
    task t = {.ctx = ctx, .pair = &own, .scheme = v->scheme, .repeat = 1};
    bool ok = permuted(ctx, &own, pair, v->order) && set_up(&t, v->expanded);
    if (ok) {
        run_nest(&t);
        double worst = error_of(&t, reference);
        t.repeat = (int)(2e7 / t.adds) + 1;
        bench_rival rival = {v->name, nested, &t, 0, 0};
        bench_compare(&rival, 1, BENCH_THREAD);
        printf("  %-58s %10.0f multiply-adds %9.2f us  error %5.1f u\n", v->name, t.adds,
               1e6 * rival.seconds / t.repeat, worst);
    }
    free(t.factor);
    free(t.value);
    kn_bezier_clear(ctx, &t.view);
    kn_bezier_clear(ctx, &own.outer);
    kn_bezier_clear(ctx, &own.inner);
    return ok && !t.failed;
}

static bool measure_nests(kn_ctx *ctx, const pairing *pair)
{
    static const variant list[] = {
        {"x and z expanded, y halved", {0, 2, 1}, 2, HALVED},
        {"x and z expanded, y by Horner with powers of 1 - y", {0, 2, 1}, 2, HORNER},
        {"x and z expanded, y by de Casteljau", {0, 2, 1}, 2, CASTELJAU},
        {"x expanded, z put in, y halved", {0, 2, 1}, 1, HALVED},
        {"x expanded, y halved, z put in last", {0, 1, 2}, 1, HALVED},
        {"z expanded, x halved, y halved", {2, 0, 1}, 1, HALVED},
        {"x and y expanded, z put in last", {0, 1, 2}, 2, HALVED},
        {"all expanded", {0, 1, 2}, 3, HALVED},
    };
    task t = {.ctx = ctx, .pair = pair};
    kn_nest_shape(&t.nest, &pair->outer, &pair->inner);
    size_t n = (size_t)t.nest.count[t.nest.sum], ncomp = (size_t)pair->outer.ncomp;
    long double *reference = malloc(n * ncomp * sizeof *reference);
    bool ok = reference != NULL;
    for (size_t c = 0; ok && c < ncomp; c++) reference_from(&t, reference + c * n, (int)c, 0, 0);
    for (size_t i = 0; ok && i < sizeof list / sizeof *list; i++) ok = measure_nest(ctx, pair, &list[i], reference);
    free(reference);
    return ok;
}

static bool measure(kn_ctx *ctx, const pairing *pair, double peak)
{
    task fast = {.ctx = ctx, .pair = pair}, slow = fast;
    kn_nest_plan(&fast.nest, &pair->outer, &pair->inner);
    double adds = kn_nest_cost(&fast.nest, pair->outer.ncomp);
    fast.repeat = (int)(2e7 / adds) + 1;
    bench_rival rival[2] = {{"compose", composed, &fast, 0, 0}, {"plain", plain, &slow, 0, 0}};
    bench_compare(rival, 2, BENCH_THREAD);
    double seconds = rival[0].seconds / fast.repeat;
    printf("%-26s %9.2f us, limit %8.2f us (%.0f multiply-adds), %.1f GFLOP/s; plain reference %.0f us\n", pair->name,
           1e6 * seconds, 2e6 * adds / peak, adds, 2e-9 * adds / seconds, 1e6 * rival[1].seconds);
    kn_bezier_clear(ctx, &fast.out);
    kn_bezier_clear(ctx, &slow.out);
    return !fast.failed && !slow.failed;
}

int main(void)
{
    static const struct {
        const char *name;
        int vars, outer[VARS], inner_vars, inner[VARS];
        bool nests;
    } list[] = {{"surface (3,3) in (3,3,1)", 3, {3, 3, 1}, 2, {3, 3, 0}, true},
                {"surface (3,3) in (5,5,1)", 3, {5, 5, 1}, 2, {3, 3, 0}, true},
                {"surface (3,3) in (8,8,1)", 3, {8, 8, 1}, 2, {3, 3, 0}, true},
                {"volume (3,3,3) in (3,3,1)", 3, {3, 3, 1}, 3, {3, 3, 3}, true},
                {"curve 3 in surface (3,3)", 2, {3, 3, 0}, 1, {3, 0, 0}, false},
                {"curve 3 in volume (3,3,3)", 3, {3, 3, 3}, 1, {3, 0, 0}, false},
                {"surface (3,3) in (3,3)", 2, {3, 3, 0}, 2, {3, 3, 0}, false}};
    const char *isa;
    double peak = bench_peak_flops(&isa);
    kn_ctx *ctx = NULL;
    kn_ctx_options options = kn_ctx_defaults();
    options.threads = 1;
    if (kn_ctx_create(&ctx, &options) != KN_OK) return 1;
    printf("one thread; peak %.1f GFLOP/s (%s)\n", peak * 1e-9, isa);
    bool ok = true;
    uint64_t state = 1;
    for (size_t i = 0; ok && i < sizeof list / sizeof *list; i++) {
        pairing p = {.name = list[i].name};
        ok = make_piece(ctx, &p.outer, list[i].vars, 3, list[i].outer, &state) &&
             make_piece(ctx, &p.inner, list[i].inner_vars, list[i].vars, list[i].inner, &state) &&
             measure(ctx, &p, peak) && (!list[i].nests || measure_nests(ctx, &p));
        kn_bezier_clear(ctx, &p.outer);
        kn_bezier_clear(ctx, &p.inner);
    }
    kn_ctx_destroy(ctx);
    return !ok;
}
