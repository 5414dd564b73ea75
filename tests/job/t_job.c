// SPDX-License-Identifier: Apache-2.0
// Jobs: what they compose against direct evaluation in long double, and what they promise about it.
#include "tests/support/support.h"

#include "tests/support/scene.h"

#include <knurl/io.h>
#include <knurl/knurl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- direct evaluation ----

// Homogeneous value and first derivatives of a piece at x, by the definition of Bernstein polynomials; of a volume on
// its face where the first variable is 0.
static void eval_piece(long double value[3][4], const kn_bezier *b, const long double x[2])
{
    long double basis[2][2][KN_MAX_DEGREE + 1]; // [variable][derivative]
    const int *degree = b->degree + (b->nvars == 3);
    for (int d = 0; d < 2; d++) {
        int p = degree[d];
        long double c = 1;
        for (int i = 0; i <= p; c = c * (p - i) / (i + 1), i++) {
            basis[d][0][i] = c * powl(x[d], i) * powl(1 - x[d], p - i);
            basis[d][1][i] = c * ((i > 0 ? i * powl(x[d], i - 1) * powl(1 - x[d], p - i) : 0) -
                                  (i < p ? (p - i) * powl(x[d], i) * powl(1 - x[d], p - i - 1) : 0));
        }
    }
    size_t n = kn_bezier_count(b);
    for (int k = 0; k < 3; k++)
        for (int c = 0; c < b->ncomp; c++) {
            value[k][c] = 0;
            for (int i = 0; i <= degree[0]; i++)
                for (int j = 0; j <= degree[1]; j++)
                    value[k][c] += basis[0][k == 1][i] * basis[1][k == 2][j] *
                                   b->coef[(size_t)c * n + (size_t)(i * (degree[1] + 1) + j)];
        }
}

// A base split into pieces.
typedef struct base {
    kn_bezier *pieces;
    size_t npieces;
    double breaks[2][16];
    int nbreaks[2];
} base;

static base base_of(kn_ctx *ctx, const kn_spline *s)
{
    base b = {0};
    assert_int_equal(kn_spline_to_bezier(ctx, &b.pieces, &b.npieces, s), KN_OK);
    for (int d = 0; d < 2; d++)
        for (int i = 0; i < s->count[d] + s->degree[d] + 1; i++)
            if (i == 0 || s->knots[d][i] != s->knots[d][i - 1]) b.breaks[d][b.nbreaks[d]++] = s->knots[d][i];
    return b;
}

static void base_clear(kn_ctx *ctx, base *b)
{
    for (size_t i = 0; i < b->npieces; i++) kn_bezier_clear(ctx, &b->pieces[i]);
    kn_free(ctx, b->pieces);
}

// S and the unit normal at parameters; beyond the domain the end pieces are extended.
static void eval_base(long double s[3], long double n[3], const base *b, const long double at[2])
{
    int index[2];
    long double x[2], v[3][4];
    for (int d = 0; d < 2; d++) {
        int i = 0;
        while (i < b->nbreaks[d] - 2 && at[d] >= b->breaks[d][i + 1]) i++;
        index[d] = i;
        x[d] = (at[d] - b->breaks[d][i]) / ((long double)b->breaks[d][i + 1] - b->breaks[d][i]);
    }
    const kn_bezier *piece = &b->pieces[index[0] * (b->nbreaks[1] - 1) + index[1]];
    eval_piece(v, piece, x);
    long double t[2][3];
    for (int c = 0; c < 3; c++) {
        long double w = piece->rational ? v[0][3] : 1;
        s[c] = v[0][c] / w;
        for (int k = 0; k < 2; k++) t[k][c] = (v[k + 1][c] - (piece->rational ? v[k + 1][3] : 0) * s[c]) / w;
    }
    long double length = 0;
    for (int c = 0; c < 3; c++) {
        int e = (c + 1) % 3, f = (c + 2) % 3;
        n[c] = t[0][e] * t[1][f] - t[0][f] * t[1][e];
        length += n[c] * n[c];
    }
    for (int c = 0; c < 3; c++) n[c] /= sqrtl(length);
}

