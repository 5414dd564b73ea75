// SPDX-License-Identifier: Apache-2.0
// Limited degrees over composed patches: built-in tiles over several bases, for each profile and tolerance. Samples
// never pass the certificate, which is not far above them; edges are one curve for both of their faces.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <knurl/fit.h>

#include "io/brep.h"
#include "tests/support/patches.h"
#include "tests/support/surfaces.h"

// ---- what is looked at ----

enum { MOST_ALONG = 64, MOST_SPLITS = 7 };
typedef struct edge_pair {
    kn_brep_key exact, limited;
    bool turned;
    kn_patch_id of;
    int side;
    double angle;                    // the certificate; INFINITY: the edge is counted as unknown
    bool singular;                   // it is counted as having places without a normal
    double normal[2][MOST_ALONG][3]; // exact and limited, in the direction that both neighbours take
    double loose[MOST_ALONG];        // what rounding may turn both by, together
} edge_pair;

typedef struct trial {
    const char *tile;
    int base, k; // the profile k / 4 and the tolerance 10^-(1 + k % 4)
} trial;

typedef struct comparison {
    kn_ctx *ctx;
    test_rng rng;
    trial what;
    kn_fit_limits limits;
    size_t samples; // of each patch
    size_t along;   // of each edge
    const kn_patch_block *exact;
    edge_pair *edges;
    size_t nedges, room, patches, limited;
    double most;
    size_t unknown, wide, singular; // of edges, as the certificates have it
} comparison;

static double distance3(const double *a, const double *b)
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

// How far rounding may turn it; above 0.5, or NaN: there is none to speak of. A derivative errs by 2 n gamma(6 d) C,
// with coordinates C below 20, degrees d up to 56, and n = d, or 5 times 256 spans of d = 5: by less than 1.8e-10. So
// does the normal by that times |X_r| + |X_t|, whatever the angle between these; an arc is little more than its sine.
static double unit_normal(double n[3], const double *d)
{
    const double *r = d + 3, *t = d + 6;
    for (int c = 0; c < 3; c++) n[c] = r[(c + 1) % 3] * t[(c + 2) % 3] - r[(c + 2) % 3] * t[(c + 1) % 3];
    double size = hypot(hypot(n[0], n[1]), n[2]);
    for (int c = 0; c < 3; c++) n[c] /= size;
    return 2e-10 * (hypot(hypot(r[0], r[1]), r[2]) + hypot(hypot(t[0], t[1]), t[2])) / size;
}

