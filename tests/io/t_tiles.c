// SPDX-License-Identifier: Apache-2.0
// The built-in tiles: that copies of the cell join without a gap, what is smooth stays smooth, what interlocks does;
// and tiles from files.
#include "tests/support/support.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <knurl/io.h>

enum { MAX_PATCHES = 128, MAX_EDGES = 4 * MAX_PATCHES };

typedef struct loaded {
    kn_tile tile;
    kn_bezier patch[MAX_PATCHES];
    int part[MAX_PATCHES];
    int n;
} loaded;

// The tile, with one of its parameters at its target; none: -1.
static void load_at(kn_ctx *ctx, loaded *l, const char *name, int parameter)
{
    memset(l, 0, sizeof *l);
    assert_int_equal(kn_builtin_tile(ctx, &l->tile, name), KN_OK);
    for (int p = 0; p < l->tile.nparts; p++)
        for (int s = 0; s < l->tile.parts[p].nsplines; s++) {
            const kn_tile_part *part = &l->tile.parts[p];
            const kn_spline *spline = &part->splines[s];
            if (parameter >= 0 && part->targets && part->targets[parameter * part->nsplines + s].coef)
                spline = &part->targets[parameter * part->nsplines + s];
            kn_bezier *pieces = NULL;
            size_t n = 0;
            assert_int_equal(kn_spline_to_bezier(ctx, &pieces, &n, spline), KN_OK);
            for (size_t i = 0; i < n; i++, l->n++) {
                assert_true(l->n < MAX_PATCHES);
                l->patch[l->n] = pieces[i];
                l->part[l->n] = p;
            }
            kn_free(ctx, pieces);
        }
}

static void load(kn_ctx *ctx, loaded *l, const char *name)
{
    load_at(ctx, l, name, -1);
}

static void unload(kn_ctx *ctx, loaded *l)
{
    for (int i = 0; i < l->n; i++) kn_bezier_clear(ctx, &l->patch[i]);
    kn_tile_clear(ctx, &l->tile);
}

// ---- edges ----

// An edge of a patch, run counterclockwise round its parameter square.
typedef struct edge {
    double p[3][3];
    int patch, side, n; // n control points; side 0: t = 0, 1: r = 1, 2: t = 1, 3: r = 0
    int mate;           // the edge that it is joined to
} edge;

static void parameters(double at[2], int side, double s)
{
    at[0] = side == 0 ? s : side == 1 ? 1.0 : side == 2 ? 1.0 - s : 0.0;
    at[1] = side == 0 ? 0.0 : side == 1 ? s : side == 2 ? 1.0 : 1.0 - s;
}

static edge edge_of(const kn_bezier *b, int patch, int side)
{
    edge e = {.patch = patch, .side = side, .n = b->degree[side % 2] + 1, .mate = -1};
    size_t count = kn_bezier_count(b), row = (size_t)b->degree[1] + 1;
    for (int k = 0; k < e.n; k++) {
        int last = e.n - 1;
        int i = side == 0 ? k : side == 1 ? b->degree[0] : side == 2 ? last - k : 0;
        int j = side == 0 ? 0 : side == 1 ? k : side == 2 ? b->degree[1] : last - k;
        for (size_t c = 0; c < 3; c++) e.p[k][c] = b->coef[c * count + (size_t)i * row + (size_t)j];
    }
    return e;
}

static bool collapsed(const edge *e)
{
    for (int k = 1; k < e->n; k++)
        for (int c = 0; c < 3; c++)
            if (e->p[k][c] != e->p[0][c]) return false;
    return true;
}

// b, moved by whole cells, is a run the other way (or the same way).
static bool same_edge(const edge *a, const edge *b, bool other_way)
{
    if (a->n != b->n) return false;
    double move[2] = {0.0, 0.0};
    for (int k = 0; k < a->n; k++) {
        const double *p = a->p[k], *q = b->p[other_way ? b->n - 1 - k : k];
        for (int c = 0; c < 2; c++) {
            if (k == 0) move[c] = p[c] - q[c];
            if (p[c] - q[c] != move[c] || fabs(move[c]) > 1.0 || move[c] != floor(move[c])) return false;
        }
        if (p[2] != q[2]) return false;
    }
    return true;
}

static bool on_the_base(const edge *e)
{
    bool on = true;
    for (int k = 0; k < e->n; k++) on = on && e->p[k][2] == 0.0;
    return on;
}

// Every edge that is not a point has exactly one mate, of the same part unless both are one sheet, which runs the
// other way; but what stands on the base may be open there.
static int join(edge *edges, const loaded *l, int *ncollapsed, int *nfree)
{
    int n = 0;
    *ncollapsed = *nfree = 0;
    for (int i = 0; i < l->n; i++)
        for (int side = 0; side < 4; side++) {
            edge e = edge_of(&l->patch[i], i, side);
            if (collapsed(&e))
                ++*ncollapsed;
            else
                edges[n++] = e;
        }
    for (int i = 0; i < n; i++) {
        int mates = 0;
        for (int j = 0; j < n; j++) {
            if (j == i) continue;
            assert_false(same_edge(&edges[i], &edges[j], false));
            if (!same_edge(&edges[i], &edges[j], true)) continue;
            edges[i].mate = j;
            mates++;
        }
        if (mates == 0 && !l->tile.covering && on_the_base(&edges[i])) {
            ++*nfree;
            continue;
        }
        if (mates != 1)
            print_error("%s: patch %d side %d has %d mates\n", l->tile.name, edges[i].patch, edges[i].side, mates);
        assert_int_equal(mates, 1);
        assert_true(l->tile.covering || l->part[edges[i].patch] == l->part[edges[edges[i].mate].patch]);
    }
    return n;
}

