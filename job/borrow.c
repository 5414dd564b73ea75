// SPDX-License-Identifier: Apache-2.0
// Edges that surfaces share: what is composed along them has one degree and the same control points, bit for bit.
//
// Two surfaces that go on over an edge have the same curve there, and the same normals, but for rounding: their cells
// lie in other parameters, perhaps backwards, and N comes from other derivatives. So the one of lower number lends its
// coefficients along the edge, term by term, to the other; and of all surfaces that meet in a corner, one lends that.
#include "job/internal.h"
#include "kernel/union_find.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double near = 1e-11;          // what lent coefficients may differ by: relative to S's size, and to n
static const size_t most_meeting = 200000; // patches of a family that interpolates: a minute or so

// n is one polynomial over every cell, or there is none but what S has as knots.
static bool has_whole_cells(const kn_job_surface *s)
{
    const kn_spline *n = kn_shell_normal(s->shell);
    for (int v = 0; v < 2 && n->coef; v++)
        for (int k = n->degree[v] + 1, i = 0; k < n->count[v]; k++) {
            while (i < s->cells[v] && s->lines[v][i] < n->knots[v][k]) i++;
            if (s->lines[v][i] != n->knots[v][k]) return false;
        }
    return true;
}

// The surface goes on over the edge with its w the same way up, not into itself.
static bool may_share(const kn_job *job, int surface, int edge)
{
    const kn_job_surface *s = &job->surfaces[surface];
    const kn_job_partner *p = &s->partner[edge];
    if (p->edge < 0 || !p->goes_on || !p->single || kn_job_turns_over(edge, p) || s->closed[edge >> 1]) return false;
    const kn_job_surface *other = &job->surfaces[p->edge / 4];
    return kn_job_components(s) == kn_job_components(other) && has_whole_cells(s) && has_whole_cells(other);
}

// What n is across lines in variable v.
typedef enum smoothness {
    NO_LINES, // there are none
    JOINED,   // C1 or smoother across one of them, at least
    APART,    // C0 at most
} smoothness;

static smoothness smoothness_of(const kn_spline *n, int v)
{
    const double *t = n->knots[v];
    int p = n->degree[v];
    for (int i = p + 1, times; i < n->count[v]; i += times) {
        for (times = 1; t[i + times] == t[i]; times++) {
        }
        if (times < p) return JOINED;
    }
    return n->count[v] > p + 1 ? APART : NO_LINES;
}

kn_status kn_job_even_degrees(kn_ctx *ctx, kn_job_evened *of, bool *again, const kn_job *job)
{
    int n = 2 * job->nsurfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    int *class_of = kn_scratch(ctx, (size_t)n, sizeof *class_of), *most = kn_scratch(ctx, (size_t)n, sizeof *most);
    bool *apart = kn_scratch(ctx, (size_t)n, sizeof *apart);
    if (!class_of || !most || !apart) {
        kn_scratch_release(ctx, mark);
        return KN_ENOMEM;
    }
    *again = false;
    for (int i = 0; i < n; i++) class_of[i] = i, most[i] = 0, apart[i] = false;
    for (int s = 0; s < job->nsurfaces; s++)
        for (int e = 0; e < 4; e++) {
            int to = job->surfaces[s].partner[e].edge;
            if (may_share(job, s, e))
                kn_class_unite(class_of, 2 * s + 1 - (e >> 1), 2 * (to / 4) + 1 - (to % 4 >> 1));
        }
    for (int i = 0; i < n; i++) {
        const kn_spline *f = kn_shell_normal(job->surfaces[i / 2].shell);
        int r = kn_class_root(class_of, i);
        if (!f->coef) continue;
        most[r] = f->degree[i % 2] > most[r] ? f->degree[i % 2] : most[r];
        apart[r] = apart[r] || smoothness_of(f, i % 2) == APART;
    }
    for (int i = 0; i < n; i++) {
        int r = kn_class_root(class_of, i);
        const kn_spline *f = kn_shell_normal(job->surfaces[i / 2].shell),
                        *g = kn_shell_normal(job->surfaces[r / 2].shell);
        // of one degree, as many coefficients are as smooth across the cell lines
        bool same = !f->coef || (f->degree[i % 2] == most[r] && f->count[i % 2] == g->count[r % 2] &&
                                 !(apart[r] && smoothness_of(f, i % 2) == JOINED));
        for (int k = 0; k < n && !same; k++) {
            kn_job_evened *to = &of[k / 2];
            bool asked = to->least[k % 2] == most[r] && to->apart[k % 2] == apart[r];
            to->again = to->again || (kn_class_root(class_of, k) == r && !asked);
        }
    }
    for (int i = 0; i < n; i++) {
        of[i / 2].least[i % 2] = most[kn_class_root(class_of, i)];
        of[i / 2].apart[i % 2] = apart[kn_class_root(class_of, i)];
        *again = *again || of[i / 2].again;
    }
    kn_scratch_release(ctx, mark);
    return KN_OK;
}

