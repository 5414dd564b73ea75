// SPDX-License-Identifier: Apache-2.0
// MFEM NURBS meshes: how patches meet, which is known at the end, and then each patch with its knots and control points,
// which until then are in a file of their own.
// Source: mfem.org, "Mesh formats", MFEM NURBS mesh v1.0, with a "patches" section.
#include "write/mfem.h"
#include "write/text_sink.h"

#include "kernel/context.h"

#include <string.h>

typedef struct mfem {
    kn_out_file *file, *patches;
    kn_mfem_cell *cells;
    size_t n, room;
    int nvars, nlooks; // nvars 0: no patch yet
} mfem;

typedef struct written {
    kn_text text;
    kn_mfem_cell *cells;
    int *nvars;
    size_t n;
} written;

static const kn_write_format format = {.name = "MFEM", .holds = KN_WRITE_SURFACES | KN_WRITE_VOLUMES};

// ---- one patch ----

static uint64_t mix(uint64_t x) // the finaliser of SplitMix64
{
    x = (x ^ x >> 30) * UINT64_C(0xbf58476d1ce4e5b9);
    x = (x ^ x >> 27) * UINT64_C(0x94d049bb133111eb);
    return x ^ x >> 31;
}

static uint64_t mix_double(uint64_t h, double x)
{
    uint64_t bits;
    double y = x + 0.0; // one zero
    memcpy(&bits, &y, sizeof y);
    return mix(h + bits + UINT64_C(0x9e3779b97f4a7c15));
}

static uint64_t hash_point(const kn_spline *s, size_t n, size_t at)
{
    uint64_t h = 0;
    for (size_t c = 0; c < 3; c++) h = mix_double(h, s->coef[c * n + at]);
    return mix_double(h, s->rational ? s->coef[3 * n + at] : 1.0);
}

static void hash_knots(uint64_t out[2], const kn_spline *s, int d)
{
    int last = s->count[d] + s->degree[d];
    const double *t = s->knots[d];
    out[0] = out[1] = (uint64_t)s->degree[d] + 1;
    for (int i = 0; i <= last; i++) {
        out[0] = mix_double(out[0], t[i]);
        out[1] = mix_double(out[1], t[0] + (t[last] - t[last - i]));
    }
    for (int k = 0; k < 2; k++)
        if (out[k] == 0) out[k] = 1; // 0: not known
}

// Whether control point `index` lies where variables end as corners a and b (the same one, or both of an edge) say.
static bool lies_on(const kn_spline *s, const size_t index[3], const int *corners, int n)
{
    static const int place[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    for (int d = 0; d < s->nvars; d++) {
        bool all = true;
        for (int k = 1; k < n; k++) all = all && place[corners[k]][d] == place[corners[0]][d];
        size_t end = place[corners[0]][d] ? (size_t)s->count[d] - 1 : 0;
        if (all && index[d] != end) return false;
    }
    return true;
}

static void look_at(kn_mfem_cell *cell, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    int corners = s->nvars == 2 ? 4 : 8, edges = s->nvars == 2 ? KN_MFEM_SQUARE_EDGES : KN_MFEM_CUBE_EDGES, var, end;
    for (int d = 0; d < s->nvars; d++) hash_knots(cell->knots[d], s, d);
    for (size_t k = 0; k < n; k++) {
        size_t index[3] = {0, 0, 0}, rest = k, at = kn_write_place(s, k);
        for (int d = 0; d < s->nvars; rest /= (size_t)s->count[d++]) index[d] = rest % (size_t)s->count[d];
        uint64_t hash = hash_point(s, n, at);
        for (int v = 0; v < corners; v++)
            for (size_t c = 0; lies_on(s, index, &v, 1) && c < 3; c++)
                cell->corner[v][c] = s->coef[c * n + at] / (s->rational ? s->coef[3 * n + at] : 1.0);
        for (int e = 0; e < edges; e++) {
            int ends[2];
            kn_mfem_edge(e, ends, &var);
            if (lies_on(s, index, ends, 2)) cell->edge[e] += hash;
        }
        for (int f = 0; s->nvars == 3 && f < KN_MFEM_CUBE_FACES; f++) {
            int around[4];
            kn_mfem_face(f, around, &var, &end);
            if (lies_on(s, index, around, 4)) cell->face[f] += hash;
        }
    }
}

// Corners as the ends of edges have to be two vertices, which is known at once.
static bool has_closed_edge(const kn_mfem_cell *cell, int nvars)
{
    for (int e = 0; e < (nvars == 2 ? KN_MFEM_SQUARE_EDGES : KN_MFEM_CUBE_EDGES); e++) {
        int k[2], var;
        kn_mfem_edge(e, k, &var);
        const double *a = cell->corner[k[0]], *b = cell->corner[k[1]];
        if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) return true;
    }
    return false;
}