// Every `stride`-th patch of a job at random (r, t) against S + w n: within the certificate times |w|, for n, and
// 1e-12 of the size of the coordinates, for rounding.
static void check_against_direct(kn_ctx *ctx, const kn_job *job, const kn_spline *surfaces, const scene_result *r,
                                 test_rng *rng, size_t stride)
{
    kn_job_report report = kn_job_describe(job);
    assert_true(report.normal.certified);
    for (size_t i = 0; i < r->count; i += stride) {
        const kn_patch *p = &r->patches[i];
        kn_bezier d = {0};
        kn_patch_place place;
        assert_int_equal(kn_job_source(ctx, &d, &place, job, &p->id), KN_OK);
        base b = base_of(ctx, &surfaces[place.surface]);
        for (int run = 0; run < 3; run++) {
            long double x[2] = {test_uniform(rng, 0.02, 0.98), test_uniform(rng, 0.02, 0.98)};
            long double uvw[3][4], got[3][4], at[2], s[3], n[3];
            eval_piece(uvw, &d, x);
            eval_piece(got, &p->bezier, x);
            for (int v = 0; v < 2; v++) at[v] = scene_parameter(job, place.surface, v, place.cell[v] + uvw[0][v]);
            eval_base(s, n, &b, at);
            long double error = 0, size = 0, w = uvw[0][2];
            for (int c = 0; c < 3; c++) {
                long double t = got[0][c] / (p->bezier.rational ? got[0][3] : 1), want = s[c] + w * n[c];
                error += (t - want) * (t - want);
                size += want * want;
            }
            long double bound = fabsl(w) * (report.normal.length_error + report.normal.angle_error) +
                                1e-12L * (1 + sqrtl(size));
            assert_true(sqrtl(error) <= bound);
        }
        kn_bezier_clear(ctx, &d);
        base_clear(ctx, &b);
    }
}

// Of a surface, or of the faces of a volume that are to be seen.
static size_t shown_triangles(const kn_patch *p)
{
    size_t n[3] = {(size_t)p->segments[0], (size_t)p->segments[1], (size_t)p->segments[2]}, sum = 0;
    if (p->bezier.nvars == 2) return 2 * n[0] * n[1];
    for (int face = 0; face < 6 && p->bezier.nvars == 3; face++)
        if (!(p->hidden & 1 << face)) sum += 2 * n[(face / 2 + 1) % 3] * n[(face / 2 + 2) % 3];
    return sum;
}

// The report says what the sink sees.
static void check_report(const kn_job *job, const scene_result *r)
{
    kn_job_report report = kn_job_describe(job);
    size_t points = 0, exact = 0, triangles = 0;
    int degree[2] = {0, 0};
    for (size_t i = 0; i < r->count; i++) {
        const kn_patch *p = &r->patches[i];
        points += kn_bezier_count(&p->bezier);
        exact += p->exact;
        triangles += shown_triangles(p);
        for (int d = 0; d < 2; d++) degree[d] = p->bezier.degree[d] > degree[d] ? p->bezier.degree[d] : degree[d];
        assert_int_equal(p->reversed, report.height < 0);
        assert_true(p->segments[0] >= 1 && p->segments[1] >= 1);
    }
    assert_int_equal(report.patches, r->count);
    assert_int_equal(report.exact_patches, exact);
    assert_int_equal(report.control_points, points);
    assert_int_equal(report.triangles, triangles);
    assert_int_equal(report.degree[0], degree[0]);
    assert_int_equal(report.degree[1], degree[1]);
    assert_true((report.stand_in_error == 0) == (exact == r->count));
}