// Between two lines.
static double angle_of(const double *a, const double *b)
{
    double x[3], dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    for (int c = 0; c < 3; c++) x[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    return atan2(hypot(hypot(x[0], x[1]), x[2]), fabs(dot));
}

static kn_brep_key key_of(const double *coef, int ncomp, size_t comp, size_t n, ptrdiff_t step)
{
    bool turned;
    return kn_brep_hash(&turned, coef, ncomp, comp, n, step);
}

static _Noreturn void say(const comparison *c, const edge_pair *a, const edge_pair *b, size_t i, const char *what)
{
    const trial *t = &c->what;
    printf("# tile %s, base %d, degree %d, tolerance %g: cell %d,%d, patch %d, edge %d", t->tile, t->base,
           c->limits.max_degree, c->limits.tolerance, a->of.cell[0], a->of.cell[1], a->of.patch, a->side);
    if (b) printf(" and cell %d,%d, patch %d, edge %d", b->of.cell[0], b->of.cell[1], b->of.patch, b->side);
    printf(", at place %zu of %zu: certified %.3g", i, c->along, a->angle);
    if (b) printf(" and %.3g, exact normals %.3g apart", b->angle, angle_of(a->normal[0][i], b->normal[0][i]));
    if (b) printf(", limited ones %.3g", angle_of(a->normal[1][i], b->normal[1][i]));
    printf(", of its own %.3g, rounding %.3g\n", angle_of(a->normal[0][i], a->normal[1][i]), a->loose[i]);
    fail_msg("%s", what);
    abort();
}

// Normals along edge e, its ends among the places: within the certificate of the exact ones.
static void note_normals(const comparison *c, edge_pair *to, const kn_bezier *a, const kn_patch *patch, int e)
{
    const kn_spline s = kn_patch_spline(patch);
    for (size_t i = 0; i < c->along; i++) {
        double x[9], y[9], at[2], along = (double)i / (double)(c->along - 1);
        at[e / 2] = e % 2, at[1 - e / 2] = to->turned ? 1.0 - along : along;
        assert_int_equal(kn_bezier_derivatives(c->ctx, x, a, at, 1), KN_OK);
        assert_int_equal(kn_spline_derivatives(c->ctx, y, &s, at, 1), KN_OK);
        to->loose[i] = unit_normal(to->normal[0][i], x) + unit_normal(to->normal[1][i], y);
        if (!(to->loose[i] < 0.5)) to->loose[i] = INFINITY;
        if (angle_of(to->normal[0][i], to->normal[1][i]) > to->angle + to->loose[i])
            say(c, to, NULL, i, "a normal is turned by more than is certified");
    }
}

// A singular edge has a place without a normal, and it is at halves of halves.
static void has_no_normal(const comparison *c, const edge_pair *to, const kn_bezier *a)
{
    double loose = 0.0;
    for (int i = 0; i <= 1 << MOST_SPLITS; i++) {
        double x[9], n[3], at[2];
        at[to->side / 2] = to->side % 2, at[1 - to->side / 2] = ldexp(i, -MOST_SPLITS);
        assert_int_equal(kn_bezier_derivatives(c->ctx, x, a, at, 1), KN_OK);
        double here = unit_normal(n, x);
        if (!(here <= loose)) loose = here >= 0.0 ? here : INFINITY;
    }
    if (!(loose > 1e-3)) say(c, to, NULL, 0, "an edge has normals everywhere, and is told as singular");
}

static void note_edges(comparison *c, const kn_bezier *a, const kn_patch *patch, const kn_fit_limited *report)
{
    const double *angle = report->edge_angle;
    size_t n = kn_bezier_count(a), m0 = (size_t)a->degree[0] + 1, m1 = (size_t)a->degree[1] + 1;
    const size_t first[4] = {0, (m0 - 1) * m1, 0, m1 - 1}, count[4] = {m1, m1, m0, m0};
    const ptrdiff_t step[4] = {1, 1, (ptrdiff_t)m1, (ptrdiff_t)m1};
    if (c->nedges + 4 > c->room) {
        c->room = 2 * c->room + 64;
        c->edges = realloc(c->edges, c->room * sizeof *c->edges);
        assert_non_null(c->edges);
    }
    for (int e = 0; e < 4; e++) {
        edge_pair *to = &c->edges[c->nedges++];
        to->exact = kn_brep_hash(&to->turned, a->coef + first[e], a->ncomp, n, count[e], step[e]);
        to->of = patch->id, to->side = e, to->angle = angle[e], to->singular = report->edge_singular[e];
        if (!(angle[e] < INFINITY)) c->unknown++;
        if (angle[e] < INFINITY && angle[e] > c->limits.angle) c->wide++;
        if (angle[e] < INFINITY && to->singular) c->singular++;
        if (to->singular) has_no_normal(c, to, a);
        note_normals(c, to, a, patch, e);
        to->limited = to->exact;
        if (!patch->edge) continue;
        const kn_spline *s = &patch->edge[e];
        to->limited = key_of(s->coef, s->ncomp, kn_spline_count(s), kn_spline_count(s), 1);
        if (s->degree[0] == a->degree[e < 2]) // kept: bit for bit
            assert_true(to->limited.a == to->exact.a && to->limited.b == to->exact.b);
    }
}

// The ends of the surface are its edges: knots were inserted, each with less than 30 roundings of coordinates.
static void edges_are_ends(comparison *c, const kn_patch *patch)
{
    for (int i = 0; i < 8; i++) {
        int e = i % 4;
        double along = test_uniform(&c->rng, 0.0, 1.0), at[2], x[3], y[3], size = 0.0;
        at[e / 2] = e % 2, at[1 - e / 2] = along;
        assert_int_equal(kn_spline_eval(c->ctx, x, patch->spline, at), KN_OK);
        assert_int_equal(kn_spline_eval(c->ctx, y, &patch->edge[e], &along), KN_OK);
        for (int k = 0; k < 3; k++) size = fmax(size, fabs(x[k]));
        assert_true(distance3(x, y) <= 200 * 0x1p-53 * (size + 1.0)); // with evaluation
    }
}

// The piece limited once more, for its certificates.
static void certified(const comparison *c, kn_fit_limited *report, const kn_bezier *a, const kn_patch *patch)
{
    kn_spline again = {0};
    assert_int_equal(kn_fit_limit_degree(c->ctx, &again, NULL, report, a, &c->limits), KN_OK);
    assert_true(report->exact == !patch->spline);
    kn_spline_clear(c->ctx, &again);
}

static void compare(comparison *c, const kn_bezier *a, const kn_patch *patch)
{
    double at[3] = {0.0}, x[9], y[9];
    kn_fit_limited report;
    c->patches++;
    certified(c, &report, a, patch);
    if (a->nvars == 2) note_edges(c, a, patch, &report);
    if (!patch->spline) { // as it came
        assert_true(patch->exact || patch->bezier.coef == a->coef);
        for (int v = 0; v < a->nvars; v++) assert_true(a->degree[v] <= c->limits.max_degree);
        return;
    }
    c->limited++;
    assert_true(!patch->exact && patch->bezier.coef == NULL);
    for (int v = 0; v < a->nvars; v++) assert_true(patch->spline->degree[v] <= c->limits.max_degree);
    for (size_t i = 0; i < c->samples; i++) {
        for (int v = 0; v < a->nvars; v++) at[v] = test_uniform(&c->rng, 0.0, 1.0);
        assert_int_equal(kn_bezier_eval(c->ctx, x, a, at), KN_OK);
        assert_int_equal(kn_spline_eval(c->ctx, y, patch->spline, at), KN_OK);
        c->most = fmax(c->most, distance3(x, y));
    }
    if (a->nvars != 2) return;
    edges_are_ends(c, patch);
}

// ---- two sinks: the first tells the second what the block was ----

static kn_status see_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    comparison *c = user;
    (void)ctx, (void)product;
    c->exact = block;
    return KN_OK;
}

