// SPDX-License-Identifier: Apache-2.0
// kn_cad_join: several faces as surfaces that share sides bit for bit.
//
// First surfaces are turned, by quarter turns, so that variables go on over joined sides as far as that can be.
// Directions of surfaces that joined sides lead from one into the other (across a surface too, from a side to the
// opposite one) are one class: they get one degree and the same knots over [0,1], on the grid of 2^-53 so that 1 - t
// is exact. Then weights are scaled alike, corners that are one point become one, and the control points of each
// joined side those of the first of the two faces.
#include "cad/join.h"
#include "kernel/context.h"

#include <math.h>
#include <string.h>

typedef struct joining {
    const kn_cad *cad;
    const int *faces;
    int n;
    kn_cad_join_options o;
    kn_cad_joined *out;
    kn_cad_match *match; // of each seam
    int *first, *second; // of each seam: places in `faces`
    int *parent;         // of each direction of each face, 2 face + variable along: union-find
    bool *turned;        // against its parent
    int *corner;         // of each corner, 4 face + 2 u + v: union-find
} joining;

// ---- union-find ----

static int root_of(const joining *j, int d, bool *turned)
{
    *turned = false;
    for (; j->parent[d] != d; d = j->parent[d]) *turned ^= j->turned[d];
    return d;
}

// False: they are one already, the other way round.
static bool unite(joining *j, int a, int b, bool reversed)
{
    bool ta, tb;
    int x = root_of(j, a, &ta), y = root_of(j, b, &tb);
    bool between = reversed != (ta != tb);
    if (x == y) return !between;
    int low = x < y ? x : y, high = x < y ? y : x;
    j->parent[high] = low;
    j->turned[high] = between;
    return true;
}

static int corner_root(const joining *j, int c)
{
    while (j->corner[c] != c) c = j->corner[c];
    return c;
}

// The corner of a face at an end (0, 1) of a side.
static int corner_of(int face, int side, int end)
{
    int at[2];
    at[side / 2] = side % 2, at[1 - side / 2] = end;
    return 4 * face + 2 * at[0] + at[1];
}

// ---- seams ----

static int place_of(const joining *j, int face)
{
    for (int i = 0; i < j->n; i++)
        if (j->faces[i] == face) return i;
    return -1;
}

static bool is_seam(const joining *j, const kn_cad_edge *e)
{
    return e->face[0] >= 0 && e->face[1] >= 0 && e->face[0] != e->face[1] && place_of(j, e->face[0]) >= 0 &&
           place_of(j, e->face[1]) >= 0;
}

static kn_status find_seams(kn_ctx *ctx, joining *j)
{
    int n = 0;
    for (int e = 0; e < j->cad->nedges; e++) n += is_seam(j, &j->cad->edges[e]);
    size_t room = (size_t)n;
    j->out->seams = kn_alloc_zero(ctx, room, sizeof *j->out->seams);
    j->match = kn_scratch(ctx, room, sizeof *j->match);
    j->first = kn_scratch(ctx, room, sizeof *j->first);
    j->second = kn_scratch(ctx, room, sizeof *j->second);
    if (!j->out->seams || !j->match || !j->first || !j->second) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (int e = 0; status == KN_OK && e < j->cad->nedges; e++) {
        const kn_cad_edge *edge = &j->cad->edges[e];
        if (!is_seam(j, edge)) continue;
        int k = j->out->nseams;
        kn_cad_match *m = &j->match[k];
        status = kn_cad_match_edge(ctx, m, j->cad, e, &j->o);
        if (status != KN_OK) break;
        j->first[k] = place_of(j, edge->face[0]), j->second[k] = place_of(j, edge->face[1]);
        j->out->seams[j->out->nseams++] = (kn_cad_seam){
            .edge = e, .face = {edge->face[0], edge->face[1]}, .joined = !m->why, .why = m->why, .angle = m->angle};
    }
    return status;
}

static void unite_seams(joining *j)
{
    for (int k = 0; k < j->out->nseams; k++) {
        kn_cad_match *m = &j->match[k];
        kn_cad_seam *seam = &j->out->seams[k];
        if (!seam->joined) continue;
        int a = 2 * j->first[k] + 1 - m->side[0] / 2, b = 2 * j->second[k] + 1 - m->side[1] / 2;
        if (!unite(j, a, b, m->reversed)) {
            seam->joined = false, seam->why = "turned round";
            continue;
        }
        for (int end = 0; end < 2; end++) {
            int x = corner_root(j, corner_of(j->first[k], m->side[0], end));
            int y = corner_root(j, corner_of(j->second[k], m->side[1], m->reversed ? 1 - end : end));
            j->corner[x > y ? x : y] = x > y ? y : x;
        }
    }
    for (int d = 0; d < 2 * j->n; d++) { // parents come first: from now on every parent is a root
        int parent = j->parent[d];
        if (parent == d) continue;
        j->turned[d] ^= j->turned[parent];
        j->parent[d] = j->parent[parent];
    }
}