static void try_scene(const kn_job_options *o, void (*make_base)(kn_ctx *, kn_spline *),
                      void (*make_tile)(kn_ctx *, kn_tile *))
{
    test_rng rng = test_random(1);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r;
    make_base(ctx, &s);
    make_tile(ctx, &tile);
    if (kn_job_create(ctx, &job, &s, 1, &tile, o) != KN_OK) fail_msg("%s", kn_ctx_message(ctx));
    scene_run(ctx, job, &r);
    assert_int_equal(kn_job_describe(job).nsurfaces, 1);
    check_report(job, &r);
    check_against_direct(ctx, job, &s, &r, &rng, 1);
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void bent_bicubic(kn_ctx *ctx, kn_spline *out)
{
    scene_bicubic(ctx, out, 0.15);
}

static void matches_direct_evaluation(void **state)
{
    (void)state;
    kn_job_options o = {.count = {3, 2}, .height = 0.2, .normal_tol = 1e-5};
    try_scene(&o, bent_bicubic, scene_dome);
    try_scene(&o, bent_bicubic, scene_strip);
    try_scene(&o, bent_bicubic, scene_diamond);
    o.quarter_turns = 1, o.height = -0.1, o.offset = 0.3;
    try_scene(&o, bent_bicubic, scene_strip);
    o.symbolic = true;
    try_scene(&o, bent_bicubic, scene_dome);
}

static void matches_on_rational_bases(void **state)
{
    (void)state;
    kn_job_options o = {.count = {2, 2}, .height = 0.2, .normal_tol = 1e-4, .max_degree = 56};
    try_scene(&o, scene_torus, scene_dome);
    try_scene(&o, scene_torus, scene_diamond);
    o = (kn_job_options){.count = {8, 2}, .height = 0.2, .normal_tol = 1e-4, .max_degree = 56};
    try_scene(&o, scene_cylinder, scene_strip); // wraps over the seam
    o.quarter_turns = 1;
    try_scene(&o, scene_cylinder, scene_strip);
}

// N of a bicubic has degrees 5, 5 and m three more at least: a tile of degree 1 composes to 17.
static void exact_directions(void **state)
{
    (void)state;
    kn_job_options o = {
        .count = {3, 2}, .height = 0.2, .normal_tol = 1e-4, .max_degree = 24, .normal = KN_NORMAL_EXACT_DIRECTION};
    try_scene(&o, bent_bicubic, scene_diamond);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s;
    kn_tile tile = {0};
    bent_bicubic(ctx, &s);
    scene_diamond(ctx, &tile);
    for (o.max_degree = 15; o.max_degree <= 17; o.max_degree += 2) {
        kn_job *job = NULL;
        kn_status status = kn_job_create(ctx, &job, &s, 1, &tile, &o);
        assert_int_equal(status, o.max_degree < 17 ? KN_EDOMAIN : KN_OK);
        if (status != KN_OK) assert_non_null(strstr(kn_ctx_message(ctx), "--max-degree 17 is needed"));
        kn_job_destroy(ctx, job);
    }
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static void matches_over_knots(void **state)
{
    (void)state;
    kn_job_options o = {.count = {5, 4}, .height = 0.2, .normal_tol = 1e-4};
    try_scene(&o, scene_spline, scene_dome);
    try_scene(&o, scene_spline, scene_strip);
    o.quarter_turns = 3;
    try_scene(&o, scene_spline, scene_strip);
}

// ---- lines and counts ----

static void lines_contain_knots(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_spline(ctx, &s); // u: 0 1 3 4, v: -1 0.5 2
    scene_dome(ctx, &tile);
    kn_job_options o = {.count = {6, 2}, .height = 0.1, .normal_tol = 1e-2};
    assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, &o), KN_OK);
    const double u[7] = {0, 0.5, 1, 1 + 2.0 / 3, 1 + 4.0 / 3, 3, 4}, *line = kn_job_lines(job, 0, 0);
    // shares 1.5, 3, 1.5: the first of the equal remainders gets what is left
    for (int i = 0; i < 7; i++) assert_true(fabs(line[i] - u[i]) <= 1e-15 * 4);
    line = kn_job_lines(job, 0, 1);
    assert_true(line[0] == -1 && line[1] == 0.5 && line[2] == 2);
    assert_null(kn_job_lines(job, 1, 0));
    assert_null(kn_job_lines(job, 0, 2));
    assert_null(kn_job_shell(job, 1));
    kn_job_destroy(ctx, job);

    o.count[0] = 2;
    assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, &o), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "at least 3"));
    kn_tile_clear(ctx, &tile), kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

