// SPDX-License-Identifier: Apache-2.0
// knurl tiles --check: what is proved of one tile.
#include "cli/cli.h"

#include <jansson.h>
#include <math.h>

static const char *const DIRECTIONS[3] = {"u", "v", "inside"};
enum { GAPS_SHOWN = 8 };

static json_t *edge_json(const kn_tile *tile, const kn_tile_edge *e)
{
    if (e->part < 0) return json_null();
    json_t *o = json_pack("{s:o,s:i,s:i}", "part", cli_json_text(tile->parts[e->part].name), "spline", e->spline,
                          "piece", e->piece);
    if (e->face >= 0) json_object_set_new(o, "face", json_integer(e->face));
    if (e->edge >= 0) json_object_set_new(o, "edge", json_integer(e->edge));
    return o;
}

static json_t *gap_json(const kn_tile *tile, const kn_tile_gap *g)
{
    return json_pack("{s:o,s:o,s:[ii],s:f,s:[fff],s:o}", "edge", edge_json(tile, &g->edge), "mate",
                     edge_json(tile, &g->mate), "offset", g->offset[0], g->offset[1], "at", g->at, "point",
                     g->point[0], g->point[1], g->point[2], "amount", cli_json_number(g->amount));
}

static json_t *periodicity_json(const kn_tile *tile, const kn_tile_periodicity_report *r, int most)
{
    json_t *o = json_object(), *open = json_array();
    for (int d = 0; d < 3; d++) {
        bool failed = r->order[d] < most && r->decided[d];
        json_object_set_new(o, DIRECTIONS[d],
                            json_pack("{s:i,s:b,s:I,s:o}", "order", r->order[d], "decided", r->decided[d], "joints",
                                      (json_int_t)r->joints[d], "first_failure",
                                      failed ? gap_json(tile, &r->first[d]) : json_null()));
    }
    for (size_t k = 0; k < r->open && k < KN_TILE_LISTED; k++)
        json_array_append_new(open, edge_json(tile, &r->open_edges[k]));
    json_object_set_new(o, "open", json_integer((json_int_t)r->open));
    json_object_set_new(o, "open_edges", open);
    json_object_set_new(o, "crowded", json_integer((json_int_t)r->crowded));
    json_object_set_new(o, "reversed", json_integer((json_int_t)r->reversed));
    json_object_set_new(o, "unchecked", json_integer((json_int_t)r->unchecked));
    return o;
}

static const char *answer(kn_answer a)
{
    return a == KN_YES ? "yes" : a == KN_NO ? "no" : "undecided";
}

static json_t *coverage_json(const kn_tile_coverage_report *r)
{
    json_t *gaps = json_array();
    for (size_t k = 0; k < r->ngaps; k++) {
        const kn_tile_rect *g = &r->gaps[k];
        json_array_append_new(gaps, json_pack("[ffff]", g->lo[0], g->lo[1], g->hi[0], g->hi[1]));
    }
    return json_pack("{s:s,s:f,s:f,s:o}", "covers", answer(r->covers), "covered", r->covered, "bare", r->bare, "gaps",
                     gaps);
}

static void print_edge(const kn_tile *tile, const kn_tile_edge *e)
{
    printf("part \"%s\", ", tile->parts[e->part].name);
    if (e->spline < 0)
        printf("triangle %d", e->piece);
    else
        printf("spline %d, piece %d", e->spline, e->piece);
    if (e->face >= 0) printf(", face %d", e->face);
    if (e->edge >= 0) printf(", edge %d", e->edge);
}