// Degree, number of control points and knots of each variable; then control points, homogeneous, the first variable
// fastest.
static void put_patch(kn_text *text, const kn_spline *s)
{
    size_t n = kn_spline_count(s);
    kn_text_put(text, "\nknotvectors\n");
    kn_text_integer(text, (uint64_t)s->nvars);
    kn_text_newline(text);
    for (int d = 0; d < s->nvars; d++) {
        kn_text_integer(text, (uint64_t)s->degree[d]);
        kn_text_char(text, ' ');
        kn_text_integer(text, (uint64_t)s->count[d]);
        for (int i = 0; i <= s->count[d] + s->degree[d]; i++) kn_write_real(text, s->knots[d][i]);
        kn_text_newline(text);
    }
    kn_text_put(text, "\ndimension\n3\n\ncontrolpoints\n");
    for (size_t k = 0; k < n; k++) {
        size_t at = kn_write_place(s, k);
        for (size_t c = 0; c < 4; c++) {
            if (c > 0) kn_text_char(text, ' ');
            kn_text_plain_real(text, c < 3 || s->rational ? s->coef[c * n + at] : 1.0, 17);
        }
        kn_text_newline(text);
    }
}

// ---- the sink ----

// A piece of the tile as a cell; its edges are looked at, and not compared.
static kn_status add_piece(kn_ctx *ctx, mfem *m, const kn_bezier *piece, int part, int patch)
{
    kn_spline s = {0};
    kn_status status = kn_spline_of_bezier(ctx, &s, piece);
    if (status == KN_OK && m->n == m->room) {
        size_t room = 2 * m->room + 16;
        kn_mfem_cell *larger = kn_resize(ctx, m->cells, room, sizeof *larger);
        if (larger) m->cells = larger, m->room = room;
        if (!larger) status = KN_ENOMEM;
    }
    if (status == KN_OK) {
        kn_mfem_cell *cell = &m->cells[m->n++];
        *cell = (kn_mfem_cell){.id = {.part = part, .patch = patch}};
        look_at(cell, &s);
        memset(cell->edge, 0, sizeof cell->edge), memset(cell->face, 0, sizeof cell->face);
        if (has_closed_edge(cell, s.nvars))
            status = kn_write_refuse(ctx, format.name, &cell->id, "has an edge that is closed or a point");
    }
    kn_spline_clear(ctx, &s);
    return status;
}

// What is wrong with the tile is so with each of its copies: it is said before anything is composed. The sink's cells
// hold its pieces meanwhile.
static kn_status check_tile(kn_ctx *ctx, mfem *m, const kn_tile *tile, int nvars)
{
    kn_status status = KN_OK;
    for (int p = 0; p < tile->nparts; p++)
        for (int i = 0, patch = 0; status == KN_OK && i < tile->parts[p].nsplines; i++) {
            const kn_spline *s = &tile->parts[p].splines[i];
            kn_bezier *pieces = NULL;
            size_t n = 0;
            if (s->nvars == nvars && kn_spline_dim(s) == 3) status = kn_spline_to_bezier(ctx, &pieces, &n, s);
            for (size_t k = 0; k < n; k++) {
                if (status == KN_OK) status = add_piece(ctx, m, &pieces[k], p, patch++);
                kn_bezier_clear(ctx, &pieces[k]);
            }
            kn_free(ctx, pieces);
        }
    if (status == KN_OK && m->n > 0) status = kn_mfem_check_edges(ctx, m->cells, m->n, nvars);
    m->n = 0;
    return status;
}

static kn_status begin(kn_ctx *ctx, void *user, const kn_tile *tile, const kn_job_report *report)
{
    mfem *m = user;
    m->nlooks = tile->nparts;
    kn_status status = kn_write_check_report(ctx, &format, report);
    if (status == KN_OK && report->volumes > 0 && report->volumes < report->patches)
        status = kn_fail(ctx, KN_EDOMAIN, "MFEM: a mesh is of surfaces or of volumes, and not of both");
    return status == KN_OK ? check_tile(ctx, m, tile, report->volumes > 0 ? 3 : 2) : status;
}

static void discard(kn_ctx *ctx, void *user, void *product)
{
    (void)user;
    written *w = product;
    if (!w) return;
    w->text.ctx = ctx; // the worker's own context may be gone
    kn_text_clear(&w->text);
    kn_free(ctx, w->cells);
    kn_free(ctx, w->nvars);
    kn_free(ctx, w);
}