static bool shared(const kn_spline *a, int ea, const kn_spline *b, int eb)
{
    bool forward = true, backward = true;
    for (int i = 0; i < 4; i++)
        for (int c = 0; c < 3; c++) {
            int at[3] = {0}, k[2] = {i, 3 - i};
            at[0] = ea < 2 ? 12 * ea + i : 4 * i + 3 * (ea - 2);
            for (int d = 0; d < 2; d++) at[1 + d] = eb < 2 ? 12 * eb + k[d] : 4 * k[d] + 3 * (eb - 2);
            forward = forward && fabs(a->coef[16 * c + at[0]] - b->coef[16 * c + at[1]]) < 1e-9;
            backward = backward && fabs(a->coef[16 * c + at[0]] - b->coef[16 * c + at[2]]) < 1e-9;
        }
    return forward || backward;
}

static bool collapsed(const kn_spline *s, int e)
{
    for (int i = 1; i < 4; i++)
        for (int c = 0; c < 3; c++) {
            int at = e < 2 ? 12 * e + i : 4 * i + 3 * (e - 2), first = e < 2 ? 12 * e : 3 * (e - 2);
            if (fabs(s->coef[16 * c + at] - s->coef[16 * c + first]) > 1e-9) return false;
        }
    return true;
}

// By size, the teapot's patches have as many cells on both sides of every common edge; thread counts do not matter.
static void teapot(void **state)
{
    (void)state;
    test_rng rng = test_random(2);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_model model = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r;
    assert_int_equal(kn_read_bpt(ctx, &model, "data/teapot.bpt"), KN_OK);
    scene_diamond(ctx, &tile);
    tile.parts[0].splines[0].coef[0] = 0.2; // and inside the cell
    static const double inside[8] = {0.1, 0.1, 0.9, 0.9, 0.1, 0.9, 0.1, 0.9};
    memcpy(tile.parts[0].splines[0].coef, inside, sizeof inside);
    kn_job_options o = {.size = {0.6, 0}, .normal_tol = 1e-2, .height = 0.05};
    if (kn_job_create(ctx, &job, model.splines, model.nsplines, &tile, &o) != KN_OK)
        fail_msg("%s", kn_ctx_message(ctx));
    int pairs = 0;
    for (int a = 0; a < model.nsplines; a++)
        for (int b = a + 1; b < model.nsplines; b++)
            for (int ea = 0; ea < 4; ea++)
                for (int eb = 0; eb < 4; eb++) {
                    if (collapsed(&model.splines[a], ea) || !shared(&model.splines[a], ea, &model.splines[b], eb))
                        continue;
                    int na[2], nb[2];
                    kn_shell_cells(kn_job_shell(job, a), na);
                    kn_shell_cells(kn_job_shell(job, b), nb);
                    assert_int_equal(na[ea < 2], nb[eb < 2]);
                    pairs++;
                }
    assert_true(pairs >= 32);
    kn_job_report report = kn_job_describe(job);
    assert_true(report.cell_size > 0.3 && report.cell_size < 1.2);
    scene_run(ctx, job, &r);
    check_report(job, &r);
    check_against_direct(ctx, job, model.splines, &r, &rng, 1 + r.count / 60);
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_model_clear(ctx, &model);
    test_ctx_end(ctx, &memory);
}

// ---- threads, methods, edges ----

static uint64_t hash(const scene_result *r)
{
    uint64_t h = 14695981039346656037u;
    for (size_t i = 0; i < r->count; i++) {
        const kn_patch *p = &r->patches[i];
        const unsigned char *bytes = (const unsigned char *)p->bezier.coef;
        size_t n = (size_t)p->bezier.ncomp * kn_bezier_count(&p->bezier) * sizeof(double);
        for (size_t k = 0; k < n; k++) h = (h ^ bytes[k]) * 1099511628211u;
        const int id[] = {p->id.surface, p->id.cell[0], p->id.cell[1], p->id.part, p->id.patch, p->id.piece};
        for (size_t k = 0; k < 6; k++) h = (h ^ (uint64_t)id[k]) * 1099511628211u;
    }
    return h;
}