// ---- what each tile is meant to be ----

typedef struct expected {
    const char *name;
    bool covering;
    int parts, patches, degree, ncollapsed, nfree, components;
    double gap; // strands stay this far apart; 0: no strands
    bool (*smooth)(kn_ctx *ctx, const loaded *l, const edge *a, const edge *b); // NULL: not asked
} expected;

static bool always(kn_ctx *ctx, const loaded *l, const edge *a, const edge *b)
{
    (void)ctx, (void)l, (void)a, (void)b;
    return true;
}

// Scales: along the row lines inside the top of a scale, and where the top turns into the nose. There the mate of a
// patch's t = 1 is another's t = 0, and both face up; the folds at the root and under the nose are creases.
static bool tops(kn_ctx *ctx, const loaded *l, const edge *a, const edge *b)
{
    if (a->side % 2 == 1) return false; // ridges and valleys
    bool up = true;
    const edge *both[2] = {a, b};
    for (int k = 0; k < 2; k++) {
        double d[9], at[2];
        parameters(at, both[k]->side, 0.5);
        assert_int_equal(kn_bezier_derivatives(ctx, d, &l->patch[both[k]->patch], at, 1), KN_OK);
        up = up && d[3] * d[7] - d[4] * d[6] > 0.0 && d[7] > 0.0 && both[k]->p[0][2] > 0.0;
    }
    return up;
}

// The first of the library; those after them have tests of their own.
static const expected TILES[] = {
    {"chain", false, 2, 48, 2, 0, 0, 3, 0.03, always},   {"scale", true, 1, 16, 2, 0, 0, 1, 0, tops},
    {"thorn", true, 1, 16, 2, 4, 0, 1, 0, always},       {"knurl", true, 1, 13, 1, 4, 0, 1, 0, NULL},
    {"bump", true, 1, 9, 2, 0, 0, 1, 0, always},         {"fur", false, 1, 108, 2, 108, 108, 36, 0, always},
    {"wicker1", false, 2, 32, 2, 0, 0, 4, 0.01, always}, {"wicker2", false, 2, 56, 2, 0, 0, 8, 0.01, always},
    {"basket", false, 2, 48, 2, 0, 0, 4, 0.01, always},  {"knit", false, 1, 64, 2, 0, 0, 1, 0.01, always},
    {"rope", false, 1, 72, 2, 0, 0, 1, 0.01, always},    {"straight", true, 1, 3, 1, 0, 0, 1, 0, NULL},
    {"hexagon", true, 1, 48, 2, 0, 0, 1, 0, NULL},       {"studs", true, 2, 13, 1, 0, 0, 1, 0, NULL},
    {"brick", true, 2, 22, 2, 0, 0, 1, 0, NULL},         {"dimples", true, 1, 24, 2, 8, 0, 1, 0, always},
    {"rivet", true, 2, 24, 2, 8, 0, 1, 0, NULL},         {"bubblewrap", true, 1, 96, 2, 32, 0, 1, 0, always},
};
enum { NTILES = sizeof TILES / sizeof *TILES };

static void the_list_is_as_documented(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    assert_true(kn_builtin_tile_count() >= NTILES);
    assert_null(kn_builtin_tile_name(-1));
    assert_null(kn_builtin_tile_name(kn_builtin_tile_count()));
    for (int i = 0; i < NTILES; i++) {
        loaded l;
        assert_string_equal(kn_builtin_tile_name(i), TILES[i].name);
        load(ctx, &l, TILES[i].name);
        assert_int_equal(kn_tile_check(ctx, &l.tile), KN_OK);
        assert_string_equal(l.tile.name, TILES[i].name);
        assert_true(l.tile.covering == TILES[i].covering && l.tile.about[0] != '\0' && l.tile.aspect > 0.0);
        assert_int_equal(l.tile.nparts, TILES[i].parts);
        assert_int_equal(l.n, TILES[i].patches);
        for (int k = 0; k < l.n; k++)
            for (int d = 0; d < 2; d++) assert_true(l.patch[k].degree[d] <= TILES[i].degree);
        unload(ctx, &l);
    }
    test_ctx_end(ctx, &memory);
}

// Control points in the unit square: what a cell's tile becomes needs nothing from its neighbours. The surface itself
// takes all of the height, within a twentieth.
static void tiles_stay_in_their_cell(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        loaded l;
        load(ctx, &l, TILES[i].name);
        double top = 0.0, bottom = 1.0;
        for (int k = 0; k < l.n; k++) {
            size_t n = kn_bezier_count(&l.patch[k]);
            for (size_t j = 0; j < 3 * n; j++) {
                double x = l.patch[k].coef[j];
                assert_true(j < 2 * n ? x >= 0.0 && x <= 1.0 : x >= -1.25 && x <= 2.25);
            }
            for (int s = 0; s <= 8; s++)
                for (int t = 0; t <= 8; t++) {
                    double at[2] = {s / 8.0, t / 8.0}, p[3];
                    assert_int_equal(kn_bezier_eval(ctx, p, &l.patch[k], at), KN_OK);
                    top = fmax(top, p[2]), bottom = fmin(bottom, p[2]);
                }
        }
        if (!(bottom >= 0.0 && bottom <= 0.05 && top >= 0.95 && top <= 1.0))
            print_error("%s: from %g to %g\n", TILES[i].name, bottom, top);
        assert_true(bottom >= 0.0 && bottom <= 0.05 && top >= 0.95 && top <= 1.0);
        unload(ctx, &l);
    }
    test_ctx_end(ctx, &memory);
}

