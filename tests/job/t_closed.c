// SPDX-License-Identifier: Apache-2.0
// Bodies that STEP files close, against bodies that are found by distance: which edges of composed patches lie in the
// same place, and which patches hang together by them.
#include "tests/support/scene.h"
#include "tests/support/surfaces.h"
#include "tests/support/support.h"

#include <knurl/io.h>
#include <knurl/step.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PLACES = 5 };

// An edge of a face, by points on it, from the end that comes first; what is the same edge differs by rounding and by
// what the base's edges do, 1e-6 of its size, which is far below the length of any edge here.
typedef struct edge {
    double at[PLACES][3];
    size_t face;
    double key;
    bool mated, crowded;
} edge;

typedef struct edges {
    edge *list;
    size_t n, room, nfaces;
    size_t *parent;
} edges;

static double apart(const double *p, const double *q)
{
    return fmax(fabs(p[0] - q[0]), fmax(fabs(p[1] - q[1]), fabs(p[2] - q[2])));
}

static void add_edges(kn_ctx *ctx, edges *e, const kn_patch *face, double same)
{
    if (e->n + 4 > e->room) {
        e->room = 2 * e->room + 64;
        e->list = realloc(e->list, e->room * sizeof *e->list);
        assert_non_null(e->list);
    }
    for (int k = 0; k < 4; k++) {
        edge *to = &e->list[e->n];
        *to = (edge){.face = e->nfaces};
        double length = 0;
        for (int i = 0; i < PLACES; i++) {
            double x[2];
            x[k / 2] = k % 2, x[1 - k / 2] = (double)i / (PLACES - 1);
            assert_int_equal(kn_bezier_eval(ctx, to->at[i], &face->bezier, x), KN_OK);
            length = fmax(length, apart(to->at[i], to->at[0]));
        }
        to->key = 0.536 * to->at[2][0] + 0.312 * to->at[2][1] + 0.152 * to->at[2][2];
        if (length > same) e->n++; // else it is a point
    }
    e->nfaces++;
}

static int compare_edges(const void *a, const void *b)
{
    const edge *x = a, *y = b;
    return (x->key > y->key) - (x->key < y->key);
}

static size_t root(const size_t *parent, size_t i)
{
    while (parent[i] != i) i = parent[i];
    return i;
}

static bool same_edge(const edge *a, const edge *b, double same)
{
    for (int way = 0; way < 2; way++) {
        bool yes = true;
        for (int i = 0; i < PLACES && yes; i++) yes = apart(a->at[i], b->at[way ? PLACES - 1 - i : i]) <= same;
        if (yes) return true;
    }
    return false;
}

// *closed: bodies each of whose edges two faces have; *open: the others.
static void count_bodies(edges *e, double same, size_t *closed, size_t *open)
{
    e->parent = malloc((e->nfaces + 1) * sizeof *e->parent);
    bool *torn = calloc(e->nfaces + 1, sizeof *torn);
    assert_true(e->parent && torn);
    for (size_t i = 0; i < e->nfaces; i++) e->parent[i] = i;
    qsort(e->list, e->n, sizeof *e->list, compare_edges);
    for (size_t i = 0; i < e->n; i++)
        for (size_t j = i + 1; j < e->n && e->list[j].key - e->list[i].key <= same; j++) {
            if (!same_edge(&e->list[i], &e->list[j], same)) continue;
            e->list[i].crowded = e->list[i].crowded || e->list[i].mated;
            e->list[j].crowded = e->list[j].crowded || e->list[j].mated;
            e->list[i].mated = e->list[j].mated = true;
            e->parent[root(e->parent, e->list[i].face)] = root(e->parent, e->list[j].face);
        }
    for (size_t i = 0; i < e->n; i++)
        if (!e->list[i].mated || e->list[i].crowded) torn[root(e->parent, e->list[i].face)] = true;
    *closed = *open = 0;
    for (size_t i = 0; i < e->nfaces; i++)
        if (e->parent[i] == i) ++*(torn[i] ? open : closed);
    free(e->parent), free(torn);
}

static size_t count_of(const char *text, const char *what)
{
    size_t n = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what)) n++;
    return n;
}