static void same_for_any_threads(void **state)
{
    (void)state;
    uint64_t first = 0;
    for (int threads = 1; threads <= 4; threads++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, threads);
        kn_spline s[2] = {{0}, {0}};
        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result r;
        scene_bicubic(ctx, &s[0], 0.15), scene_bicubic(ctx, &s[1], -0.1);
        scene_strip(ctx, &tile);
        kn_job_options o = {.count = {9, 8}, .height = 0.1, .normal_tol = 1e-4};
        assert_int_equal(kn_job_create(ctx, &job, s, 2, &tile, &o), KN_OK);
        scene_run(ctx, job, &r);
        if (threads == 1) first = hash(&r);
        assert_true(hash(&r) == first);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
        kn_spline_clear(ctx, &s[0]), kn_spline_clear(ctx, &s[1]);
        test_ctx_end(ctx, &memory);
    }
}

// Sums of |products| are below (1 + |w|) 10 here, with fewer than 1000 roundings on either way.
static void matrix_equals_symbolic(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    void (*const tiles[])(kn_ctx *, kn_tile *) = {scene_dome, scene_strip};
    for (int t = 0; t < 2; t++) {
        kn_spline s = {0};
        kn_tile tile = {0};
        scene_result r[2];
        scene_spline(ctx, &s);
        tiles[t](ctx, &tile);
        for (int k = 0; k < 2; k++) {
            kn_job *job = NULL;
            kn_job_options o = {.count = {5, 4}, .height = 0.2, .normal_tol = 1e-4, .symbolic = k == 1};
            assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, &o), KN_OK);
            scene_run(ctx, job, &r[k]);
            kn_job_destroy(ctx, job);
        }
        assert_int_equal(r[0].count, r[1].count);
        for (size_t i = 0; i < r[0].count; i++) { // symbolic: in the tile's degrees times 3 + 3 + ..
            const kn_bezier *a = &r[0].patches[i].bezier, *b = &r[1].patches[i].bezier;
            kn_bezier up = {0};
            for (int v = 0; v < 2; v++) assert_true(a->degree[v] < b->degree[v]);
            assert_int_equal(kn_bezier_elevate(ctx, &up, a, b->degree), KN_OK);
            assert_true(test_max_difference(up.coef, b->coef, 3 * kn_bezier_count(b)) <= 1000 * 0x1p-53 * 12);
            kn_bezier_clear(ctx, &up);
        }
        for (int k = 0; k < 2; k++) scene_result_clear(&r[k]);
        kn_spline_clear(ctx, &s), kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

// Edge e of a patch as 3 (n + 1) numbers, the lexicographically first of its two directions. Returns n + 1.
static size_t edge_of(double *out, const kn_bezier *b, int e)
{
    size_t row = (size_t)b->degree[1] + 1, count = kn_bezier_count(b);
    size_t n = (size_t)b->degree[e < 2] + 1, step = e < 2 ? 1 : row;
    size_t start = e == 1 ? count - row : e == 3 ? row - 1 : 0;
    double other[3 * (KN_MAX_DEGREE + 1)];
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++) {
            out[3 * i + c] = b->coef[c * count + start + i * step];
            other[3 * (n - 1 - i) + c] = out[3 * i + c];
        }
    for (size_t i = 0; i < 3 * n; i++)
        if (out[i] != other[i]) {
            if (other[i] < out[i]) memcpy(out, other, 3 * n * sizeof *out);
            break;
        }
    return n;
}