// ---- the infinite tiling is a closed surface ----

static int find(int *parent, int i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

static int components(const loaded *l, const edge *edges, int n)
{
    int parent[MAX_PATCHES], count = l->n;
    for (int i = 0; i < l->n; i++) parent[i] = i;
    for (int i = 0; i < n; i++) {
        if (edges[i].mate < 0) continue;
        int a = find(parent, edges[i].patch), b = find(parent, edges[edges[i].mate].patch);
        if (a != b) parent[a] = b, count--;
    }
    return count;
}

// Different corners of patches when opposite sides of the cell are one.
static int vertices_on_the_torus(const edge *edges, int n)
{
    double seen[MAX_EDGES][3];
    int count = 0;
    for (int i = 0; i < n; i++) {
        double p[3] = {edges[i].p[0][0], edges[i].p[0][1], edges[i].p[0][2]};
        for (int c = 0; c < 2; c++)
            if (p[c] == 1.0) p[c] = 0.0;
        int k = 0;
        while (k < count && (seen[k][0] != p[0] || seen[k][1] != p[1] || seen[k][2] != p[2])) k++;
        if (k == count) memcpy(seen[count++], p, sizeof p);
    }
    return count;
}

// Each edge has one mate (join), the pieces hang together as they should, and the Euler characteristic on the torus
// of one cell is that of tori: a sheet over the whole plane, rings or strands; or of discs, which stand on the base.
// A pinched vertex or a hole would change it.
static void the_tiling_has_no_open_edge(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        loaded l;
        edge edges[MAX_EDGES];
        for (int k = -1, parameters = 0; k < parameters; k++) { // and with each parameter at its target
            int ncollapsed = 0, nfree = 0;
            load_at(ctx, &l, TILES[i].name, k);
            int n = join(edges, &l, &ncollapsed, &nfree);
            assert_int_equal(ncollapsed, TILES[i].ncollapsed);
            assert_int_equal(nfree, TILES[i].nfree);
            assert_int_equal((n - nfree) % 2, 0);
            assert_int_equal(components(&l, edges, n), TILES[i].components);
            int euler = vertices_on_the_torus(edges, n) - (n + nfree) / 2 + l.n;
            if (euler != (nfree > 0 ? TILES[i].components : 0)) print_error("%s: %d\n", TILES[i].name, euler);
            assert_int_equal(euler, nfree > 0 ? TILES[i].components : 0); // discs, or tori
            parameters = l.tile.nparameters;
            unload(ctx, &l);
        }
    }
    test_ctx_end(ctx, &memory);
}

// Integrals over a patch of du dv and of w du dv. The integrands have degree at most 5 in each variable, for which
// three Gauss points are exact.
static void integrate(kn_ctx *ctx, const kn_bezier *patch, double *area, double *volume)
{
    const double x[3] = {0.5 - sqrt(0.15), 0.5, 0.5 + sqrt(0.15)}, weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double at[2] = {x[i], x[j]}, d[9];
            assert_int_equal(kn_bezier_derivatives(ctx, d, patch, at, 1), KN_OK);
            double cross = (d[3] * d[7] - d[4] * d[6]) * weight[i] * weight[j];
            *area += cross;
            *volume += cross * d[2];
        }
}

// A sheet covers the cell once, seen from above and counting folds with their sign; closed solids have no shadow with
// sign, and what is open at the base has the shadow of its foot. The volume is positive only if they face outwards.
// At most 96 * 9 terms of size at most 1.
static void sheets_cover_and_solids_face_outwards(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        loaded l;
        load(ctx, &l, TILES[i].name);
        double area[4] = {0.0}, volume[4] = {0.0};
        for (int k = 0; k < l.n; k++) {
            int part = l.tile.covering ? 0 : l.part[k]; // the parts of a sheet hold together
            integrate(ctx, &l.patch[k], &area[part], &volume[part]);
        }
        for (int p = 0; p < (l.tile.covering ? 1 : l.tile.nparts); p++) {
            double tolerance = 96 * 9 * 20 * DBL_EPSILON;
            if (TILES[i].nfree > 0)
                assert_true(area[p] > 0.0 && area[p] < 0.1);
            else
                assert_true(fabs(area[p] - (TILES[i].covering ? 1.0 : 0.0)) < tolerance);
            print_message("# %s, part %d: volume %.4f\n", TILES[i].name, p, volume[p]);
            assert_true(volume[p] > (TILES[i].nfree > 0 ? 0.001 : 0.02) && volume[p] < 0.95);
        }
        unload(ctx, &l);
    }
    test_ctx_end(ctx, &memory);
}