// ---- surfaces whose patches interpolate ----

bool kn_job_meets(const kn_job *job, int surface, int edge)
{
    const kn_job_surface *s = &job->surfaces[surface];
    const kn_job_partner *p = &s->partner[edge];
    return p->edge >= 0 && p->goes_on && p->single && !kn_job_turns_over(edge, p) && !s->closed[edge >> 1];
}

static int corner_at(int surface, int edge, int end);

// The patches of all surfaces that hang together have to meet, where n is not one polynomial over each cell of one of
// them; but not where there are too many.
static void find_families(kn_job *job, int *family, size_t *patches, bool *torn)
{
    int n = job->nsurfaces;
    for (int s = 0; s < n; s++) family[s] = s, patches[s] = 0, torn[s] = false;
    for (int s = 0; s < n; s++)
        for (int e = 0; e < 4; e++)
            if (kn_job_meets(job, s, e)) kn_class_unite(family, s, job->surfaces[s].partner[e].edge / 4);
    for (int s = 0; s < n; s++) {
        const kn_job_surface *to = &job->surfaces[s];
        int r = kn_class_root(family, s);
        bool can = kn_shell_normal(to->shell)->coef;
        patches[r] += can ? (size_t)to->cells[0] * (size_t)to->cells[1] * (size_t)job->npatches : most_meeting + 1;
        torn[r] = torn[r] || !has_whole_cells(to);
    }
    for (int s = 0; s < n; s++) {
        int r = kn_class_root(family, s);
        job->surfaces[s].meets = torn[r] && patches[r] <= most_meeting;
    }
}

kn_status kn_job_find_meeting(kn_ctx *ctx, kn_job *job)
{
    size_t n = (size_t)job->nsurfaces;
    bool can = job->options.equal_edges && !(job->options.attraction && job->options.attraction_power == 1);
    for (int k = 0; k < job->npatches; k++) can = can && job->patches[k].d.nvars == 2;
    if (!can) return KN_OK;
    kn_mark mark = kn_scratch_mark(ctx);
    int *family = kn_scratch(ctx, n, sizeof *family), *corner = kn_scratch(ctx, 4 * n, sizeof *corner);
    size_t *patches = kn_scratch(ctx, n, sizeof *patches);
    bool *torn = kn_scratch(ctx, n, sizeof *torn);
    kn_status status = family && corner && patches && torn ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) find_families(job, family, patches, torn);
    for (int i = 0; i < 4 * (int)n && status == KN_OK; i++) corner[i] = i;
    for (int i = 0; i < 4 * (int)n && status == KN_OK; i++) {
        kn_job_surface *s = &job->surfaces[i / 4];
        kn_shell_edge edge[2][2];
        int e = i % 4;
        const kn_job_partner *p = &s->partner[e];
        kn_shell_edges(s->shell, edge);
        s->pole[e] = edge[e >> 1][e & 1].kind == KN_EDGE_POLE;
        if (s->pole[e]) kn_class_unite(corner, corner_at(i / 4, e, 0), corner_at(i / 4, e, 1));
        for (int end = 0; end < 2; end++) {
            int here = corner_at(i / 4, e, end);
            if (s->closed[e >> 1]) kn_class_unite(corner, here, corner_at(i / 4, e ^ 1, end));
            if (kn_job_meets(job, i / 4, e))
                kn_class_unite(corner, here, corner_at(p->edge / 4, p->edge % 4, p->reversed ? 1 - end : end));
        }
    }
    for (int i = 0; i < 4 * (int)n && status == KN_OK; i++)
        job->surfaces[i / 4].joint[i % 4] = kn_class_root(corner, i);
    kn_scratch_release(ctx, mark);
    return status == KN_OK ? kn_job_meeting_scale(ctx, &job->meeting_height, job) : status;
}