// ---- turns ----

// A face with all that is known of its sides: (u,v) -> (1 - v, u).
static kn_status turn_face(kn_ctx *ctx, joining *j, int face)
{
    static const int next[4] = {2, 3, 1, 0};
    kn_spline *s = &j->out->surfaces[face];
    kn_trim *trim = &j->out->trims[face];
    j->out->turns[face] = (j->out->turns[face] + 1) % 4;
    kn_status status = kn_spline_permute(ctx, s, s, (const int[]){1, 0});
    if (status == KN_OK) status = kn_spline_reverse(ctx, s, s, 0);
    for (int i = 0; i < trim->ncurves; i++) {
        int n = trim->curves[i].count[0];
        for (int k = 0; k < n; k++) {
            double *x = trim->curves[i].coef, u = x[k];
            x[k] = 1.0 - x[n + k];
            x[n + k] = u;
        }
    }
    for (int k = 0; k < j->out->nseams; k++)
        for (int i = 0; i < 2; i++) {
            if ((i == 0 ? j->first : j->second)[k] != face) continue;
            int *side = &j->match[k].side[i];
            if (*side < 2) j->match[k].reversed ^= true; // they run along v, and then against u
            *side = next[*side];
        }
    return status;
}

// Turns the face at the other end of a joined side until that lies opposite.
static kn_status turn_next(kn_ctx *ctx, joining *j, int seam, bool *done)
{
    int a = j->first[seam], b = j->second[seam], from = done[a] ? 0 : 1, to = done[a] ? b : a;
    const kn_cad_match *m = &j->match[seam];
    kn_status status = KN_OK;
    while (status == KN_OK && m->side[1 - from] != (m->side[from] ^ 1)) status = turn_face(ctx, j, to);
    done[to] = true;
    return status;
}

static kn_status turn_faces(kn_ctx *ctx, joining *j)
{
    bool *done = kn_scratch(ctx, (size_t)j->n, sizeof *done);
    kn_status status = done ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < j->n; i++) done[i] = false;
    for (int first = 0; status == KN_OK && first < j->n; first++) {
        if (done[first]) continue;
        done[first] = true;
        for (bool more = true; more && status == KN_OK;) {
            more = false;
            for (int k = 0; k < j->out->nseams && status == KN_OK; k++) {
                if (!j->out->seams[k].joined || done[j->first[k]] == done[j->second[k]]) continue;
                more = true;
                status = turn_next(ctx, j, k, done);
            }
        }
    }
    return status;
}

// ---- knots of a class ----

// Whether the direction has a joined side along it.
static bool is_joined(const joining *j, int direction)
{
    for (int k = 0; k < j->out->nseams; k++)
        for (int i = 0; i < 2; i++)
            if (j->out->seams[k].joined &&
                2 * (i == 0 ? j->first : j->second)[k] + 1 - j->match[k].side[i] / 2 == direction)
                return true;
    return false;
}

// A knot in [0,1] as the class has it; one that is new is kept.
static double take_knot(double *known, int *n, double t)
{
    for (int i = 0; i < *n; i++)
        if (fabs(known[i] - t) <= KN_CAD_SAME) return known[i];
    return known[(*n)++] = rint(t * 0x1p53) * 0x1p-53;
}

// The knots of one direction become those of the class, where they have near ones.
static void snap_knots(kn_spline *s, int var, bool turned, double *known, int *n)
{
    int m = s->count[var] + s->degree[var] + 1, p = s->degree[var];
    for (int i = p + 1; i < m - p - 1; i++) {
        double t = turned ? 1.0 - s->knots[var][i] : s->knots[var][i];
        double at = take_knot(known, n, t);
        s->knots[var][i] = turned ? 1.0 - at : at;
    }
}

// A curve with the knots and degree of one direction, as its class runs.
static kn_status direction_curve(kn_ctx *ctx, kn_spline *out, const kn_spline *s, int var, bool turned)
{
    kn_status status = kn_cad_side_curve(ctx, out, s, var == 0 ? 2 : 0);
    return status == KN_OK && turned ? kn_spline_reverse(ctx, out, out, 0) : status;
}