// The same of the library itself, which proves it from the control points: copies join, smoothly where they are meant
// to, and a covering tile covers, a casual one does not.
static void tiles_are_periodic_and_cover_as_claimed(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        kn_tile tile = {0};
        kn_tile_periodicity_report periodic = {0};
        kn_tile_coverage_report cover = {0};
        kn_tile_coverage_options coarse = kn_tile_coverage_defaults();
        coarse.depth = 6, coarse.max_boxes = 1 << 10; // enough to see a gap, or a sheet
        assert_int_equal(kn_builtin_tile(ctx, &tile, TILES[i].name), KN_OK);
        assert_int_equal(kn_tile_periodicity(ctx, &periodic, &tile, NULL), KN_OK);
        assert_int_equal(periodic.open, TILES[i].nfree);
        assert_int_equal(periodic.crowded + periodic.reversed + periodic.unchecked, 0);
        bool joins = periodic.joints[0] + periodic.joints[1] > 0;
        assert_true(joins == (TILES[i].nfree == 0));
        for (int d = 0; d < 3; d++)
            if (periodic.joints[d] > 0 && periodic.order[d] < (TILES[i].smooth == always ? 1 : 0))
                fail_msg("%s: order %d in direction %d", tile.name, periodic.order[d], d);
        assert_int_equal(kn_tile_coverage(ctx, &cover, &tile, &coarse), KN_OK);
        assert_int_equal(cover.covers, TILES[i].covering ? KN_YES : KN_NO);
        kn_tile_coverage_clear(ctx, &cover);
        kn_tile_clear(ctx, &tile);
    }
    test_ctx_end(ctx, &memory);
}

static void normal(kn_ctx *ctx, double n[3], const kn_bezier *b, const double at[2])
{
    double d[9], length = 0.0;
    assert_int_equal(kn_bezier_derivatives(ctx, d, b, at, 1), KN_OK);
    for (int c = 0; c < 3; c++) {
        int e = (c + 1) % 3, f = (c + 2) % 3;
        n[c] = d[3 + e] * d[6 + f] - d[3 + f] * d[6 + e];
        length += n[c] * n[c];
    }
    for (int c = 0; c < 3; c++) n[c] /= sqrt(length);
}

// The largest angle between the normals of two mates, away from the ends, where a collapsed edge may end.
static double crease(kn_ctx *ctx, const loaded *l, const edge *a, const edge *b)
{
    double most = 0.0;
    for (int k = 1; k < 16; k++) {
        double at[2], bt[2], n[3], m[3], chord = 0.0;
        parameters(at, a->side, k / 16.0);
        parameters(bt, b->side, 1.0 - k / 16.0);
        normal(ctx, n, &l->patch[a->patch], at);
        normal(ctx, m, &l->patch[b->patch], bt);
        for (int c = 0; c < 3; c++) chord += (n[c] - m[c]) * (n[c] - m[c]);
        most = fmax(most, 2.0 * asin(fmin(1.0, sqrt(chord) / 2.0)));
    }
    return most;
}

// Control points are exact and C1 joints too (G1 with one factor along the joint), so that where a joint is smooth
// the normals differ by rounding alone, some DBL_EPSILON over the size of a patch; elsewhere they differ visibly.
static const double SMOOTH = 1e-12, SHARP = 0.1;

// Of all joints: how many are smooth and are meant to be, or may be; the others are seen.
static void count_smooth(kn_ctx *ctx, const loaded *l, const expected *what, int count[2])
{
    edge edges[MAX_EDGES];
    int ncollapsed = 0, nfree = 0, n = join(edges, l, &ncollapsed, &nfree);
    for (int k = 0; k < n; k++) {
        if (edges[k].mate < 0) continue;
        const edge *mate = &edges[edges[k].mate];
        bool meant = what->smooth && what->smooth(ctx, l, &edges[k], mate);
        double angle = crease(ctx, l, &edges[k], mate);
        bool fine = angle <= SMOOTH || (!meant && angle >= SHARP);
        if (!fine) print_error("%s: patch %d side %d: %g\n", what->name, edges[k].patch, edges[k].side, angle);
        assert_true(fine);
        count[angle <= SMOOTH ? 0 : 1]++;
    }
}

static void what_is_smooth_is_smooth(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++)
        for (int k = -1, parameters = 0; k < parameters; k++) {
            loaded l;
            int count[2] = {0, 0};
            load_at(ctx, &l, TILES[i].name, k);
            parameters = l.tile.nparameters;
            count_smooth(ctx, &l, &TILES[i], count);
            unload(ctx, &l);
        }
    test_ctx_end(ctx, &memory);
}

// ---- chain ----

// One ring or link: patches, each with the cell that it is moved to.
typedef struct body {
    const kn_bezier *patch[16];
    double move[16][2];
    int n;
} body;

static void add_patches(body *b, const loaded *l, int first, int count, double u, double v)
{
    for (int k = 0; k < count; k++, b->n++) {
        b->patch[b->n] = &l->patch[first + k];
        b->move[b->n][0] = u, b->move[b->n][1] = v;
    }
}

// The file's order: the ring; then halves of links, eight patches each: about (1,.5), (0,.5), (.5,1), (.5,0).
static body ring(const loaded *l, double u, double v)
{
    body b = {.n = 0};
    add_patches(&b, l, 0, 16, u, v);
    return b;
}

static body link_u(const loaded *l, double u, double v) // about (1 + u, .5 + v)
{
    body b = {.n = 0};
    add_patches(&b, l, 16, 8, u, v);
    add_patches(&b, l, 24, 8, u + 1.0, v);
    return b;
}

static body link_v(const loaded *l, double u, double v) // about (.5 + u, 1 + v)
{
    body b = {.n = 0};
    add_patches(&b, l, 32, 8, u, v);
    add_patches(&b, l, 40, 8, u, v + 1.0);
    return b;
}

// In real proportions: w times the aspect.
static void point(kn_ctx *ctx, double p[3], const body *b, int k, const double at[2], double aspect)
{
    assert_int_equal(kn_bezier_eval(ctx, p, b->patch[k], at), KN_OK);
    p[0] += b->move[k][0], p[1] += b->move[k][1], p[2] *= aspect;
}

static double distance(const double *a, const double *b)
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

enum { SIDE = 9, SAMPLES = SIDE * SIDE }; // of a patch