typedef struct base {
    const char *name;
    void (*make)(kn_ctx *ctx, kn_spline *out); // NULL: patches of the teapot
    int count[2], patches[4], n;
} base;

static void make_bent(kn_ctx *ctx, kn_spline *out)
{
    scene_bicubic(ctx, out, 0.2);
}

// Its body goes round in two rings of four patches: halves of both.
static const base BASES[] = {
    {"bicubic", make_bent, {3, 2}, {0}, 1},      {"part of a torus", scene_torus, {3, 2}, {0}, 1},
    {"cylinder", make_cylinder, {4, 2}, {0}, 1}, {"torus", make_torus, {4, 4}, {0}, 1},
    {"teapot", NULL, {2, 2}, {4, 5, 8, 9}, 4},
};

static kn_job *make_job(kn_ctx *ctx, const base *b, const char *name)
{
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_spline s[4] = {{0}};
    kn_job_options o = kn_job_defaults();
    o.count[0] = b->count[0], o.count[1] = b->count[1];
    o.max_degree = KN_MAX_DEGREE, o.height = 0.05, o.normal_tol = 1e-3; // which keeps degrees low
    for (int i = 0; i < b->n; i++) {
        if (b->make) b->make(ctx, &s[i]);
        if (!b->make && !make_teapot(ctx, &s[i], b->patches[i])) fail_msg("data/teapot.bpt is not there");
    }
    assert_int_equal(kn_builtin_tile(ctx, &tile, name), KN_OK);
    if (kn_job_create(ctx, &job, s, b->n, &tile, &o) != KN_OK) fail_msg("%s: %s", name, kn_ctx_message(ctx));
    kn_tile_clear(ctx, &tile);
    for (int i = 0; i < b->n; i++) kn_spline_clear(ctx, &s[i]);
    return job;
}

static void add_faces(kn_ctx *ctx, edges *e, const scene_result *r, double same)
{
    for (size_t i = 0; i < r->count; i++) {
        const kn_patch *p = &r->patches[i];
        int nvars = kn_patch_nvars(p);
        if (nvars == 2) add_edges(ctx, e, p, same);
        for (int f = 0; f < 6 && nvars == 3; f++) {
            kn_patch face = {0};
            if (p->hidden >> f & 1) continue;
            assert_int_equal(kn_patch_face(ctx, &face, p, f), KN_OK);
            add_edges(ctx, e, &face, same);
            kn_bezier_clear(ctx, &face.bezier);
        }
    }
}

// What the file closes is what distance says is closed; answers how many bodies that are, and *open how many are not.
static size_t check(kn_ctx *ctx, size_t *open, const base *b, const char *name)
{
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "closed.step");
    kn_job *job = make_job(ctx, b, name);
    kn_sink sink = {0};
    scene_result r = {0};
    edges e = {0};
    size_t closed;
    assert_int_equal(kn_step_sink(ctx, &sink, path, NULL), KN_OK);
    if (kn_job_run(ctx, job, &sink, 1) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_sink_close(ctx, &sink);
    char *text = test_read_file(path, NULL);
    assert_non_null(text);
    scene_run(ctx, job, &r);
    add_faces(ctx, &e, &r, 1e-6);
    count_bodies(&e, 1e-6, &closed, open);
    size_t solids = count_of(text, "=MANIFOLD_SOLID_BREP("), shells = count_of(text, "OPEN_SHELL(");
    if (solids != closed || shells != *open)
        fail_msg("%s over %s: %zu bodies of %zu are closed, and %zu of %zu open", name, b->name, solids, closed,
                 shells, *open);
    free(e.list), free(text);
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    return closed;
}

// Covering tiles over what is closed both ways are one body; of chain each ring and each link is one, a bird is alone.
static void check_one(kn_ctx *ctx, const base *b, const char *name)
{
    static const char *const covering[] = {"scale",    "thorn",   "knurl", "bump",
                                           "straight", "hexagon", "studs", "brick"};
    size_t open, cells = (size_t)(b->count[0] * b->count[1] * b->n), closed = check(ctx, &open, b, name);
    bool torus = b->make == make_torus;
    for (size_t k = 0; k < sizeof covering / sizeof *covering; k++)
        if (strcmp(name, covering[k]) == 0) assert_true(closed == torus && open == !torus);
    if (strcmp(name, "chain") == 0) assert_true(torus ? closed == 3 * cells && open == 0 : closed > cells);
    if (strcmp(name, "bird") == 0) assert_true(closed == cells && open == 0);
    if (strcmp(name, "cross") == 0) assert_true(closed == 1 && open == 0);
}

