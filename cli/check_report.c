// SPDX-License-Identifier: Apache-2.0
// What `knurl check` says: sentences for people, or one JSON object (the contract).
#include "cli/check.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 3, NAMED = 5 };

bool check_passed(const check *c)
{
    return c->verdict == KN_FOLD_POSITIVE && c->global.verdict == KN_FOLD_NONE;
}

static const kn_fold_heights *safe_of(const check *c, const check_cell *cell)
{
    const check_shell *s = &c->shells[cell->shell];
    return &s->cell_safe[cell->cell[0] * s->cells[1] + cell->cell[1]];
}

// ---- JSON ----

static json_t *numbers(const double *x, int n)
{
    json_t *array = json_array();
    for (int i = 0; i < n; i++) json_array_append_new(array, cli_json_number(x[i]));
    return array;
}

static json_t *cell_json(const check *c, const check_cell *cell)
{
    const check_shell *s = &c->shells[cell->shell];
    const kn_fold_heights *safe = safe_of(c, cell);
    return json_pack("{s:i,s:[ii],s:o,s:o,s:o,s:o,s:b}", "surface", s->surface, "cell",
                     s->first_cell[0] + cell->cell[0], s->first_cell[1] + cell->cell[1], "at", numbers(cell->at, 2),
                     "point", numbers(cell->point, 3), "safe_above", cli_json_lower(safe->above), "safe_below",
                     cli_json_lower(safe->below), "folds", cell->folds);
}

static json_t *local_json(const check *c)
{
    json_t *array = json_array();
    for (size_t i = 0; i < c->ncells && i < CHECK_WORST; i++)
        json_array_append_new(array, cell_json(c, &c->cells[i]));
    return array;
}

static json_t *region_json(const check *c, const kn_fold_region *r)
{
    return json_pack("{s:i,s:o,s:o}", "surface", c->shells[r->shell].surface, "lo", numbers(r->lo, 3), "hi",
                     numbers(r->hi, 3));
}

static json_t *global_json(const check *c)
{
    static const char *const names[] = {
        [KN_FOLD_NONE] = "none", [KN_FOLD_FOUND] = "found", [KN_FOLD_OPEN] = "undecided"};
    const kn_fold_intersection *g = &c->global;
    json_t *o = json_pack("{s:s,s:I,s:I}", "verdict", names[g->verdict], "boxes", (json_int_t)g->boxes,
                          "undecided_pairs", (json_int_t)g->undecided);
    if (g->verdict != KN_FOLD_NONE) {
        json_object_set_new(o, "a", region_json(c, &g->a));
        json_object_set_new(o, "b", region_json(c, &g->b));
    }
    if (g->verdict == KN_FOLD_FOUND) {
        json_object_set_new(o, "point", numbers(g->point, 3));
        json_object_set_new(o, "gap", cli_json_number(g->gap));
    }
    return json_pack("[o]", o);
}

static void print_json(const check *c)
{
    static const char *const verdicts[] = {[KN_FOLD_POSITIVE] = "positive",
                                           [KN_FOLD_NEGATIVE] = "negative",
                                           [KN_FOLD_MIXED] = "mixed",
                                           [KN_FOLD_UNDECIDED] = "undecided"};
    json_t *o = json_object();
    json_object_set_new(o, "base", cli_json_text(c->job.base));
    json_object_set_new(o, "tile", c->job.tile ? cli_json_text(c->job.tile) : json_null());
    json_object_set_new(o, "surfaces", json_integer(c->base.nsurfaces));
    json_object_set_new(o, "cells", json_integer((json_int_t)c->ncells));
    json_object_set_new(o, "range", numbers(c->range, 2));
    json_object_set_new(o, "passed", json_boolean(check_passed(c)));
    json_object_set_new(o, "jacobian",
                        json_pack("{s:o,s:o,s:s}", "min", cli_json_lower(c->jacobian[0]), "max",
                                  cli_json_upper(c->jacobian[1]), "verdict", verdicts[c->verdict]));
    json_object_set_new(
        o, "safe_height",
        json_pack("{s:o,s:o}", "above", cli_json_lower(c->safe.above), "below", cli_json_lower(c->safe.below)));
    json_object_set_new(o, "folding_cells", json_integer((json_int_t)c->nfolding));
    json_object_set_new(o, "local", local_json(c));
    json_object_set_new(o, "global", global_json(c));
    json_object_set_new(o, "seconds", json_real(c->seconds));
    json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(12));
    putchar('\n');
    json_decref(o);
}