typedef struct cloud {
    double p[16][SAMPLES][3];
} cloud;

// The parameters of sample s of a patch.
static void sample_at(double at[2], int s)
{
    int i = s / SIDE, j = s % SIDE;
    at[0] = i / (SIDE - 1.0), at[1] = j / (SIDE - 1.0);
}

static void sample(kn_ctx *ctx, cloud *c, const body *b, double aspect)
{
    for (int k = 0; k < b->n; k++)
        for (int s = 0; s < SAMPLES; s++) {
            double at[2];
            sample_at(at, s);
            point(ctx, c->p[k][s], b, k, at, aspect);
        }
}

// Descent by halved steps in the four parameters of a pair of points on patches i of a and j of b.
static double refine(kn_ctx *ctx, const body *a, int i, const body *b, int j, double x[4], double aspect)
{
    double p[3], q[3];
    point(ctx, p, a, i, x, aspect);
    point(ctx, q, b, j, x + 2, aspect);
    double best = distance(p, q);
    for (double step = 0.125; step > 1e-5;) {
        bool better = false;
        for (int c = 0; c < 8; c++) {
            double y[4];
            memcpy(y, x, sizeof y);
            y[c / 2] = fmin(1.0, fmax(0.0, y[c / 2] + (c % 2 ? step : -step)));
            point(ctx, p, a, i, y, aspect);
            point(ctx, q, b, j, y + 2, aspect);
            if (distance(p, q) >= best) continue;
            best = distance(p, q), better = true;
            memcpy(x, y, sizeof y);
        }
        if (!better) step /= 2.0;
    }
    return best;
}

// The least distance of two bodies: of samples, then refined on every pair of patches that comes near.
static double clearance(kn_ctx *ctx, const body *a, const body *b, double aspect)
{
    static const double NEAR = 0.15;
    cloud *c = malloc(2 * sizeof *c);
    assert_non_null(c);
    sample(ctx, &c[0], a, aspect);
    sample(ctx, &c[1], b, aspect);
    double least = INFINITY;
    for (int i = 0; i < a->n; i++)
        for (int j = 0; j < b->n; j++) {
            double best = INFINITY, x[4] = {0.0, 0.0, 0.0, 0.0};
            for (int s = 0; s < SAMPLES; s++)
                for (int t = 0; t < SAMPLES; t++) {
                    double d = distance(c[0].p[i][s], c[1].p[j][t]);
                    if (d >= best) continue;
                    best = d;
                    sample_at(x, s);
                    sample_at(x + 2, t);
                }
            if (best < NEAR) best = refine(ctx, a, i, b, j, x, aspect);
            least = fmin(least, best);
        }
    free(c);
    return least;
}

// No two of the rings and links come nearer than 0.03 of a cell's width. By symmetry the pairs below are all the
// different ones among neighbours.
static void links_do_not_touch(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    loaded l;
    load(ctx, &l, "chain");
    body a[] = {ring(&l, 0, 0), ring(&l, 0, 0), ring(&l, 0, 0), link_u(&l, 0, 0), link_u(&l, 0, 0)};
    body b[] = {ring(&l, 1, 0), ring(&l, 1, 1), link_u(&l, 0, 0), link_u(&l, -1, 0), link_v(&l, 0, 0)};
    const char *what[] = {"neighbouring rings", "rings across a corner", "ring and link", "opposite links",
                          "links at a right angle"};
    for (size_t k = 0; k < sizeof a / sizeof *a; k++) {
        double gap = clearance(ctx, &a[k], &b[k], l.tile.aspect);
        print_message("# clearance, %s: %.4f\n", what[k], gap);
        assert_true(gap > 0.03);
    }
    // By symmetry: a turn of the tile takes u to v.
    body r = ring(&l, 0, 0), v = link_v(&l, 0, 0), u = link_u(&l, 0, 0);
    assert_true(fabs(clearance(ctx, &r, &v, l.tile.aspect) - clearance(ctx, &r, &u, l.tile.aspect)) < 1e-3);
    unload(ctx, &l);
    test_ctx_end(ctx, &memory);
}

enum { CURVE = 128 };

// The centre curve of a ring or link: r runs round it, and opposite points of the section are 2 patches apart.
static void centre_curve(kn_ctx *ctx, double curve[CURVE][3], const body *b, double aspect)
{
    for (int k = 0; k < CURVE; k++) {
        int quarter = 4 * k / CURVE; // of the way round, four patches each
        double at[2] = {4.0 * k / CURVE - quarter, 0.0}, p[3], q[3];
        bool second = b->n == 16 && b->move[15][0] + b->move[15][1] != b->move[0][0] + b->move[0][1] && quarter >= 2;
        if (second) { // the second half of a link runs from its top to its bottom too: back again
            quarter = 5 - quarter;
            at[0] = 1.0 - at[0];
        }
        point(ctx, p, b, 4 * quarter, at, aspect);
        point(ctx, q, b, 4 * quarter + 2, at, aspect);
        for (int c = 0; c < 3; c++) curve[k][c] = (p[c] + q[c]) / 2.0;
    }
}