static kn_status compare_begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    comparison *c = user;
    (void)ctx, (void)tile;
    for (int v = 0; v < 2; v++) assert_true(report->degree[v] <= c->limits.max_degree);
    if (report->fit_degree == 0) return KN_OK;
    assert_true(report->fit_degree == c->limits.max_degree && report->fit_tolerance > 0.0);
    return KN_OK;
}

static bool is_above(const kn_bezier *b, int degree)
{
    bool above = false;
    for (int v = 0; v < b->nvars; v++) above = above || b->degree[v] > degree;
    return above;
}

static kn_status compare_commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    comparison *c = user;
    size_t next = 0;
    (void)product;
    for (size_t i = 0; i < c->exact->count; i++) {
        const kn_patch *p = &c->exact->patches[i];
        if (p->mesh || p->bezier.nvars < 3 || !is_above(&p->bezier, c->limits.max_degree)) {
            if (!p->mesh) compare(c, &p->bezier, &block->patches[next]);
            next++;
            continue;
        }
        for (int k = 0; k < 6; k++) {
            kn_patch face = {0};
            if (p->hidden >> k & 1) continue;
            assert_int_equal(kn_patch_face(ctx, &face, p, k), KN_OK);
            compare(c, &face.bezier, &block->patches[next++]);
            kn_bezier_clear(ctx, &face.bezier);
        }
    }
    assert_int_equal(next, block->count);
    return KN_OK;
}

// ---- the cases ----

static int by_exact(const void *x, const void *y)
{
    const edge_pair *a = x, *b = y;
    if (a->exact.a != b->exact.a) return a->exact.a < b->exact.a ? -1 : 1;
    return a->exact.b < b->exact.b ? -1 : a->exact.b > b->exact.b;
}

// Where exact normals agree along an edge, those of both limited faces do within the angle; *smooth: how many do. Not
// along edges that the summary counts: of what is unknown nothing is promised, of what is wide what is certified.
static double seam_angle(const comparison *c, const edge_pair *a, const edge_pair *b, size_t *smooth)
{
    double most = 0.0, promised = fmax(2.0 * c->limits.angle, a->angle + b->angle);
    if (isinf(promised)) return 0.0;
    for (size_t i = 0; i < c->along; i++) {
        double loose = a->loose[i] + b->loose[i], here = angle_of(a->normal[1][i], b->normal[1][i]);
        // Stand-ins for the normal are within 1e-3. Smooth seams of composed patches agree to their rounding.
        if (angle_of(a->normal[0][i], b->normal[0][i]) > 1e-7 + loose) return 0.0;
        if (here > promised + 1e-7 + loose) say(c, a, b, i, "a smooth seam turns by more than the angle");
        if (loose < 1e-3) most = fmax(most, here);
    }
    ++*smooth;
    return most;
}