// A covering tile on exact cells: every edge inside the domain belongs to two patches, bit for bit, whichever cells,
// patches, sides and directions they have.
static void exact_cells_share_edges(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline s = {0};
    kn_tile tile = {0};
    kn_job *job = NULL;
    scene_result r;
    scene_bicubic(ctx, &s, 0.01);
    scene_dome(ctx, &tile);
    kn_job_options o = {.count = {3, 4}, .height = 0.2, .normal_tol = 1e-3};
    assert_int_equal(kn_job_create(ctx, &job, &s, 1, &tile, &o), KN_OK);
    assert_int_equal(kn_job_describe(job).exact_patches, 3 * 4 * 4);
    scene_run(ctx, job, &r);
    assert_int_equal(r.count, 48);
    int alone = 0;
    for (size_t i = 0; i < r.count; i++)
        for (int e = 0; e < 4; e++) {
            double a[3 * (KN_MAX_DEGREE + 1)], b[3 * (KN_MAX_DEGREE + 1)];
            size_t n = edge_of(a, &r.patches[i].bezier, e);
            int same = 0;
            for (size_t j = 0; j < r.count; j++)
                for (int f = 0; f < 4; f++) {
                    size_t m = edge_of(b, &r.patches[j].bezier, f);
                    same += m == n && memcmp(a, b, 3 * n * sizeof *a) == 0;
                }
            assert_in_range(same, 1, 2);
            alone += same == 1;
        }
    assert_int_equal(alone, 2 * 2 * (3 + 4)); // the border of the domain: two patches for each cell
    scene_result_clear(&r);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &tile);
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

// Built-in tiles over a bent patch.
// Two flat squares, [0,1]^2 and [1,2] x [0,1] of the plane z = 0, the second with its parameters turned by `turns`
// quarter turns: its edge at x = 1 is each of its four edges in turn.
static void two_squares(kn_ctx *ctx, kn_spline out[2], int turns)
{
    static const double knots[] = {0, 0, 1, 1};
    const double *both[2] = {knots, knots};
    const int degree[2] = {1, 1}, count[2] = {2, 2};
    for (int s = 0; s < 2; s++) {
        double coef[12] = {0};
        for (int i = 0; i < 2; i++)
            for (int j = 0; j < 2; j++) {
                double u = i, v = j;
                for (int k = 0; k < (s == 1 ? turns : 0); k++) {
                    double old = u;
                    u = 1 - v, v = old;
                }
                coef[2 * i + j] = s + u, coef[4 + 2 * i + j] = v;
            }
        assert_int_equal(kn_spline_init(ctx, &out[s], 2, 3, false, degree, count, both, coef), KN_OK);
    }
}

// A job with all defaults: the tile's own proportions and a twentieth of the base's diagonal; the tile is copied, and
// turned as the options ask: a quarter turn carries the strip, which reaches over both ends of u, to the ends of v.
static void defaults_and_the_placed_tile(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_spline squares[2] = {{0}};
    kn_tile strip = {0};
    kn_job *job = NULL;
    two_squares(ctx, squares, 0);
    scene_strip(ctx, &strip);
    kn_job_options o = kn_job_defaults();
    o.quarter_turns = 1;
    assert_int_equal(kn_job_create(ctx, &job, squares, 2, &strip, &o), KN_OK);
    kn_job_report report = kn_job_describe(job);
    assert_int_equal(report.cells, 2 * 9 * 9); // the diagonal is sqrt(5), a square 20 / sqrt(5) = 8.94 cells wide
    assert_true(report.normal_tol == 1e-6);
    assert_int_equal(report.max_degree, 25);
    assert_true(report.height == strip.aspect * report.cell_size);

    const kn_tile *placed = kn_job_tile(job);
    double lo[3], hi[3];
    assert_true(placed != &strip && placed->parts != strip.parts);
    assert_int_equal(kn_spline_box(ctx, lo, hi, &placed->parts[0].splines[0]), KN_OK);
    assert_true(lo[0] == 0.25 && hi[0] == 0.75 && lo[1] == -0.25 && hi[1] == 1.25);
    kn_job_destroy(ctx, job);
    kn_tile_clear(ctx, &strip);
    for (int s = 0; s < 2; s++) kn_spline_clear(ctx, &squares[s]);
    test_ctx_end(ctx, &memory);
}