// Gauss: Lk = 1/(4 pi) sum over pairs of chords of (x - y) . (dx x dy) / |x - y|^3, at the midpoints of the chords.
static double linking_number(kn_ctx *ctx, const body *a, const body *b, double aspect)
{
    double x[CURVE][3], y[CURVE][3], sum = 0.0;
    centre_curve(ctx, x, a, aspect);
    centre_curve(ctx, y, b, aspect);
    for (int i = 0; i < CURVE; i++)
        for (int j = 0; j < CURVE; j++) {
            const double *p = x[i], *p1 = x[(i + 1) % CURVE], *q = y[j], *q1 = y[(j + 1) % CURVE];
            double d[3], dx[3], dy[3];
            for (int c = 0; c < 3; c++) {
                d[c] = (p[c] + p1[c]) / 2.0 - (q[c] + q1[c]) / 2.0;
                dx[c] = p1[c] - p[c], dy[c] = q1[c] - q[c];
            }
            double triple = 0.0, r = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
            for (int c = 0; c < 3; c++) {
                int e = (c + 1) % 3, f = (c + 2) % 3;
                triple += d[c] * (dx[e] * dy[f] - dx[f] * dy[e]);
            }
            sum += triple / (r * r * r);
        }
    return sum / (4.0 * 3.14159265358979323846);
}

// Each ring is linked with the four links about it, and rings with nothing else. The sum above is wrong by about
// (chord / distance)^2 / 24 < 0.005; linking numbers are integers.
static void links_interlock(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    loaded l;
    load(ctx, &l, "chain");
    body middle = ring(&l, 0, 0), next = ring(&l, 1, 0), above = ring(&l, 0, 1);
    body links[4] = {link_u(&l, 0, 0), link_u(&l, -1, 0), link_v(&l, 0, 0), link_v(&l, 0, -1)};
    double aspect = l.tile.aspect;
    for (int k = 0; k < 4; k++) {
        double number = linking_number(ctx, &middle, &links[k], aspect);
        print_message("# linking number of ring and link %d: %.4f\n", k, number);
        assert_true(fabs(fabs(number) - 1.0) < 0.02);
    }
    assert_true(fabs(fabs(linking_number(ctx, &next, &links[0], aspect)) - 1.0) < 0.02);
    assert_true(fabs(fabs(linking_number(ctx, &above, &links[2], aspect)) - 1.0) < 0.02);
    assert_true(fabs(linking_number(ctx, &middle, &next, aspect)) < 0.02);
    assert_true(fabs(linking_number(ctx, &next, &links[1], aspect)) < 0.02);
    assert_true(fabs(linking_number(ctx, &links[0], &links[2], aspect)) < 0.02);
    unload(ctx, &l);
    test_ctx_end(ctx, &memory);
}

// ---- strands ----

enum { WINDOW = 5, CELLS = WINDOW * WINDOW, NODES = CELLS * MAX_PATCHES, NEAR_STEPS = 5 };

// Where an edge leads: the mate's patch, and by how many cells it lies from this one's.
typedef struct step {
    int patch, du, dv;
} step;

static void steps(const loaded *l, step to[][4])
{
    edge edges[MAX_EDGES];
    int ncollapsed = 0, nfree = 0, n = join(edges, l, &ncollapsed, &nfree);
    for (int i = 0; i < l->n; i++)
        for (int side = 0; side < 4; side++) to[i][side].patch = -1;
    for (int i = 0; i < n; i++) {
        if (edges[i].mate < 0) continue;
        const edge *mate = &edges[edges[i].mate];
        const double *p = edges[i].p[0], *q = mate->p[mate->n - 1];
        to[edges[i].patch][edges[i].side] = (step){mate->patch, (int)(p[0] - q[0]), (int)(p[1] - q[1])};
    }
}

// How many joints lead from patch i of the middle cell to each patch of the cells about it; -1: more than NEAR_STEPS.
static void walk(int *far, const loaded *l, const step to[][4], int i)
{
    int queue[NODES], head = 0, tail = 0;
    for (int k = 0; k < CELLS * l->n; k++) far[k] = -1;
    queue[tail++] = (CELLS / 2) * l->n + i;
    far[queue[0]] = 0;
    while (head < tail) {
        int node = queue[head++], patch = node % l->n, x = node / l->n % WINDOW, y = node / l->n / WINDOW;
        if (far[node] == NEAR_STEPS) continue;
        for (int side = 0; side < 4; side++) {
            step s = to[patch][side];
            int u = x + s.du, v = y + s.dv, next = (v * WINDOW + u) * l->n + s.patch;
            if (s.patch < 0 || u < 0 || v < 0 || u >= WINDOW || v >= WINDOW || far[next] >= 0) continue;
            far[next] = far[node] + 1;
            queue[tail++] = next;
        }
    }
}

// Between the boxes of the control points, in real proportions.
static double box_distance(const kn_bezier *a, const kn_bezier *b, const double move[2], double aspect)
{
    double sum = 0.0;
    for (size_t c = 0; c < 3; c++) {
        double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
        const kn_bezier *both[2] = {a, b};
        for (int k = 0; k < 2; k++)
            for (size_t i = 0, n = kn_bezier_count(both[k]); i < n; i++) {
                double x = both[k]->coef[c * n + i] * (c == 2 ? aspect : 1.0) + (k == 1 && c < 2 ? move[c] : 0.0);
                lo[k] = fmin(lo[k], x), hi[k] = fmax(hi[k], x);
            }
        double gap = fmax(0.0, fmax(lo[0] - hi[1], lo[1] - hi[0]));
        sum += gap * gap;
    }
    return sqrt(sum);
}