static void print_direction(const kn_tile *tile, const kn_tile_periodicity_report *r, int d, int most)
{
    static const char *const names[4] = {"torn", "C0", "G1", "G2"};
    static const char *const amiss[3] = {"apart by", "the normals turn by (radians)", "curvatures differ by"};
    const kn_tile_gap *g = &r->first[d];
    int order = r->order[d];
    printf("%-7s %s", DIRECTIONS[d], r->joints[d] || order < 0 ? names[order + 1] : "nothing joins");
    if (r->joints[d]) printf(", %zu joints", r->joints[d]);
    if (!r->decided[d]) printf(", %s undecided", names[order + 2]);
    putchar('\n');
    if (order >= most || !r->decided[d]) return;
    printf("        not %s: ", names[order + 2]);
    print_edge(tile, &g->edge);
    if (g->mate.part >= 0) {
        printf("\n        and ");
        print_edge(tile, &g->mate);
        printf(" of cell %d,%d", g->offset[0], g->offset[1]);
    } else
        printf(", which has no mate");
    printf("\n        at parameter %.4g, (%.4g, %.4g, %.4g)", g->at, g->point[0], g->point[1], g->point[2]);
    if (isfinite(g->amount)) printf(": %s %.3g", amiss[order + 1], g->amount);
    putchar('\n');
}

static void print_report(const kn_tile *tile, const kn_tile_periodicity_report *r, const kn_tile_coverage_report *c,
                         int most)
{
    printf("%s\n", tile->name);
    for (int d = 0; d < 3; d++) print_direction(tile, r, d, most);
    printf("edges   %zu open, %zu with several mates, %zu joints of opposite sides\n", r->open, r->crowded,
           r->reversed);
    for (size_t k = 0; k < r->open && k < KN_TILE_LISTED; k++) {
        printf("        open: ");
        print_edge(tile, &r->open_edges[k]);
        putchar('\n');
    }
    if (r->unchecked) printf("        %zu trimmed surfaces are left out\n", r->unchecked);
    printf("covers  %s: %.6g covered, %.6g bare, %.6g undecided\n", answer(c->covers), c->covered, c->bare,
           1.0 - c->covered - c->bare);
    for (size_t k = 0; k < c->ngaps && k < GAPS_SHOWN; k++) {
        const kn_tile_rect *g = &c->gaps[k];
        printf("        bare: u %g .. %g, v %g .. %g\n", g->lo[0], g->hi[0], g->lo[1], g->hi[1]);
    }
    if (c->ngaps > GAPS_SHOWN) printf("        and %zu more\n", c->ngaps - GAPS_SHOWN);
}

static void print_json(const kn_tile *tile, const kn_tile_periodicity_report *r, const kn_tile_coverage_report *c,
                       int most, bool ok)
{
    json_t *o = json_pack("{s:o,s:b,s:o,s:o,s:b}", "tile", cli_json_text(tile->name), "covering", tile->covering,
                          "periodicity", periodicity_json(tile, r, most), "coverage", coverage_json(c), "ok", ok);
    json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(CLI_JSON_DIGITS));
    putchar('\n');
    json_decref(o);
}

int cli_check_tile(cli_session *session, const kn_tile *tile, bool json)
{
    kn_ctx *ctx = cli_ctx(session);
    kn_tile_periodicity_report r;
    kn_tile_coverage_report c = {.covers = KN_UNKNOWN};
    int most = kn_tile_periodicity_defaults().max_order;
    kn_status status = kn_tile_check(ctx, tile);
    if (status == KN_OK) status = kn_tile_periodicity(ctx, &r, tile, NULL);
    if (status == KN_OK) status = kn_tile_coverage(ctx, &c, tile, NULL);
    if (status != KN_OK) return cli_fail(session, status, true);
    bool torn = r.order[0] < 0 || r.order[1] < 0, bare = tile->covering && c.covers == KN_NO;
    if (json)
        print_json(tile, &r, &c, most, !torn && !bare);
    else
        print_report(tile, &r, &c, most);
    if (torn) cli_error("tiles: the tiling of %s is torn", tile->name);
    if (bare) cli_error("tiles: %s is to cover its cell, and does not", tile->name);
    kn_tile_coverage_clear(ctx, &c);
    return torn || bare ? EXIT_CHECK_FAILED : EXIT_OK;
}