// ---- text ----

typedef struct text {
    char s[96];
} text;

// A safe height: rounded down, or that there is no limit: rounding leaves what does not fold a height that is finite,
// and absurd.
static text height_text(const check *c, double h)
{
    text t;
    if (h < 1e6 * fmax(fabs(c->range[0]), fabs(c->range[1])))
        snprintf(t.s, sizeof t.s, "%.*g", DIGITS, cli_outward(h, -1, DIGITS));
    else
        snprintf(t.s, sizeof t.s, "any height");
    return t;
}

static text point_text(const double p[3])
{
    text t;
    snprintf(t.s, sizeof t.s, "(%.4g, %.4g, %.4g)", p[0], p[1], p[2]);
    return t;
}

static void print_cells(const check *c)
{
    size_t n = c->nfolding < NAMED ? c->nfolding : NAMED;
    printf("  %zu of %zu cells fold%s\n", c->nfolding, c->ncells, c->nfolding > NAMED ? "; the worst of them:" : ":");
    printf("    surface      cell  safe above  safe below  near\n");
    for (size_t i = 0, shown = 0; i < c->ncells && shown < n; i++) {
        const check_cell *cell = &c->cells[i];
        const check_shell *s = &c->shells[cell->shell];
        if (!cell->folds) continue;
        const kn_fold_heights *safe = safe_of(c, cell);
        char name[32];
        snprintf(name, sizeof name, "%d,%d", s->first_cell[0] + cell->cell[0], s->first_cell[1] + cell->cell[1]);
        printf("    %7d %9s %11s %11s  %s\n", s->surface, name, height_text(c, safe->above).s,
               height_text(c, safe->below).s, point_text(cell->point).s);
        shown++;
    }
}

static void print_local(const check *c)
{
    switch (c->verdict) {
    case KN_FOLD_POSITIVE: printf("folds: nowhere (certified)\n"); break;
    case KN_FOLD_NEGATIVE: printf("folds: everywhere: the base is inside out (its Jacobian is negative)\n"); break;
    case KN_FOLD_MIXED: printf("folds: yes\n"); break;
    case KN_FOLD_UNDECIDED: printf("folds: could not be certified\n"); break;
    }
    for (int i = 0; i < c->nshells && c->verdict == KN_FOLD_UNDECIDED; i++) {
        const check_shell *s = &c->shells[i];
        if (s->sign.verdict != KN_FOLD_UNDECIDED) continue;
        printf("  in doubt: surface %d at (%.4g, %.4g), height %.4g\n", s->surface, s->sign.where[0],
               s->sign.where[1], s->sign.where[2]);
        break;
    }
    printf("safe: %s above the base, %s below it (certified; the limits are within 1 %% of this%s)\n",
           height_text(c, c->safe.above).s, height_text(c, c->safe.below).s,
           c->job.tile ? "; of whole cells, whatever the tile occupies" : "");
    if (c->nfolding > 0) print_cells(c);
}

static text witness_text(const check *c, const kn_fold_region *r)
{
    text t;
    snprintf(t.s, sizeof t.s, "surface %d at (%.4g, %.4g), height %.4g", c->shells[r->shell].surface, r->lo[0],
             r->lo[1], r->lo[2]);
    return t;
}

static void print_global(const check *c)
{
    const kn_fold_intersection *g = &c->global;
    if (g->verdict == KN_FOLD_NONE) printf("meets itself: nowhere (certified, %zu boxes)\n", g->boxes);
    if (g->verdict == KN_FOLD_FOUND) {
        printf("meets itself: yes, at %s\n", point_text(g->point).s);
        printf("    %s\n    %s\n", witness_text(c, &g->a).s, witness_text(c, &g->b).s);
    }
    if (g->verdict != KN_FOLD_OPEN) return;
    printf("meets itself: could not be certified; %zu pairs of places are in doubt after %zu boxes, one of them\n",
           g->undecided, g->boxes);
    printf("    %s\n    %s\n", witness_text(c, &g->a).s, witness_text(c, &g->b).s);
}

static double asked(const check *c)
{
    return fmax(fabs(c->range[0]), fabs(c->range[1]));
}