static kn_status raise(kn_ctx *ctx, kn_spline *s, int var, bool turned, const kn_spline *like)
{
    int degree[2] = {s->degree[0], s->degree[1]}, n[2] = {0, 0};
    const double *knots[2] = {NULL, NULL};
    kn_spline run = {0};
    degree[var] = like->degree[0];
    kn_status status = kn_spline_copy(ctx, &run, like);
    if (status == KN_OK && turned) status = kn_spline_reverse(ctx, &run, &run, 0);
    if (status == KN_OK) status = kn_spline_elevate(ctx, s, s, degree);
    if (status == KN_OK) {
        n[var] = run.count[0] + run.degree[0] + 1;
        knots[var] = run.knots[0];
        status = kn_spline_refine(ctx, s, s, n, knots);
    }
    kn_spline_clear(ctx, &run);
    return status;
}

static kn_status make_alike(kn_ctx *ctx, joining *j, int class)
{
    int directions = 2 * j->n, members = 0, known = 0;
    size_t room = 0;
    kn_mark mark = kn_scratch_mark(ctx);
    int *member = kn_scratch(ctx, (size_t)directions, sizeof *member);
    bool *turned = kn_scratch(ctx, (size_t)directions, sizeof *turned);
    kn_status status = member && turned ? KN_OK : KN_ENOMEM;
    for (int d = 0; status == KN_OK && d < directions; d++) {
        bool t;
        if (root_of(j, d, &t) != class || !is_joined(j, d)) continue;
        kn_spline *s = &j->out->surfaces[d / 2];
        room += (size_t)s->count[d % 2];
        member[members] = d, turned[members++] = t;
        status = kn_spline_reparameterize(ctx, s, s, d % 2, 0.0, 1.0);
    }
    double *knots = kn_scratch(ctx, room + 1, sizeof *knots);
    kn_spline *curves = kn_alloc_zero(ctx, (size_t)members + 1, sizeof *curves);
    if (status == KN_OK && (!knots || !curves)) status = KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < members; i++) {
        kn_spline *s = &j->out->surfaces[member[i] / 2];
        snap_knots(s, member[i] % 2, turned[i], knots, &known);
        status = kn_spline_check(ctx, s);
        if (status == KN_OK) status = direction_curve(ctx, &curves[i], s, member[i] % 2, turned[i]);
    }
    if (status == KN_OK) status = kn_spline_make_compatible(ctx, curves, members);
    for (int i = 0; status == KN_OK && i < members; i++)
        status = raise(ctx, &j->out->surfaces[member[i] / 2], member[i] % 2, turned[i], &curves[0]);
    for (int i = 0; curves && i < members; i++) kn_spline_clear(ctx, &curves[i]);
    kn_free(ctx, curves);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- weights ----

static kn_status make_rational(kn_ctx *ctx, kn_spline *s)
{
    kn_spline out = {0};
    if (s->rational) return KN_OK;
    size_t n = kn_spline_count(s);
    kn_status status = kn_spline_init(ctx, &out, 2, 4, true, s->degree, s->count, (const double *const *)s->knots,
                                      NULL);
    if (status != KN_OK) return status;
    memcpy(out.coef, s->coef, 3 * n * sizeof *out.coef);
    for (size_t i = 0; i < n; i++) out.coef[3 * n + i] = 1.0;
    kn_spline_swap(s, &out);
    kn_spline_clear(ctx, &out);
    return KN_OK;
}

static size_t row_point(const kn_spline *s, int side, int i)
{
    int at[2];
    at[side / 2] = side % 2 == 0 ? 0 : s->count[side / 2] - 1;
    at[1 - side / 2] = i;
    return (size_t)at[0] * (size_t)s->count[1] + (size_t)at[1];
}

// From one surface over its seams to the next: the weights of both become comparable.
static kn_status scale_weights(kn_ctx *ctx, joining *j)
{
    bool *done = kn_scratch(ctx, (size_t)j->n, sizeof *done);
    if (!done) return KN_ENOMEM;
    memset(done, 0, (size_t)j->n * sizeof *done);
    for (int seed = 0; seed < j->n; seed++) {
        if (done[seed]) continue;
        done[seed] = true;
        for (bool more = true; more;) {
            more = false;
            for (int k = 0; k < j->out->nseams; k++) {
                int a = j->first[k], b = j->second[k];
                if (!j->out->seams[k].joined || done[a] == done[b]) continue;
                int from = done[a] ? 0 : 1, to = done[a] ? b : a;
                kn_spline *x = &j->out->surfaces[done[a] ? a : b], *y = &j->out->surfaces[to];
                size_t n = kn_spline_count(x), m = kn_spline_count(y);
                int last = y->count[1 - j->match[k].side[1 - from] / 2] - 1;
                done[to] = more = true;
                if (!x->rational || !y->rational) continue;
                double factor =
                    x->coef[3 * n + row_point(x, j->match[k].side[from], 0)] /
                    y->coef[3 * m + row_point(y, j->match[k].side[1 - from], j->match[k].reversed ? last : 0)];
                for (size_t i = 0; i < 4 * m && factor != 1.0; i++) y->coef[i] *= factor;
            }
        }
    }
    return KN_OK;
}