// A few on each base; all of them with KN_TEST_SCALE=10 and more.
static void bodies_close(void **state)
{
    (void)state;
    static const char *const tiles[] = {"knurl", "straight", "cross", "studs", "hexagon", "brick", "bump",
                                        "scale", "thorn",    "chain", "bird",  "rope",    "knit",  "wicker1"};
    enum { NTILES = sizeof tiles / sizeof *tiles, CHEAP = 4 };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    bool all = test_scale(1) >= 10;
    for (size_t b = 0; b < sizeof BASES / sizeof *BASES; b++)
        for (size_t k = 0; k < NTILES; k++)
            if (all || k == b % CHEAP || k == 2 - 2 * (b % 2) || (b == 0 && k >= CHEAP && k % 3 == 0))
                check_one(ctx, &BASES[b], tiles[k]);
    test_ctx_end(ctx, &memory);
}

// ---- patches that meet where n has knots in cells ----

typedef struct meeting {
    const char *tile;
    void (*make)(kn_ctx *ctx, kn_spline *out); // the first surface; NULL: patches of the teapot
    int patches[4], n, count[2];
    bool equal, fields;
    double stagger; // of rows, whose tiles are lower towards open ends, too
    int most;       // the largest degree: what the sharpest row of cells needs, and not what there is room for
} meeting;

// The Bezier patch of the tile that a patch was made of.
static void part_of_tile(kn_ctx *ctx, kn_bezier *out, const kn_tile *tile, const kn_patch_id *id)
{
    int at = id->patch;
    for (int k = 0; k < tile->parts[id->part].nsplines; k++) {
        kn_bezier *pieces = NULL;
        size_t n = 0;
        assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, &tile->parts[id->part].splines[k]), KN_OK);
        if (at >= 0 && at < (int)n) assert_int_equal(kn_bezier_copy(ctx, out, &pieces[at]), KN_OK);
        at -= (int)n;
        for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
        kn_free(ctx, pieces);
    }
    assert_non_null(out->coef);
}

// A quarter of a cylinder, and a plane that goes on from it.
static void make_arc(kn_ctx *ctx, kn_spline *out)
{
    static const double u[6] = {0, 0, 0, 1, 1, 1}, v[4] = {0, 0, 1, 1};
    const double *const knots[2] = {u, v};
    const double w = sqrt(0.5), coef[24] = {1, 1, w, w, 0, 0, 0, 0, w, w, 1, 1, 0, 1, 0, w, 0, 1, 1, 1, w, w, 1, 1};
    assert_int_equal(kn_spline_init(ctx, out, 2, 4, true, (const int[2]){2, 1}, (const int[2]){3, 2}, knots, coef),
                     KN_OK);
}

static void make_tangent(kn_ctx *ctx, kn_spline *out)
{
    static const double line[4] = {0, 0, 1, 1}, coef[12] = {0, 0, -1, -1, 1, 1, 1, 1, 0, 1, 0, 1};
    const double *const knots[2] = {line, line};
    assert_int_equal(kn_spline_init(ctx, out, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 2}, knots, coef),
                     KN_OK);
}

// Of a base over [0,1]^2: a thickness that is bilinear, and an attraction.
static const double CORNERS[4] = {1, 1.25, 1.5, 1.75}, PULL[3] = {0.5, -1, 2};

static long double thick(const long double x[2])
{
    return 1 + 0.5L * x[0] + 0.25L * x[1];
}

static void make_fields(kn_ctx *ctx, kn_spline *thickness, kn_spline *attraction)
{
    static const double line[4] = {0, 0, 1, 1};
    const double *const knots[2] = {line, line};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    double pull[12];
    for (int k = 0; k < 12; k++) pull[k] = PULL[k / 4];
    assert_int_equal(kn_spline_init(ctx, thickness, 2, 1, false, degree, count, knots, CORNERS), KN_OK);
    assert_int_equal(kn_spline_init(ctx, attraction, 2, 3, false, degree, count, knots, pull), KN_OK);
}