typedef struct figures {
    size_t cases, patches, limited, shared, unknown, wide, singular, smooth, points[4][4], faces[4][4];
    double ratio, turn, seam;
} figures;

// How many edges have two faces or more; both have one curve there.
static size_t shared_edges(comparison *c, figures *f, double *seam)
{
    size_t shared = 0;
    if (c->nedges > 0) qsort(c->edges, c->nedges, sizeof *c->edges, by_exact);
    for (size_t i = 1; i < c->nedges; i++) {
        const edge_pair *a = &c->edges[i - 1], *b = &c->edges[i];
        if (by_exact(a, b) != 0) continue;
        assert_true(a->limited.a == b->limited.a && a->limited.b == b->limited.b);
        shared++;
        *seam = fmax(*seam, seam_angle(c, a, b, &f->smooth));
    }
    return shared;
}

enum { BASES = 4 };
static bool make_base(kn_ctx *ctx, kn_spline *out, int base)
{
    if (base == 0) make_wavy(ctx, out);
    if (base == 1) make_torus(ctx, out);
    return base < 2 || make_teapot(ctx, out, base == 2 ? 0 : 13);
}

static const double USUAL_ANGLE = 0.017453292519943295; // one degree
static const int profiles[4] = {3, 11, 15, 25};

static kn_job *make_job(kn_ctx *ctx, const kn_tile *tile, const kn_spline *base)
{
    kn_job *job = NULL;
    int n[2];
    for (int v = 0; v < 2; v++) n[v] = kn_spline_spans(base, v) > 1 ? kn_spline_spans(base, v) : 2;
    kn_job_options o = {.count = {n[0], n[1]}, .height = 0.1, .normal_tol = 1e-3, .max_degree = KN_MAX_DEGREE};
    o.select.first = 0, o.select.count = 2;
    if (kn_job_create(ctx, &job, base, 1, tile, &o) != KN_OK) kn_ctx_clear_error(ctx); // degrees beyond KN_MAX_DEGREE
    return job;
}

static void try_case(kn_ctx *ctx, trial what, const kn_job *job, figures *f)
{
    const int k = what.k, max_degree = profiles[k / 4];
    const double tolerance = pow(10.0, -1 - k % 4);
    comparison c = {.ctx = ctx, .what = what, .rng = test_random(4 + (uint64_t)k)};
    kn_job_report report = kn_job_describe(job);
    kn_limit_summary sum;
    kn_sink inner = {.user = &c, .begin = compare_begin, .commit = compare_commit};
    kn_sink sinks[2] = {{.user = &c, .commit = see_commit}};
    size_t samples = (size_t)test_scale(600) < 10000 ? (size_t)test_scale(600) : 10000;
    double seam = 0.0;
    size_t faces = report.patches * (report.volumes > 0 ? 6 : 1);
    c.limits = (kn_fit_limits){.max_degree = max_degree, .tolerance = tolerance, .angle = 0.5 * USUAL_ANGLE};
    c.limits.quantum = exp2(floor(log2(tolerance / 1024.0)));
    c.samples = 1 + samples / faces;
    c.along = 3 + samples / (4 * faces) < MOST_ALONG ? 3 + samples / (4 * faces) : MOST_ALONG;
    assert_int_equal(kn_limit_sink(ctx, &sinks[1], &inner, 1,
                                   &(kn_limit_options){.max_degree = max_degree, .tolerance = tolerance}, &sum),
                     KN_OK);
    assert_int_equal(kn_job_run(ctx, job, sinks, 2), KN_OK);
    for (int i = 0; i < 2; i++) kn_sink_close(ctx, &sinks[i]);
    // Evaluation errs by some hundred roundings of coordinates below 20.
    assert_true(c.most <= sum.error + 1e-12 && sum.error <= tolerance);
    if (sum.error > 1e-10) assert_true(sum.error <= 10.0 * c.most);
    if (sum.error > 1e-10 && c.most > 0.0) f->ratio = fmax(f->ratio, sum.error / c.most);
    assert_true(c.limited == sum.limited && c.patches - c.limited == sum.exact);
    assert_true(c.unknown == sum.unknown_angles && c.wide == sum.wide_angles && c.singular == sum.singular_angles);
    assert_true(sum.wide_angles > 0 || sum.angle <= 0.5 * USUAL_ANGLE);
    f->turn = fmax(f->turn, sum.angle);
    f->unknown += sum.unknown_angles, f->wide += sum.wide_angles, f->singular += sum.singular_angles;
    f->points[k / 4][k % 4] += sum.control_points, f->faces[k / 4][k % 4] += c.patches;
    f->cases++, f->patches += c.patches, f->limited += c.limited, f->shared += shared_edges(&c, f, &seam);
    f->seam = fmax(f->seam, seam);
    free(c.edges);
}