// ---- rows of coefficients ----

typedef struct row {
    size_t first;
    ptrdiff_t step;
    size_t count;
} row;

static row row_of(const kn_bezier *f, int edge, bool backward)
{
    size_t m = (size_t)f->degree[0] + 1, n = (size_t)f->degree[1] + 1;
    bool end = edge % 2 == 1;
    row r = edge < 2 ? (row){end ? (m - 1) * n : 0, 1, n} : (row){end ? n - 1 : 0, (ptrdiff_t)n, m};
    if (!backward) return r;
    r.first += (size_t)r.step * (r.count - 1);
    r.step = -r.step;
    return r;
}

static double largest(const kn_bezier *f)
{
    double most = 0.0;
    size_t n = (size_t)f->ncomp * kn_bezier_count(f);
    for (size_t i = 0; i < n; i++) most = fmax(most, fabs(f->coef[i]));
    return most;
}

// Lends the coefficients of a row, or only asks whether they are as near as they have to be.
static bool lend(kn_bezier *to, row into, const kn_bezier *from, row of, bool ask)
{
    if (into.count != of.count || to->ncomp != from->ncomp) return false;
    double *a = to->coef + into.first, slack = ask ? near * fmax(largest(to), largest(from)) : 0.0;
    const double *b = from->coef + of.first;
    for (size_t c = 0; c < (size_t)to->ncomp; c++, a += kn_bezier_count(to), b += kn_bezier_count(from))
        for (ptrdiff_t k = 0; k < (ptrdiff_t)into.count; k++) {
            if (ask && !(fabs(a[k * into.step] - b[k * of.step]) <= slack)) return false;
            if (!ask) a[k * into.step] = b[k * of.step];
        }
    return true;
}

static kn_status piece_of(kn_ctx *ctx, kn_shell_piece *out, bool *fits, const kn_job *job, int surface,
                          const int cell[2])
{
    static const double zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    const kn_job_surface *s = &job->surfaces[surface];
    kn_status status = kn_shell_piece_init(ctx, out, fits, s->shell, cell, zero, one, s->degree_sum);
    if (status == KN_OK && *fits && !out->exact) {
        kn_shell_piece_clear(ctx, out);
        *fits = false;
    }
    return status;
}

// The cell of a surface at a place along an edge.
static void cell_at(int cell[2], const kn_job_surface *s, int edge, int along)
{
    cell[edge >> 1] = edge % 2 == 1 ? s->cells[edge >> 1] - 1 : 0;
    cell[1 - (edge >> 1)] = along;
}

// Along edge `edge` of a surface to its piece of the cell there.
static kn_status lend_edge(kn_ctx *ctx, bool *done, const kn_job *job, int surface, int edge, int along,
                           kn_shell_piece *piece, bool ask)
{
    const kn_job_partner *p = &job->surfaces[surface].partner[edge];
    const kn_job_surface *other = &job->surfaces[p->edge / 4];
    int cell[2], f = p->edge % 4, n = other->cells[1 - (f >> 1)];
    kn_shell_piece from = {0};
    bool fits = false;
    cell_at(cell, other, f, p->reversed ? n - 1 - along : along);
    *done = false;
    kn_status status = piece_of(ctx, &from, &fits, job, p->edge / 4, cell);
    if (status != KN_OK || !fits) return status;
    *done = from.nterms == piece->nterms;
    for (int t = 0; t < piece->nterms && *done; t++)
        *done = from.power[t] == piece->power[t] && lend(&piece->term[t], row_of(&piece->term[t], edge, false),
                                                         &from.term[t], row_of(&from.term[t], f, p->reversed), ask);
    kn_shell_piece_clear(ctx, &from);
    return KN_OK;
}

// Corner k: bit 1 of it the end in u, bit 0 that in v.
static row corner_of(const kn_bezier *f, int k)
{
    size_t n = (size_t)f->degree[1] + 1;
    return (row){(k & 2 ? (size_t)f->degree[0] * n : 0) + (k & 1 ? n - 1 : 0), 1, 1};
}