// The distance from the base that the worst of the cells that fold allows.
static double allowed(const check *c)
{
    double room = INFINITY;
    for (size_t i = 0; i < c->ncells; i++)
        if (c->cells[i].folds) room = fmin(room, c->cells[i].room);
    return room * asked(c);
}

// Lower it, with what is said by an offset; or what else there is to do where no height is safe.
static void advise_on_height(const check *c)
{
    double most = allowed(c), offset = fabs(c->job.options.offset);
    if (offset >= most) {
        printf("    lower the offset: with the height it has to stay within %s, and no cell folds\n",
               height_text(c, most).s);
        return;
    }
    if (offset > 0)
        printf("    lower the height: with the offset it has to stay within %s, and no cell folds",
               height_text(c, most).s);
    else
        printf("    lower the texture to %s, and no cell folds", height_text(c, most).s);
    bool above = c->range[1] > 0 && c->range[0] >= 0, below = c->range[0] < 0 && c->range[1] <= 0;
    if (offset == 0 && above && c->safe.below > c->range[1]) printf("; or put it below the base (--side below)");
    if (offset == 0 && below && c->safe.above > -c->range[0]) printf("; or put it above the base (--side above)");
    printf("\n    or lower it where there is no room: --thickness FILE.g2, with 1 where the height may stay\n");
}

// No height is safe: T is turned over from the start.
static void advise_on_orientation(const check *c)
{
    bool volumes = c->base.nsurfaces > 0 && c->base.surfaces[0].nvars == 3;
    if (volumes && c->verdict == KN_FOLD_NEGATIVE)
        printf("    the volume is left-handed: swap its u and v, or turn its w round\n");
    else if (volumes)
        printf("    the volume folds by itself, whatever the texture: mend it there\n");
    else if (c->job.options.direction && c->verdict == KN_FOLD_NEGATIVE)
        printf("    the direction points below the base: turn it round, and the side of the texture with it\n");
    else if (c->job.options.direction)
        printf("    the direction lies in the base there, or points below it: choose one that rises everywhere\n");
    else
        printf("    no height at all is safe there: mend the base, whose normals turn over at once\n");
}

static void advise_on_crossing(const check *c)
{
    const kn_fold_intersection *g = &c->global;
    double least = fmax(fabs(g->a.lo[2]), fabs(g->b.lo[2]));
    if (least > 1e-9 * asked(c))
        printf(
            "    there it reaches itself at height %.3g or below: keep it well below, or move the surfaces apart\n",
            least);
    else
        printf("    surfaces of the base itself cross there: trim them, or leave one of them without texture\n");
}

static void print_advice(const check *c)
{
    if (check_passed(c)) return;
    bool folds = c->verdict == KN_FOLD_MIXED || c->verdict == KN_FOLD_NEGATIVE;
    double most = allowed(c);
    printf("what to change:\n");
    if (folds && most > 0 && most < asked(c))
        advise_on_height(c);
    else if (folds)
        advise_on_orientation(c);
    if (c->verdict == KN_FOLD_UNDECIDED)
        printf("    the Jacobian vanishes there, or nearly: another height, or a base that is smoother there\n");
    if (c->global.verdict == KN_FOLD_FOUND) advise_on_crossing(c);
    if (c->global.verdict == KN_FOLD_OPEN)
        printf("    whether it meets itself may be decided with more work: --work %zu\n", 10 * c->work);
}

// A bound that rounding alone keeps from 0 is printed as 0.
static double plain(const check *c, double h)
{
    return fabs(h) < 1e-9 * asked(c) ? 0 : h;
}

static void print_text(const check *c)
{
    const char *s = c->base.nsurfaces == 1 ? "" : "s";
    if (c->job.tile)
        printf("%s: %s in %zu cells on %d surface%s, between heights %.4g and %.4g\n", c->job.base, c->job.tile,
               c->ncells, c->base.nsurfaces, s, plain(c, c->range[0]), plain(c, c->range[1]));
    else
        printf("%s: %d surface%s, between heights %.4g and %.4g\n", c->job.base, c->base.nsurfaces, s,
               plain(c, c->range[0]), plain(c, c->range[1]));
    print_local(c);
    print_global(c);
    print_advice(c);
    for (int i = 0; i < c->ndrawn; i++) printf("%s\n", c->outputs[i]);
    printf("%.2f s\n", c->seconds);
}

void check_print(const check *c)
{
    if (c->job.json)
        print_json(c);
    else if (!c->job.quiet)
        print_text(c);
}