static void try_pair(kn_ctx *ctx, trial what, bool (*wanted)(const trial *t), figures *f)
{
    kn_spline base = {0};
    kn_tile tile = {0};
    if (make_base(ctx, &base, what.base)) {
        assert_int_equal(kn_builtin_tile(ctx, &tile, what.tile), KN_OK);
        kn_job *job = make_job(ctx, &tile, &base);
        for (what.k = 0; what.k < 16 && job; what.k++)
            if (wanted(&what)) try_case(ctx, what, job, f);
        kn_job_destroy(ctx, job);
    }
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &base);
}

static bool some_or_all(const trial *t)
{
    uint64_t name = 0;
    for (const char *c = t->tile; *c; c++) name += (unsigned char)*c;
    return test_scale(1) >= 20 || t->k == 1 + t->base % 2 || t->k == 4 + (int)(name + (uint64_t)t->base) % 12;
}

// All built-in tiles over all bases, every profile and tolerance; of these some, chosen by the seed, unless
// KN_TEST_SCALE asks for more (60: all).
static void tiles_bases_profiles(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(1);
    figures f = {.cases = 0};
    int tiles = kn_builtin_tile_count(), all = tiles * BASES, some = test_scale(3);
    for (int i = 0, left = all; i < all; i++, left--) {
        if (test_int(&rng, 0, left - 1) >= some) continue;
        some--;
        try_pair(ctx, (trial){.tile = kn_builtin_tile_name(i / BASES), .base = i % BASES}, some_or_all, &f);
    }
    printf("# %zu cases, %zu patches, %zu limited, %zu shared edges; certificate at most %.2f times the samples; "
           "angles up to %.2g, %zu unknown, %zu wide, %zu singular; %zu smooth seams within %.2g at samples\n",
           f.cases, f.patches, f.limited, f.shared, f.ratio, f.turn, f.unknown, f.wide, f.singular, f.smooth, f.seam);
    for (int k = 0; k < 16 && test_scale(1) >= 20; k++)
        printf("# degree %d, tolerance 1e-%d: %.1f control points a face\n", profiles[k / 4], 1 + k % 4,
               (double)f.points[k / 4][k % 4] / (double)f.faces[k / 4][k % 4]);
    assert_true(f.limited > 0 && f.shared > 0 && f.smooth > 0);
    test_ctx_end(ctx, &memory);
}

// The fish has corners where its edges set out along one line, or at no speed: the derivative there is no more than
// rounding, of which any normal may be made. There is none, and such edges are told as singular; beside these
// corners their normals are kept as anywhere.
static bool coarse_cubics(const trial *t)
{
    return t->k == 2;
}
static void no_normal_at_a_corner(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    figures f = {.cases = 0};
    try_pair(ctx, (trial){.tile = "fish", .base = 3}, coarse_cubics, &f);
    assert_true(f.cases == 1 && f.unknown == 0 && f.wide == 0 && f.singular > 0 && f.smooth > 0);
    test_ctx_end(ctx, &memory);
}

// ---- by hand ----

enum { HAND = 3 };
typedef struct hand {
    test_tile tile;
    kn_patch patches[HAND]; // of degrees 9 x 3, 2 x 3 and, rational, 8 x 8
    kn_job_report report;
} hand;

static void hand_make(kn_ctx *ctx, hand *h)
{
    test_rng rng = test_random(3);
    static const int degree[HAND][2] = {{9, 3}, {2, 3}, {8, 8}};
    test_tile_make(&h->tile, 1);
    for (int i = 0; i < HAND; i++)
        test_patch(ctx, &h->patches[i], &rng, degree[i][0], degree[i][1], i == 2, 2.0 * i, 0.05);
    h->report = test_report(HAND, 9, 8);
}