static kn_status write_block(kn_ctx *worker, const mfem *m, const kn_patch_block *block, written *w)
{
    kn_status status = KN_OK;
    for (; status == KN_OK && w->n < block->count; w->n++) {
        const kn_patch *patch = &block->patches[w->n];
        kn_write_item item = {0};
        status = kn_write_check(worker, &format, m->nlooks, patch);
        if (status == KN_OK) status = kn_write_item_init(worker, &item, patch);
        if (status != KN_OK) break;
        w->cells[w->n].id = patch->id;
        w->cells[w->n].look = patch->look;
        w->nvars[w->n] = item.spline.nvars;
        look_at(&w->cells[w->n], &item.spline);
        if (has_closed_edge(&w->cells[w->n], item.spline.nvars))
            status = kn_write_refuse(worker, format.name, &patch->id, "has an edge that is closed or a point");
        put_patch(&w->text, &item.spline);
        kn_write_item_clear(worker, &item);
    }
    return status == KN_OK && w->text.failed ? KN_ENOMEM : status;
}

static kn_status work(kn_ctx *worker, void *user, const kn_patch_block *block, void **product)
{
    written *w = kn_alloc_zero(worker, 1, sizeof *w);
    if (!w) return KN_ENOMEM;
    w->text.ctx = worker;
    w->cells = kn_alloc_zero(worker, block->count + 1, sizeof *w->cells);
    w->nvars = kn_alloc_zero(worker, block->count + 1, sizeof *w->nvars);
    kn_status status = w->cells && w->nvars ? write_block(worker, user, block, w) : KN_ENOMEM;
    if (status == KN_OK)
        *product = w;
    else
        discard(worker, user, w);
    return status;
}

static kn_status take(kn_ctx *ctx, mfem *m, const written *w)
{
    if (m->n + w->n > m->room) {
        size_t room = 2 * m->room + w->n;
        kn_mfem_cell *larger = kn_resize(ctx, m->cells, room, sizeof *larger);
        if (!larger) return KN_ENOMEM;
        m->cells = larger, m->room = room;
    }
    for (size_t i = 0; i < w->n; i++) {
        if (m->nvars == 0) m->nvars = w->nvars[i];
        if (w->nvars[i] != m->nvars)
            return kn_fail(ctx, KN_EDOMAIN, "MFEM: a mesh is of surfaces or of volumes, and not of both");
        m->cells[m->n++] = w->cells[i];
    }
    return KN_OK;
}

static kn_status commit(kn_ctx *ctx, void *user, const kn_patch_block *block, void *product)
{
    (void)block;
    mfem *m = user;
    const written *w = product;
    kn_status status = take(ctx, m, w);
    if (status == KN_OK) status = kn_out_write(ctx, m->patches, w->text.data, w->text.bytes);
    discard(ctx, user, product);
    return status;
}

static kn_status end(kn_ctx *ctx, void *user)
{
    mfem *m = user;
    kn_text text = {.ctx = ctx};
    if (m->n == 0) return kn_fail(ctx, KN_EDOMAIN, "MFEM: a mesh without patches");
    kn_text_put(&text, "MFEM NURBS mesh v1.0\n\n# knurl " KN_VERSION_STRING
                       "\n# attributes: of patches 1 + part; of the boundary 1 + 2 variable + end\n");
    kn_status status = kn_mfem_put_topology(ctx, &text, m->cells, m->n, m->nvars);
    kn_text_put(&text, "\npatches\n");
    if (status == KN_OK && text.failed) status = KN_ENOMEM;
    if (status == KN_OK) status = kn_out_write(ctx, m->file, text.data, text.bytes);
    if (status == KN_OK) status = kn_out_append(ctx, m->file, m->patches);
    if (status == KN_OK) status = kn_out_commit(ctx, m->file);
    kn_text_clear(&text);
    return status;
}

static void close(kn_ctx *ctx, void *user)
{
    mfem *m = user;
    kn_out_close(ctx, m->file);
    kn_out_close(ctx, m->patches);
    kn_free(ctx, m->cells);
    kn_free(ctx, m);
}

static size_t bytes_so_far(const void *user)
{
    const mfem *m = user;
    size_t whole = kn_out_bytes(m->file);
    return whole > 0 ? whole : kn_out_bytes(m->patches);
}

kn_status kn_mfem_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    mfem *m = kn_alloc_zero(ctx, 1, sizeof *m);
    if (!m) return KN_ENOMEM;
    kn_status status = kn_out_open(ctx, &m->file, path);
    if (status == KN_OK) status = kn_out_open_beside(ctx, &m->patches, m->file, ".patches");
    if (status == KN_OK)
        *out = (kn_sink){m, begin, work, commit, discard, end, close, bytes_so_far, NULL, NULL, NULL};
    else
        close(ctx, m);
    return status;
}