// The least distance of two patches that are not close to each other along one strand.
static double least_gap(kn_ctx *ctx, const loaded *l)
{
    static const double NEAR = 0.03;
    step to[MAX_PATCHES][4];
    int far[NODES];
    double least = INFINITY;
    steps(l, to);
    for (int i = 0; i < l->n; i++) {
        walk(far, l, (const step(*)[4])to, i);
        body a = {.n = 0};
        add_patches(&a, l, i, 1, 0, 0);
        for (int k = 0; k < CELLS * l->n; k++) {
            int j = k % l->n, u = k / l->n % WINDOW - WINDOW / 2, v = k / l->n / WINDOW - WINDOW / 2;
            double move[2] = {u, v};
            if (far[k] >= 0 || j > i || box_distance(&l->patch[i], &l->patch[j], move, l->tile.aspect) > NEAR)
                continue;
            body b = {.n = 0};
            add_patches(&b, l, j, 1, u, v);
            least = fmin(least, clearance(ctx, &a, &b, l->tile.aspect));
        }
    }
    return least;
}

static void strands_do_not_touch(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    for (int i = 0; i < NTILES; i++) {
        if (TILES[i].gap == 0.0) continue;
        loaded l;
        load(ctx, &l, TILES[i].name);
        double gap = least_gap(ctx, &l);
        print_message("# %s: least gap %.4f\n", TILES[i].name, gap);
        assert_true(gap > TILES[i].gap);
        unload(ctx, &l);
    }
    test_ctx_end(ctx, &memory);
}

// ---- knitting ----

static double turn(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

enum { YARN_SPANS = 16, YARN = 8 * YARN_SPANS };

// The middle of the yarn from foot to foot; head and feet, which are modelled a cell away, back in their places. The
// file's order: half a foot, a leg, the head, a leg, half a foot, of 2, 4, 4, 4, 2 spans with four patches each.
static void yarn(kn_ctx *ctx, double curve[YARN][3], const loaded *l)
{
    for (int k = 0; k < YARN; k++) {
        int span = k / 8;
        double at[2] = {(k % 8 + 0.5) / 8.0, 0.0}, p[3], q[3];
        assert_int_equal(kn_bezier_eval(ctx, p, &l->patch[4 * span], at), KN_OK);
        assert_int_equal(kn_bezier_eval(ctx, q, &l->patch[4 * span + 2], at), KN_OK);
        for (int c = 0; c < 3; c++) curve[k][c] = (p[c] + q[c]) / 2.0;
        curve[k][1] += span < 2 || span >= 14 ? -1.0 : span >= 6 && span < 10 ? 1.0 : 0.0;
    }
}

// Whether chord a of the yarn crosses chord b of the next row, seen from above, and how much higher it then is.
static bool crosses(double *higher, double curve[YARN][3], int a, int b, double shift)
{
    const double *p0 = curve[a], *p1 = curve[a + 1];
    double q0[2] = {curve[b][0] + shift, curve[b][1] + 1.0}, q1[2] = {curve[b + 1][0] + shift, curve[b + 1][1] + 1.0};
    double s0 = turn(q0, q1, p0), s1 = turn(q0, q1, p1), t0 = turn(p0, p1, q0), t1 = turn(p0, p1, q1);
    if (s0 * s1 >= 0.0 || t0 * t1 >= 0.0) return false;
    double s = s0 / (s0 - s1), t = t0 / (t0 - t1);
    *higher = (1.0 - s) * p0[2] + s * p1[2] - (1.0 - t) * curve[b][2] - t * curve[b + 1][2];
    return true;
}

// On its way up a leg the yarn passes over the foot of the next row, under its legs with the head, and down over the
// foot again: none of the loops can be drawn out of the others.
static void stitches_hang_in_each_other(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    loaded l;
    double curve[YARN][3];
    char pattern[64] = "";
    size_t n = 0;
    load(ctx, &l, "knit");
    yarn(ctx, curve, &l);
    for (int a = 0; a + 1 < YARN; a++)
        for (int b = 0; b + 1 < YARN; b++)
            for (int shift = -1; shift <= 1; shift++) {
                double higher = 0.0;
                if (!crosses(&higher, curve, a, b, shift)) continue;
                assert_true(fabs(higher) > 0.2 && n + 1 < sizeof pattern);
                pattern[n++] = higher > 0.0 ? 'o' : 'u';
            }
    print_message("# over and under the next row: %s\n", pattern);
    assert_string_equal(pattern, "ouuo");
    unload(ctx, &l);
    test_ctx_end(ctx, &memory);
}

// ---- scale ----

enum { STEPS = 24, MAX_SEGMENTS = 3 * 8 * STEPS };

// The folded sheet of scales does not cut itself: u = r over each half cell, so that the section at a constant u is a
// curve in (v, w), here as chords, with its copies one cell before and behind.
static void scales_do_not_cut_each_other(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    loaded l;
    load(ctx, &l, "scale");
    for (int line = 0; line <= 16; line++) {
        double chord[MAX_SEGMENTS][4];
        int n = 0;
        for (int k = 0; k < l.n; k++) {
            const double *u = l.patch[k].coef; // u does not depend on t
            double lo = u[0], hi = u[6], x = line / 32.0 + (line > 8 ? 0.25 : 0.0);
            assert_true(u[1] == lo && u[2] == lo && u[7] == hi && u[3] == (lo + hi) / 2.0 && hi - lo == 0.5);
            if (x < lo || x > hi || (x == hi && hi < 1.0)) continue;
            for (int s = 0; s < STEPS; s++) {
                double a[2] = {(x - lo) / (hi - lo), (double)s / STEPS}, b[2] = {a[0], (s + 1.0) / STEPS}, p[3], q[3];
                assert_int_equal(kn_bezier_eval(ctx, p, &l.patch[k], a), KN_OK);
                assert_int_equal(kn_bezier_eval(ctx, q, &l.patch[k], b), KN_OK);
                for (int copy = -1; copy <= 1; copy++, n++) {
                    chord[n][0] = p[1] + copy, chord[n][1] = p[2];
                    chord[n][2] = q[1] + copy, chord[n][3] = q[2];
                }
            }
        }
        assert_int_equal(n, MAX_SEGMENTS);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++) {
                const double *a = chord[i], *b = chord[j];
                double ab = turn(a, a + 2, b) * turn(a, a + 2, b + 2), ba = turn(b, b + 2, a) * turn(b, b + 2, a + 2);
                // strictly across; chords that follow each other meet at an end, up to rounding
                assert_false(ab < -1e-20 && ba < -1e-20);
            }
    }
    unload(ctx, &l);
    test_ctx_end(ctx, &memory);
}