// The largest distance of a patch from S + w N/|N|, or S + w h N/|N| + w^2 psi, along its edges and inside.
static double off_true(kn_ctx *ctx, const kn_patch *patch, const kn_job *job, const kn_tile *tile, const kn_spline *s,
                       double height, bool fields)
{
    enum { STEPS = 10 };
    kn_bezier d = {0};
    double most = 0;
    part_of_tile(ctx, &d, tile, &patch->id);
    for (int k = 0; k < (STEPS + 1) * (STEPS + 1); k++) {
        const double at[2] = {(double)(k / (STEPS + 1)) / STEPS, (double)(k % (STEPS + 1)) / STEPS};
        double uvw[3], got[3], p[3];
        long double x[2], point[3], su[3], sv[3], n[3];
        assert_int_equal(kn_bezier_eval(ctx, uvw, &d, at), KN_OK);
        assert_int_equal(kn_bezier_eval(ctx, got, &patch->bezier, at), KN_OK);
        for (int v = 0; v < 2; v++) {
            const double *line = kn_job_lines(job, patch->id.surface, v) + patch->id.cell[v];
            x[v] = line[0] + (long double)uvw[v] * (line[1] - line[0]);
        }
        direct_surface(point, su, sv, n, s, x[0], x[1]);
        long double length = sqrtl(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (length < 1e-9L) continue; // a pole
        double w = height * uvw[2], h = fields ? (double)thick(x) : 1.0;
        for (int c = 0; c < 3; c++)
            p[c] = (double)(point[c] + w * h * n[c] / length) + (fields ? w * w * PULL[c] : 0.0);
        most = fmax(most, apart(p, got));
    }
    kn_bezier_clear(ctx, &d);
    return most;
}

// The file has the bodies that distance says, by the bits of their edges; with stand-ins they fall apart.
static void check_bits(kn_ctx *ctx, const meeting *m, const char *path, const scene_result *r)
{
    edges e = {0};
    size_t closed, torn;
    char *text = test_read_file(path, NULL);
    assert_non_null(text);
    size_t open = count_of(text, "OPEN_SHELL("), solids = count_of(text, "=MANIFOLD_SOLID_BREP(");
    add_faces(ctx, &e, r, 1e-6);
    count_bodies(&e, 1e-6, &closed, &torn);
    if (m->equal && (open != torn || solids != closed))
        fail_msg("%s: %zu closed, %zu open, and in the file %zu and %zu", m->tile, closed, torn, solids, open);
    assert_true(m->equal || open > torn);
    free(e.list), free(text);
}

static void check_meeting(kn_ctx *ctx, const meeting *m)
{
    const double height = 0.05;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "meeting.step");
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_sink sink = {0};
    kn_spline s[4] = {{0}}, thickness = {0}, attraction = {0};
    scene_result r = {0};
    kn_job_options o = kn_job_defaults();
    o.count[0] = m->count[0], o.count[1] = m->count[1], o.height = height, o.equal_edges = m->equal;
    for (int i = 0; i < m->n; i++) {
        if (m->make) (i == 0 ? m->make : make_tangent)(ctx, &s[i]);
        if (!m->make && !make_teapot(ctx, &s[i], m->patches[i])) fail_msg("data/teapot.bpt is not there");
    }
    o.placement.stagger[0] = m->stagger, o.taper = m->stagger;
    make_fields(ctx, &thickness, &attraction);
    if (m->fields) o.thickness = &thickness, o.attraction = &attraction, o.max_degree = 32; // n needs room beside h
    assert_int_equal(kn_builtin_tile(ctx, &tile, m->tile), KN_OK);
    if (kn_job_create(ctx, &job, s, m->n, &tile, &o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    assert_int_equal(kn_step_sink(ctx, &sink, path, NULL), KN_OK);
    if (kn_job_run(ctx, job, &sink, 1) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    kn_sink_close(ctx, &sink);
    scene_run(ctx, job, &r);
    check_bits(ctx, m, path, &r);
    double bound = kn_job_describe(job).stand_in_error;
    assert_true(bound > 0 && bound <= 16e-6 * height * (m->fields ? CORNERS[3] : 1));
    for (size_t i = 0; i < r.count && m->equal; i++) {
        const kn_patch_id *id = &r.patches[i].id;
        assert_false(r.patches[i].exact || r.patches[i].bezier.rational);
        for (int v = 0; v < 2; v++) assert_true(r.patches[i].bezier.degree[v] <= m->most);
        if (m->stagger != 0) continue; // D is not the tile's
        double off = off_true(ctx, &r.patches[i], job, &tile, &s[id->surface], height, m->fields);
        if (!(off <= bound)) fail_msg("%s, patch %zu: off by %g, and %g is stated", m->tile, i, off, bound);
    }
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &thickness), kn_spline_clear(ctx, &attraction);
    for (int i = 0; i < m->n; i++) kn_spline_clear(ctx, &s[i]);
}

static void patches_meet(void **state)
{
    (void)state;
    static const meeting cases[] = {
        {"thorn", NULL, {12, 13, 14, 15}, 4, {1, 1}, true, false, 0, 14},
        {"thorn", NULL, {12, 13}, 2, {1, 1}, false, false, 0, 25},
        {"bump", NULL, {16, 17}, 2, {1, 1}, true, false, 0, 15},
        {"scale", NULL, {12, 13}, 2, {2, 2}, true, false, 0, 12},
        {"knurl", NULL, {0, 1, 2, 3}, 4, {2, 2}, true, false, 0, 13},
        // rational surfaces: a closed one with a seam, one with poles, and one without either
        {"wicker1", make_cylinder, {0}, 1, {4, 1}, true, false, 0, 8},
        {"bump", make_sphere, {0}, 1, {4, 2}, true, false, 0, 12},
        {"thorn", scene_torus, {0}, 1, {1, 1}, true, false, 0, 12},
        {"thorn", scene_torus, {0}, 1, {1, 1}, true, true, 0, 12},
        {"scale", make_arc, {0}, 2, {1, 1}, true, false, 0, 10}, // a rational surface and a polynomial one
        {"thorn", NULL, {12}, 1, {1, 1}, true, true, 0, 14},
        {"scale", make_cylinder, {0}, 1, {4, 2}, true, false, 0.5, 10}, // over the seam, in cells that are not alike
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) check_meeting(ctx, &cases[i]);
    test_ctx_end(ctx, &memory);
}

static kn_status meet_and_run(kn_ctx *ctx, void *user)
{
    kn_tile tile = {0};
    kn_job *job = NULL;
    kn_spline s = {0};
    kn_sink sink = {0};
    kn_job_options o = kn_job_defaults();
    o.count[0] = o.count[1] = 1, o.height = 0.05, o.equal_edges = true, o.normal_tol = 1e-4;
    kn_status status = kn_spline_copy(ctx, &s, user);
    if (status == KN_OK) status = kn_builtin_tile(ctx, &tile, "bump");
    if (status == KN_OK) status = kn_job_create(ctx, &job, &s, 1, &tile, &o);
    if (status == KN_OK) status = kn_job_run(ctx, job, &sink, 0);
    assert_true(status != KN_OK || kn_job_describe(job).exact_patches == 0);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s);
    return status;
}

// All places would take minutes: there are thousands. Those of the plan and the run come last.
static void patches_meet_without_memory(void **state)
{
    enum { FAILURES = 32 };
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    scene_torus(ctx, &s);
    size_t calls = memory.calls;
    assert_int_equal(meet_and_run(ctx, &s), KN_OK);
    calls = memory.calls - calls;
    for (size_t k = 0; k < FAILURES; k++) {
        test_memory small = TEST_MEMORY_INIT;
        kn_ctx *poor = test_ctx(&small, 1);
        small.fail_at = small.calls + calls - 1 - k * k * (calls - 1) / (FAILURES * FAILURES);
        assert_int_equal(meet_and_run(poor, &s), KN_ENOMEM);
        assert_int_equal(kn_ctx_error(poor), KN_ENOMEM);
        assert_true(small.failed);
        test_ctx_end(poor, &small);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(bodies_close), cmocka_unit_test(patches_meet),
                                       cmocka_unit_test(patches_meet_without_memory)};
    return cmocka_run_group_tests_name("job/closed", tests, NULL, NULL);
}