static void hand_clear(kn_ctx *ctx, hand *h)
{
    for (int i = 0; i < HAND; i++) kn_bezier_clear(ctx, &h->patches[i].bezier);
}

static kn_status feed_counting(kn_ctx *ctx, const hand *h, size_t block, kn_limit_summary *sum, size_t *bytes)
{
    kn_sink inner[2] = {{0}}, sink;
    kn_status status = kn_null_sink(ctx, &inner[0]);
    if (status == KN_OK) status = kn_null_sink(ctx, &inner[1]);
    if (status == KN_OK)
        status = kn_limit_sink(ctx, &sink, inner, 2, &(kn_limit_options){.max_degree = 5, .tolerance = 1e-3}, sum);
    if (status != KN_OK) {
        kn_sink_close(ctx, &inner[0]);
        kn_sink_close(ctx, &inner[1]);
        return status;
    }
    status = test_feed(ctx, &sink, &h->tile.tile, &h->report, h->patches, HAND, block);
    *bytes = sink.bytes(sink.user);
    kn_sink_close(ctx, &sink);
    return status;
}

// Exact patches pass, others are counted with their errors; the same for blocks of any size. A spline of one span is
// a piece; one of several is refused.
static void summaries(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    hand h;
    kn_limit_summary sum[2];
    size_t bytes[2];
    hand_make(ctx, &h);
    for (size_t k = 0; k < 2; k++) {
        assert_int_equal(feed_counting(ctx, &h, 1 + 2 * k, &sum[k], &bytes[k]), KN_OK);
        assert_true(sum[k].exact == 1 && sum[k].limited == 2 && sum[k].error > 0.0 && sum[k].error <= 1e-3);
        assert_true(sum[k].degree[0] == 5 && sum[k].degree[1] == 5 && sum[k].angle > 0.0);
        assert_true(sum[k].control_points > 12 && sum[k].spans >= 3);
    }
    assert_memory_equal(&sum[0], &sum[1], sizeof sum[0]);
    assert_true(bytes[0] == bytes[1] && bytes[0] > 0);
    kn_spline whole = {0}, cut = {0};
    assert_int_equal(kn_spline_of_bezier(ctx, &whole, &h.patches[0].bezier), KN_OK);
    assert_int_equal(kn_spline_insert_knots(ctx, &cut, &whole, 0, &(double){0.5}, 1), KN_OK);
    kn_bezier kept = h.patches[0].bezier;
    h.patches[0].bezier = (kn_bezier){0};
    h.patches[0].spline = &whole;
    assert_int_equal(feed_counting(ctx, &h, 2, &sum[1], &bytes[1]), KN_OK);
    assert_memory_equal(&sum[0], &sum[1], sizeof sum[0]);
    h.patches[0].spline = &cut;
    assert_int_equal(feed_counting(ctx, &h, 2, &sum[1], &bytes[1]), KN_EDOMAIN);
    h.patches[0].bezier = kept;
    kn_spline_clear(ctx, &whole), kn_spline_clear(ctx, &cut);
    hand_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

// One that was begun with another angle, tolerance or degree is not gone on with.
static void refuses_others(kn_ctx *ctx, const hand *h, const unsigned char *data, size_t n)
{
    static const kn_limit_options others[] = {{5, 1e-3, 0.1}, {5, 2e-3, 0.0}, {6, 1e-3, 0.0}};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++) {
        kn_sink inner[2], sink;
        for (int k = 0; k < 2; k++) assert_int_equal(kn_null_sink(ctx, &inner[k]), KN_OK);
        assert_int_equal(kn_limit_sink(ctx, &sink, inner, 2, &others[i], NULL), KN_OK);
        assert_int_equal(sink.restore(ctx, sink.user, &h->tile.tile, &h->report, data, n), KN_EDOMAIN);
        assert_non_null(strstr(kn_ctx_message(ctx), "begun with"));
        kn_ctx_clear_error(ctx);
        kn_sink_close(ctx, &sink);
    }
}