// The strip of scene_strip reaches a quarter of a cell over both ends of u. Over flat squares T(D) is D itself,
// scaled and moved, wherever the tile continues over the shared edge: every piece of square 0's cell lies where the
// strip over the plane does, however the other square is parametrized, and the piece beyond names the other square.
static void tiles_continue_on_the_neighbour(void **state)
{
    (void)state;
    for (int turns = 0; turns < 4; turns++) {
        test_memory memory = TEST_MEMORY_INIT;
        kn_ctx *ctx = test_ctx(&memory, 1);
        kn_spline squares[2] = {{0}};
        kn_tile strip = {0};
        kn_job *job = NULL;
        scene_result r = {0};
        two_squares(ctx, squares, turns);
        scene_strip(ctx, &strip);
        assert_int_equal(kn_job_create(ctx, &job, squares, 2, &strip,
                                       &(kn_job_options){.count = {2, 2}, .height = 0.125, .normal_tol = 1e-9}),
                         KN_OK);
        scene_run(ctx, job, &r);
        int beyond = 0;
        for (size_t i = 0; i < r.count; i++) {
            const kn_patch *p = &r.patches[i];
            kn_patch_place place;
            kn_bezier d = {0};
            assert_int_equal(kn_job_source(ctx, &d, &place, job, &p->id), KN_OK);
            kn_bezier_clear(ctx, &d);
            if (p->id.surface != 0 || p->id.cell[0] != 1) continue;
            beyond += place.surface == 1;
            double y0 = 0.5 * p->id.cell[1];
            size_t n = kn_bezier_count(&p->bezier);
            for (size_t k = 0; k < n; k++) { // cells are 1/2 wide, v of the strip is in [1/4, 3/4]
                double x = p->bezier.coef[k], y = p->bezier.coef[n + k];
                assert_true(x >= 0.5 - 0.125 - 1e-9 && x <= 1 + 0.125 + 1e-9);
                assert_true(y >= y0 + 0.125 - 1e-9 && y <= y0 + 0.375 + 1e-9);
                if (place.surface == 1) assert_true(x >= 1 - 1e-9);
            }
        }
        assert_int_equal(beyond, 2); // one in each of the two cells at the shared edge
        check_against_direct(ctx, job, squares, &r, &(test_rng){7}, 1);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &strip);
        for (int s = 0; s < 2; s++) kn_spline_clear(ctx, &squares[s]);
        test_ctx_end(ctx, &memory);
    }
}

static void builtin_tiles(void **state)
{
    (void)state;
    test_rng rng = test_random(4);
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    kn_spline s = {0};
    scene_bicubic(ctx, &s, 0.1);
    for (int i = 0; i < kn_builtin_tile_count(); i++) {
        kn_tile tile = {0};
        kn_job *job = NULL;
        scene_result r;
        assert_int_equal(kn_builtin_tile(ctx, &tile, kn_builtin_tile_name(i)), KN_OK);
        kn_job_options o = {.count = {2, 2}, .normal_tol = 1e-4};
        if (kn_job_create(ctx, &job, &s, 1, &tile, &o) != KN_OK) fail_msg("%s: %s", tile.name, kn_ctx_message(ctx));
        scene_run(ctx, job, &r);
        check_report(job, &r);
        check_against_direct(ctx, job, &s, &r, &rng, 1 + r.count / 40);
        scene_result_clear(&r);
        kn_job_destroy(ctx, job);
        kn_tile_clear(ctx, &tile);
    }
    kn_spline_clear(ctx, &s);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(matches_direct_evaluation),
                                       cmocka_unit_test(matches_on_rational_bases),
                                       cmocka_unit_test(exact_directions),
                                       cmocka_unit_test(matches_over_knots),
                                       cmocka_unit_test(lines_contain_knots),
                                       cmocka_unit_test(teapot),
                                       cmocka_unit_test(same_for_any_threads),
                                       cmocka_unit_test(matrix_equals_symbolic),
                                       cmocka_unit_test(exact_cells_share_edges),
                                       cmocka_unit_test(defaults_and_the_placed_tile),
                                       cmocka_unit_test(tiles_continue_on_the_neighbour),
                                       cmocka_unit_test(builtin_tiles)};
    return cmocka_run_group_tests_name("job/job", tests, NULL, NULL);
}