static kn_status lend_corner(kn_ctx *ctx, const kn_job *job, int surface, int k, kn_shell_piece *piece)
{
    int lender = job->surfaces[surface].corner[k];
    if (lender < 0) return KN_OK;
    const kn_job_surface *other = &job->surfaces[lender / 4];
    const int cell[2] = {lender & 2 ? other->cells[0] - 1 : 0, lender & 1 ? other->cells[1] - 1 : 0};
    kn_shell_piece from = {0};
    bool fits = false;
    kn_status status = piece_of(ctx, &from, &fits, job, lender / 4, cell);
    if (status != KN_OK || !fits) return status;
    bool good = from.nterms == piece->nterms;
    for (int ask = 1; ask >= 0; ask--)
        for (int t = 0; t < piece->nterms && good; t++)
            good = lend(&piece->term[t], corner_of(&piece->term[t], k), &from.term[t],
                        corner_of(&from.term[t], lender % 4), ask == 1);
    kn_shell_piece_clear(ctx, &from);
    return KN_OK;
}

// ---- who lends ----

// Whether all cells along the edge can borrow from the other side.
static kn_status can_borrow(kn_ctx *ctx, bool *yes, const kn_job *job, int surface, int edge)
{
    const kn_job_surface *s = &job->surfaces[surface];
    kn_status status = KN_OK;
    *yes = true;
    for (int i = 0; i < s->cells[1 - (edge >> 1)] && *yes && status == KN_OK; i++) {
        kn_shell_piece piece = {0};
        int cell[2];
        cell_at(cell, s, edge, i);
        status = piece_of(ctx, &piece, yes, job, surface, cell);
        if (status == KN_OK && *yes) status = lend_edge(ctx, yes, job, surface, edge, i, &piece, true);
        kn_shell_piece_clear(ctx, &piece);
    }
    return status;
}

// The corner of a surface at the lower (0) or upper end of an edge.
static int corner_at(int surface, int edge, int end)
{
    return 4 * surface + (edge < 2 ? 2 * (edge % 2) + end : 2 * end + edge % 2);
}

// A term of a piece over a whole cell of a surface, and the family of the surface.
typedef struct member {
    int family;
    kn_job_term term;
} member;

static int compare_members(const void *a, const void *b)
{
    const member *x = a, *y = b;
    if (x->family != y->family) return x->family < y->family ? -1 : 1;
    return memcmp(&x->term, &y->term, sizeof x->term);
}

// Appends the terms of a surface, where it has whole cells.
static kn_status add_members(kn_ctx *ctx, member *list, size_t *n, const kn_job_surface *s, int family)
{
    static const double zero[2] = {0.0, 0.0}, one[2] = {1.0, 1.0};
    static const int cell[2] = {0, 0};
    kn_shell_piece p = {0};
    bool fits = false;
    if (!has_whole_cells(s)) return KN_OK;
    kn_status status = kn_shell_piece_outline(ctx, &p, &fits, s->shell, cell, zero, one, s->degree_sum);
    if (status != KN_OK || !fits) return status;
    for (int t = 0; t < p.nterms; t++) {
        const int *degree = p.term[t].degree;
        list[(*n)++] = (member){family, {{(uint8_t)degree[0], (uint8_t)degree[1]}, (uint8_t)p.power[t]}};
    }
    kn_shell_piece_clear(ctx, &p);
    return KN_OK;
}

// The patches of a family compose for the terms that any of its surfaces has: job->terms, and where each surface finds
// its family's.
static kn_status set_families(kn_ctx *ctx, kn_job *job, int *family)
{
    size_t n = 0, kept = 0, most = KN_SHELL_TERMS * (size_t)job->nsurfaces;
    member *list = kn_alloc(ctx, most, sizeof *list);
    kn_status status = list ? KN_OK : KN_ENOMEM;
    for (int s = 0; s < job->nsurfaces && status == KN_OK; s++)
        status = add_members(ctx, list, &n, &job->surfaces[s], kn_class_root(family, s));
    if (status == KN_OK && !(job->terms = kn_alloc(ctx, n + 1, sizeof *job->terms))) status = KN_ENOMEM;
    if (status == KN_OK) qsort(list, n, sizeof *list, compare_members);
    for (size_t i = 0; i < n && status == KN_OK; i++) {
        kn_job_surface *root = &job->surfaces[list[i].family];
        if (i > 0 && compare_members(&list[i - 1], &list[i]) == 0) continue;
        if (root->nterms++ == 0) root->first_term = kept;
        job->terms[kept++] = list[i].term;
    }
    for (int s = job->nsurfaces - 1; s >= 0 && status == KN_OK; s--) { // a root comes before the others
        const kn_job_surface *root = &job->surfaces[kn_class_root(family, s)];
        job->surfaces[s].first_term = root->first_term;
        job->surfaces[s].nterms = has_whole_cells(&job->surfaces[s]) ? root->nterms : 0;
    }
    kn_free(ctx, list);
    return status;
}