// A run that goes on after its first block has the sums of one that was not interrupted.
static void goes_on(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    hand h;
    kn_limit_summary sum[2];
    size_t bytes[2], n = 0;
    unsigned char *data = NULL;
    hand_make(ctx, &h);
    assert_int_equal(feed_counting(ctx, &h, 3, &sum[0], &bytes[0]), KN_OK);
    for (int k = 0; k < 2; k++) {
        kn_sink inner[2], sink;
        kn_patch_block block = {(size_t)k, k ? 2 : 1, h.patches + k};
        void *product = NULL;
        for (int i = 0; i < 2; i++) assert_int_equal(kn_null_sink(ctx, &inner[i]), KN_OK);
        assert_int_equal(
            kn_limit_sink(ctx, &sink, inner, 2, &(kn_limit_options){.max_degree = 5, .tolerance = 1e-3}, &sum[1]),
            KN_OK);
        if (k) {
            assert_int_equal(sink.restore(ctx, sink.user, &h.tile.tile, &h.report, data, n - 1), KN_EDOMAIN);
            kn_ctx_clear_error(ctx);
            refuses_others(ctx, &h, data, n);
            assert_int_equal(sink.restore(ctx, sink.user, &h.tile.tile, &h.report, data, n), KN_OK);
        } else {
            assert_int_equal(sink.begin(ctx, sink.user, &h.tile.tile, &h.report), KN_OK);
        }
        assert_int_equal(sink.work(ctx, sink.user, &block, &product), KN_OK);
        assert_int_equal(sink.commit(ctx, sink.user, &block, product), KN_OK);
        if (!k) assert_int_equal(sink.save(ctx, sink.user, &data, &n), KN_OK);
        bytes[1] = sink.bytes(sink.user);
        kn_sink_close(ctx, &sink);
    }
    kn_free(ctx, data);
    assert_memory_equal(&sum[0], &sum[1], sizeof sum[0]);
    assert_int_equal(bytes[0], bytes[1]);
    hand_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

static void failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    hand h;
    kn_sink inner, sink, closed = {0};
    static const kn_limit_options bad[] = {{2, 1.0, 0.0},      {KN_MAX_DEGREE + 1, 1.0, 0.0},
                                           {5, 0.0, 0.0},      {5, NAN, 0.0},
                                           {5, INFINITY, 0.0}, {5, 1.0, -0.1},
                                           {5, 1.0, 0.9},      {5, 1.0, NAN}};
    hand_make(ctx, &h);
    assert_int_equal(kn_null_sink(ctx, &inner), KN_OK);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_limit_sink(ctx, &sink, &inner, 1, &bad[i], NULL), KN_EDOMAIN);
    assert_int_equal(
        kn_limit_sink(ctx, &sink, &inner, 0, &(kn_limit_options){.max_degree = 5, .tolerance = 1.0}, NULL),
        KN_EDOMAIN);
    assert_int_equal(
        kn_limit_sink(ctx, &sink, &closed, 1, &(kn_limit_options){.max_degree = 5, .tolerance = 1.0}, NULL),
        KN_EDOMAIN);
    kn_ctx_clear_error(ctx);
    // What cannot be had says of which patch.
    assert_int_equal(
        kn_limit_sink(ctx, &sink, &inner, 1, &(kn_limit_options){.max_degree = 5, .tolerance = 1e-30}, NULL), KN_OK);
    h.patches[0].id.cell[1] = 7;
    assert_int_equal(test_feed(ctx, &sink, &h.tile.tile, &h.report, h.patches, HAND, 2), KN_EUNDECIDED);
    assert_non_null(strstr(kn_ctx_message(ctx), "cell 0,7"));
    kn_sink_close(ctx, &sink);
    hand_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

static kn_status starved(kn_ctx *ctx, void *user)
{
    kn_limit_summary sum;
    size_t bytes;
    return feed_counting(ctx, user, 2, &sum, &bytes);
}

static void allocation_failures(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    hand h;
    hand_make(ctx, &h);
    test_allocation_failures(starved, &h);
    hand_clear(ctx, &h);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(summaries),
        cmocka_unit_test(goes_on),
        cmocka_unit_test(failures),
        cmocka_unit_test(allocation_failures),
        cmocka_unit_test(no_normal_at_a_corner),
        cmocka_unit_test(tiles_bases_profiles),
    };
    return cmocka_run_group_tests_name("io/limit_sink", tests, NULL, NULL);
}