// All or none of the surfaces that are joined, one by one or over others, are rational.
static kn_status share_kind(kn_ctx *ctx, joining *j)
{
    kn_status status = KN_OK;
    for (bool more = true; more && status == KN_OK;) {
        more = false;
        for (int k = 0; k < j->out->nseams && status == KN_OK; k++) {
            kn_spline *a = &j->out->surfaces[j->first[k]], *b = &j->out->surfaces[j->second[k]];
            if (!j->out->seams[k].joined || a->rational == b->rational) continue;
            more = true;
            status = make_rational(ctx, a->rational ? b : a);
        }
    }
    return status;
}

// ---- control points ----

// Of the projected control point, and what weights that differ do over the whole surface.
static double move_point(kn_spline *to, size_t i, const double *p, double size)
{
    size_t n = kn_spline_count(to);
    double w = to->rational ? to->coef[3 * n + i] : 1.0, v = to->rational ? p[3] : 1.0, square = 0.0;
    for (size_t c = 0; c < 3; c++) {
        double d = to->coef[c * n + i] / w - p[c] / v;
        square += d * d;
    }
    for (size_t c = 0; c < (size_t)to->ncomp; c++) to->coef[c * n + i] = p[c];
    return (sqrt(square) + 4.0 * fabs(v / w - 1.0) * size) * (1.0 + 1e-12);
}

static void take_point(double p[4], const kn_spline *s, size_t i)
{
    size_t n = kn_spline_count(s);
    for (size_t c = 0; c < (size_t)s->ncomp; c++) p[c] = s->coef[c * n + i];
}

static kn_status measure(kn_ctx *ctx, double *size, const kn_spline *s)
{
    double lo[3], hi[3];
    kn_status status = kn_spline_box(ctx, lo, hi, s);
    *size = 0.0;
    for (int c = 0; c < 3 && status == KN_OK; c++) *size = fmax(*size, hi[c] - lo[c]);
    *size *= 2.0;
    return status;
}

// Corners first, then the sides between them. A move of a corner counts for the seams that have it.
static kn_status move_points(kn_ctx *ctx, joining *j)
{
    double *moved = kn_scratch(ctx, 4 * (size_t)j->n, sizeof *moved),
           *size = kn_scratch(ctx, (size_t)j->n, sizeof *size);
    if (!moved || !size) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (int f = 0; f < j->n && status == KN_OK; f++) status = measure(ctx, &size[f], &j->out->surfaces[f]);
    for (int c = 0; c < 4 * j->n && status == KN_OK; c++) {
        int root = corner_root(j, c);
        kn_spline *s = &j->out->surfaces[c / 4];
        const kn_spline *from = &j->out->surfaces[root / 4];
        double p[4];
        moved[c] = 0.0;
        if (root == c) continue;
        take_point(p, from, row_point(from, (root & 2) >> 1, (root & 1) * (from->count[1] - 1)));
        moved[c] = move_point(s, row_point(s, (c & 2) >> 1, (c & 1) * (s->count[1] - 1)), p, size[c / 4]);
    }
    for (int k = 0; k < j->out->nseams && status == KN_OK; k++) {
        kn_cad_seam *seam = &j->out->seams[k];
        if (!seam->joined) continue;
        const kn_cad_match *m = &j->match[k];
        const kn_spline *from = &j->out->surfaces[j->first[k]];
        kn_spline *to = &j->out->surfaces[j->second[k]];
        int n = from->count[1 - m->side[0] / 2];
        for (int i = 0; i < n; i++) {
            double p[4];
            take_point(p, from, row_point(from, m->side[0], i));
            size_t at = row_point(to, m->side[1], m->reversed ? n - 1 - i : i);
            seam->moved = fmax(seam->moved, move_point(to, at, p, size[j->second[k]]));
        }
        for (int end = 0; end < 2; end++) {
            seam->moved = fmax(seam->moved, moved[corner_of(j->first[k], m->side[0], end)]);
            seam->moved = fmax(seam->moved, moved[corner_of(j->second[k], m->side[1], end)]);
        }
        j->out->moved = fmax(j->out->moved, seam->moved);
    }
    return status;
}