kn_status kn_job_share_edges(kn_ctx *ctx, kn_job *job)
{
    int n = job->nsurfaces;
    kn_mark mark = kn_scratch_mark(ctx);
    int *family = kn_scratch(ctx, (size_t)n, sizeof *family),
        *corner = kn_scratch(ctx, 4 * (size_t)n, sizeof *corner);
    kn_status status = family && corner ? KN_OK : KN_ENOMEM;
    for (int i = 0; status == KN_OK && i < 4 * n; i++) family[i / 4] = i / 4, corner[i] = i;
    for (int s = 0; s < n && status == KN_OK; s++)
        for (int e = 0; e < 4 && status == KN_OK; e++) {
            kn_job_surface *to = &job->surfaces[s];
            const kn_job_partner *p = &to->partner[e];
            if (p->edge >= 4 * s + e || !may_share(job, s, e)) continue;
            status = can_borrow(ctx, &to->borrows[e], job, s, e);
            if (status != KN_OK || !to->borrows[e]) continue;
            kn_class_unite(family, s, p->edge / 4);
            for (int end = 0; end < 2; end++)
                kn_class_unite(corner, corner_at(s, e, end),
                               corner_at(p->edge / 4, p->edge % 4, p->reversed ? 1 - end : end));
        }
    for (int s = 0; s < n && status == KN_OK; s++)
        for (int v = 0; v < 2; v++)
            for (int end = 0; end < 2 && job->surfaces[s].closed[v]; end++)
                kn_class_unite(corner, corner_at(s, 2 * v, end), corner_at(s, 2 * v + 1, end));
    for (int i = 0; i < 4 * n && status == KN_OK; i++)
        job->surfaces[i / 4].corner[i % 4] = kn_class_root(corner, i) == i ? -1 : kn_class_root(corner, i);
    if (status == KN_OK) status = set_families(ctx, job, family);
    kn_scratch_release(ctx, mark);
    return status;
}

// ---- to the pieces of a cell ----

// Which edges and corners of the surface the cell lies at; false: none at which it borrows.
static bool find_ends(bool edge[4], bool corner[4], const kn_job_surface *s, const int cell[2])
{
    bool any = false;
    for (int e = 0; e < 4; e++) edge[e] = cell[e >> 1] == (e % 2 == 1 ? s->cells[e >> 1] - 1 : 0);
    for (int k = 0; k < 4; k++) {
        corner[k] = edge[k >> 1] && edge[2 + (k & 1)] && s->corner[k] >= 0;
        any = any || corner[k];
    }
    for (int e = 0; e < 4; e++) {
        edge[e] = edge[e] && s->borrows[e];
        any = any || edge[e];
    }
    return any;
}

static void inside(int out[2], const kn_job_surface *s, const int cell[2])
{
    for (int v = 0; v < 2; v++) {
        int n = s->cells[v];
        out[v] = s->closed[v] ? (cell[v] % n + n) % n : cell[v];
    }
}

bool kn_job_borrows(const kn_job *job, int surface, const int cell[2])
{
    bool edge[4], corner[4];
    int at[2];
    inside(at, &job->surfaces[surface], cell);
    return find_ends(edge, corner, &job->surfaces[surface], at);
}

kn_status kn_job_borrow(kn_ctx *ctx, const kn_job *job, int surface, const int cell[2], kn_shell_piece *piece)
{
    const kn_job_surface *s = &job->surfaces[surface];
    bool edge[4], corner[4], done;
    int at[2];
    kn_status status = KN_OK;
    inside(at, s, cell);
    if (!piece->exact || !piece->term[0].coef || !find_ends(edge, corner, s, at)) return KN_OK;
    for (int e = 0; e < 4 && status == KN_OK; e++)
        if (edge[e]) status = lend_edge(ctx, &done, job, surface, e, at[1 - (e >> 1)], piece, false);
    for (int k = 0; k < 4 && status == KN_OK; k++)
        if (corner[k]) status = lend_corner(ctx, job, surface, k, piece);
    return status;
}