// ---- the calls themselves ----

static void an_unknown_tile_is_refused(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_tile tile, before;
    memset(&tile, 7, sizeof tile);
    before = tile;
    assert_int_equal(kn_builtin_tile(ctx, &tile, "wicker"), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(ctx), "wicker"));
    assert_memory_equal(&tile, &before, sizeof tile);
    test_ctx_end(ctx, &memory);
}

static kn_status load_bump(kn_ctx *ctx, void *user)
{
    (void)user;
    kn_tile tile = {0};
    kn_status status = kn_builtin_tile(ctx, &tile, "bump");
    if (status != KN_OK) assert_null(tile.parts);
    kn_tile_clear(ctx, &tile);
    return status;
}

static const char G2[] = "200 1 0 0\n3 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n-4 10 0  12 10 0  -4 18 0  12 18 2\n";

static kn_status load_file(kn_ctx *ctx, void *user)
{
    kn_tile tile = {0};
    kn_status status = kn_read_tile(ctx, &tile, user, NULL);
    if (status != KN_OK) assert_null(tile.parts);
    kn_tile_clear(ctx, &tile);
    return status;
}

static void every_allocation_may_fail(void **state)
{
    (void)state;
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "tile.g2");
    test_write_file(path, G2, sizeof G2 - 1);
    test_allocation_failures(load_bump, NULL);
    test_allocation_failures(load_file, path);
    remove(path);
}

static void a_file_becomes_a_tile(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char path[TEST_PATH_BYTES];
    test_tmp_path(path, "saddle.of.mine.g2");
    test_write_file(path, G2, sizeof G2 - 1);
    kn_tile tile = {0};
    assert_int_equal(kn_read_tile(ctx, &tile, path, NULL), KN_OK);
    assert_true(tile.aspect == 1.0 && !tile.covering && tile.nparts == 1 && tile.parts[0].nsplines == 1);
    assert_non_null(strstr(tile.name, "saddle.of.mine"));
    assert_null(strchr(tile.name, '/'));
    assert_null(strstr(tile.name, ".g2"));
    assert_true(tile.parts[0].splines[0].coef[0] == -4.0);
    kn_tile_clear(ctx, &tile);

    const double cell[4] = {-4, 10, 12, 14}; // 16 x 4: lengths of w are seen over a cell of width 8
    assert_int_equal(kn_read_tile(ctx, &tile, path, cell), KN_OK);
    const double mapped[12] = {0, 0, 1, 1, 0, 2, 0, 2, 0, 0, 0, 2};
    assert_memory_equal(tile.parts[0].splines[0].coef, mapped, sizeof mapped);
    assert_true(tile.aspect == 0.125);
    kn_tile before = tile;

    const double bad[][4] = {{0, 0, 0, 1}, {0, 1, 1, 0}, {0, 0, INFINITY, 1}, {NAN, 0, 1, 1}, {-1e308, 0, 1e308, 1}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(kn_read_tile(ctx, &tile, path, bad[i]), KN_EDOMAIN);
    assert_int_equal(kn_read_tile(ctx, &tile, "/nowhere/at.g2", NULL), KN_EIO);
    assert_int_equal(kn_read_tile(ctx, &tile, "tile.xyz", NULL), KN_EDOMAIN);
    const char *plane = "200 1 0 0\n2 0\n2 2\n0 0 1 1\n2 2\n0 0 1 1\n0 0  1 0  0 1  1 1\n";
    test_write_file(path, plane, strlen(plane));
    assert_int_equal(kn_read_tile(ctx, &tile, path, NULL), KN_EDOMAIN);
    test_write_file(path, G2, 40);
    assert_int_equal(kn_read_tile(ctx, &tile, path, NULL), KN_EPARSE);
    assert_memory_equal(&tile, &before, sizeof tile);
    kn_tile_clear(ctx, &tile);
    remove(path);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_list_is_as_documented),
        cmocka_unit_test(tiles_stay_in_their_cell),
        cmocka_unit_test(the_tiling_has_no_open_edge),
        cmocka_unit_test(sheets_cover_and_solids_face_outwards),
        cmocka_unit_test(tiles_are_periodic_and_cover_as_claimed),
        cmocka_unit_test(what_is_smooth_is_smooth),
        cmocka_unit_test(links_do_not_touch),
        cmocka_unit_test(links_interlock),
        cmocka_unit_test(strands_do_not_touch),
        cmocka_unit_test(stitches_hang_in_each_other),
        cmocka_unit_test(scales_do_not_cut_each_other),
        cmocka_unit_test(an_unknown_tile_is_refused),
        cmocka_unit_test(every_allocation_may_fail),
        cmocka_unit_test(a_file_becomes_a_tile),
    };
    return cmocka_run_group_tests_name("io/tiles", tests, NULL, NULL);
}