// ---- the whole ----

static kn_status begin(kn_ctx *ctx, joining *j)
{
    size_t n = (size_t)j->n;
    j->out->surfaces = kn_alloc_zero(ctx, n, sizeof *j->out->surfaces);
    j->out->trims = kn_alloc_zero(ctx, n, sizeof *j->out->trims);
    j->parent = kn_scratch(ctx, 2 * n, sizeof *j->parent);
    j->turned = kn_scratch(ctx, 2 * n, sizeof *j->turned);
    j->corner = kn_scratch(ctx, 4 * n, sizeof *j->corner);
    j->out->turns = kn_alloc_zero(ctx, n, sizeof *j->out->turns);
    if (!j->out->surfaces || !j->out->trims || !j->out->turns || !j->parent || !j->turned || !j->corner)
        return KN_ENOMEM;
    j->out->n = j->n;
    for (int d = 0; d < 2 * j->n; d++) j->parent[d] = d, j->turned[d] = false;
    for (int c = 0; c < 4 * j->n; c++) j->corner[c] = c;
    kn_status status = KN_OK;
    for (int i = 0; i < j->n && status == KN_OK; i++) {
        const kn_cad_face *f = &j->cad->faces[j->faces[i]];
        status = kn_spline_copy(ctx, &j->out->surfaces[i], &f->surface);
        if (status == KN_OK && !f->whole) status = kn_trim_copy(ctx, &j->out->trims[i], &f->trim);
    }
    return status;
}

static kn_status check(kn_ctx *ctx, const kn_cad *cad, const int *faces, int n, const kn_cad_join_options *o)
{
    if (n < 1) return kn_fail(ctx, KN_EDOMAIN, "cad: %d faces to join", n);
    for (int i = 0; i < n; i++) {
        if (faces[i] < 0 || faces[i] >= cad->nfaces)
            return kn_fail(ctx, KN_EDOMAIN, "cad: no face %d among %d", faces[i], cad->nfaces);
        for (int k = 0; k < i; k++)
            if (faces[k] == faces[i]) return kn_fail(ctx, KN_EDOMAIN, "cad: face %d is named twice", faces[i]);
    }
    if (!(o->angle >= 0.0 && o->angle <= 3.2) || !(o->tolerance >= 0.0) || isinf(o->tolerance))
        return kn_fail(ctx, KN_EDOMAIN, "cad: joining within %g radians and %g mm", o->angle, o->tolerance);
    return KN_OK;
}

kn_status kn_cad_join(kn_ctx *ctx, kn_cad_joined *out, const kn_cad *cad, const int *faces, int n,
                      const kn_cad_join_options *options)
{
    kn_cad_joined made = {0};
    joining j = {.cad = cad, .faces = faces, .n = n, .out = &made};
    if (options) j.o = *options;
    kn_status status = check(ctx, cad, faces, n, &j.o);
    if (status != KN_OK) return status;
    if (j.o.angle == 0.0) j.o.angle = 0.017453292519943295;
    if (j.o.tolerance == 0.0) j.o.tolerance = 1e-3;
    kn_mark mark = kn_scratch_mark(ctx);
    status = begin(ctx, &j);
    if (status == KN_OK) status = find_seams(ctx, &j);
    if (status == KN_OK) status = turn_faces(ctx, &j);
    if (status == KN_OK) unite_seams(&j);
    for (int d = 0; status == KN_OK && d < 2 * n; d++)
        if (j.parent[d] == d) status = make_alike(ctx, &j, d);
    if (status == KN_OK) status = share_kind(ctx, &j);
    if (status == KN_OK) status = scale_weights(ctx, &j);
    if (status == KN_OK) status = move_points(ctx, &j);
    kn_scratch_release(ctx, mark);
    if (status == KN_OK) {
        kn_cad_joined_clear(ctx, out);
        *out = made;
    } else {
        kn_cad_joined_clear(ctx, &made);
    }
    return status;
}

void kn_cad_joined_clear(kn_ctx *ctx, kn_cad_joined *joined)
{
    if (!joined) return;
    for (int i = 0; i < joined->n; i++) {
        kn_spline_clear(ctx, &joined->surfaces[i]);
        kn_trim_clear(ctx, &joined->trims[i]);
    }
    kn_free(ctx, joined->surfaces);
    kn_free(ctx, joined->trims);
    kn_free(ctx, joined->turns);
    kn_free(ctx, joined->seams);
    *joined = (kn_cad_joined){0};
}
