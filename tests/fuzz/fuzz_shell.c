// SPDX-License-Identifier: Apache-2.0
// Fuzzes shells, tiles and jobs over small surfaces, and the sinks that jobs feed.
#include "tests/fuzz/feed.h"
#include <knurl/iges.h>
#include <knurl/step.h>

#include <knurl/knurl.h>

#include <math.h>
#include <stdlib.h>

// A surface near the unit square in dimension 3: what bytes make at random has no normal mostly.
static void make_surface(feed *f, kn_spline *s)
{
    feed_spline(f, s, 2);
    if (s->nvars != 2 || kn_spline_dim(s) != 3 || feed_byte(f) % 16 == 0) return;
    size_t n = kn_spline_count(s), across = (size_t)s->count[1];
    for (size_t i = 0; i < n; i++) {
        double w = s->rational ? s->coef[3 * n + i] : 1.0;
        double u = (double)(i / across) / (s->count[0] > 1 ? s->count[0] - 1 : 1);
        double v = (double)(i % across) / (across > 1 ? (double)across - 1.0 : 1.0);
        s->coef[i] = w * (u + s->coef[i] / 64.0);
        s->coef[n + i] = w * (v + s->coef[n + i] / 64.0);
        s->coef[2 * n + i] = w * s->coef[2 * n + i] / 32.0;
    }
    if (kn_spline_check(f->ctx, s) != KN_OK) kn_spline_clear(f->ctx, s);
}

static kn_shell_options make_shell_options(feed *f)
{
    kn_shell_options options = kn_shell_defaults();
    options.normal_tol = feed_byte(f) % 8 ? 0.05 : feed_number(f);
    options.max_spans = feed_wild(f, 1, 12) & 15;
    options.max_degree = feed_byte(f) % 4 ? 0 : feed_wild(f, 3, 6);
    for (int d = 0; d < 2; d++)
        if (feed_byte(f) % 4 == 0) {
            int n = feed_int(f, 0, 4);
            double *lines = feed_parameters(f, (size_t)n);
            if (n > 1 && feed_byte(f) % 2) lines[0] = 0.0, lines[n - 1] = 1.0;
            options.lines[d] = lines, options.nlines[d] = n;
        }
    if (feed_byte(f) % 4 == 3) options.normal = KN_NORMAL_EXACT_DIRECTION;
    return options;
}

// Rows end in exact-size memory.
static void use_rows(feed *f, const kn_shell *shell, const kn_shell_piece *like, const int cell[2])
{
    size_t row = 0;
    int n = feed_int(f, 0, 5), made = 0;
    for (int t = 0; t < like->nterms; t++) row += kn_bezier_count(&like->term[t]);
    double *rows = malloc((size_t)n * row * (size_t)like->term[0].ncomp * sizeof *rows + 1);
    if (!rows) return;
    feed_any(kn_shell_piece_rows(f->ctx, rows, &made, shell, like, cell, n));
    if (made < 0 || made > n) abort();
    free(rows);
}

static void use_shell(feed *f, const kn_shell *shell)
{
    double point[3], jacobian[9], lo[2] = {feed_number(f) / 4.0, 0.0}, hi[2] = {1.0, feed_number(f) / 4.0};
    int cells[2], cell[2] = {feed_wild(f, -1, 3), feed_wild(f, -1, 3)};
    bool fits, closed[2];
    kn_shell_piece piece;
    kn_shell_cells(shell, cells);
    kn_shell_closed(shell, closed);
    kn_shell_edge edges[2][2];
    kn_shell_edges(shell, edges);
    if (edges[0][0].order < 0 || edges[1][1].kind > KN_EDGE_APEX) abort();
    if (kn_shell_surface(shell)->nvars != 2 || kn_shell_normal(shell)->nvars != 2 || cells[0] < 1) abort();
    if (!kn_shell_certificate(shell).certified) abort();
    feed_any(kn_shell_eval(f->ctx, point, jacobian, shell, feed_number(f), feed_number(f), feed_number(f)));
    feed_any(kn_shell_unit_normal(f->ctx, point, shell, feed_number(f), feed_number(f)));
    feed_any(kn_shell_jacobian_bounds(f->ctx, &lo[1], &hi[0], shell, feed_number(f), feed_number(f)));
    lo[1] = 0.0, hi[0] = 1.0;
    if (cell[0] > 100 || cell[0] < -100) cell[0] = 100;
    if (kn_shell_piece_init(f->ctx, &piece, &fits, shell, cell, lo, hi, feed_wild(f, 0, 8)) == KN_OK && fits)
        kn_shell_piece_clear(f->ctx, &piece);
    if (kn_shell_piece_outline(f->ctx, &piece, &fits, shell, cell, lo, hi, 6) == KN_OK && fits) {
        use_rows(f, shell, &piece, cell);
        kn_shell_piece_clear(f->ctx, &piece);
    }
}

// A point that T has made must be in one of the boxes; all boxes reach into the domain.
static void use_inverse(feed *f, const kn_shell *shell)
{
    kn_shell_inverse *inverse = NULL;
    kn_support *places = NULL;
    kn_side side;
    size_t n = 0;
    bool complete, found = false;
    double w0 = feed_number(f) / 8.0, w1 = feed_byte(f) % 8 ? w0 + 0.5 : feed_number(f), lo[2], hi[2], point[3];
    double at[3] = {feed_byte(f) / 255.0, feed_byte(f) / 255.0, w0 + (w1 - w0) * (feed_byte(f) / 255.0)};
    for (int v = 0; v < 2; v++) {
        kn_spline_domain(kn_shell_surface(shell), v, &lo[v], &hi[v]);
        at[v] = lo[v] + at[v] * (hi[v] - lo[v]);
    }
    bool made = kn_shell_eval(f->ctx, point, NULL, shell, at[0], at[1], at[2]) == KN_OK;
    if (!made || feed_byte(f) % 4 == 0) made = false, point[0] = feed_number(f), point[1] = point[2] = 0.5;
    if (kn_shell_inverse_create(f->ctx, &inverse, shell, w0, w1) != KN_OK) return;
    if (kn_shell_support(f->ctx, &places, &n, &complete, inverse, point) == KN_OK) {
        for (size_t i = 0; i < n; i++) {
            bool in = true;
            for (int d = 0; d < 3; d++) {
                const kn_support *s = &places[i];
                if (!(s->error[d] >= 0.0)) abort();
                in = in && fabs(s->uvw[d] - at[d]) <= s->error[d];
                in = in || (d < 2 && s->at_edge); // the other end of a closed variable
            }
            found = found || in;
        }
        if (made && !found) abort();
    }
    kn_free(f->ctx, places);
    feed_any(kn_shell_side(f->ctx, &side, inverse, point));
    kn_shell_inverse_destroy(f->ctx, inverse);
}

static void use_normals(feed *f, const kn_shell *shell)
{
    double at[3] = {feed_number(f), feed_number(f), feed_number(f)}, n[3], out[3];
    for (int c = 0; c < 3; c++) n[c] = feed_number(f);
    if (feed_byte(f) % 2) kn_spline_domain(kn_shell_surface(shell), 1, &at[1], &out[0]);
    feed_any(kn_shell_map_normal(f->ctx, out, shell, at, n));
    feed_any(kn_shell_map_normal_estimate(f->ctx, out, shell, at, n));
}

static bool make_tile(feed *f, kn_tile *tile)
{
    char name[2 * KN_NAME_BYTES] = "tile";
    if (feed_byte(f) >= 248) memset(name, 'x', sizeof name - 1);
    if (kn_tile_init(f->ctx, tile, name, feed_count(f, 1, 2)) != KN_OK) return false;
    for (int i = feed_int(f, 0, 2); i >= 0; i--) {
        kn_spline s;
        make_surface(f, &s);
        feed_any(kn_tile_add(f->ctx, tile, feed_wild(f, 0, 1), &s));
        kn_spline_clear(f->ctx, &s);
    }
    feed_any(kn_tile_rotate(f->ctx, tile, feed_wild(f, 0, 5)));
    feed_any(kn_tile_set_cell(f->ctx, tile, (const double[]){-0.5, 0, 1, 2}, feed_wild(f, -1, 3)));
    feed_any(kn_tile_check(f->ctx, tile));
    return true;
}

static kn_status open_sink(feed *f, kn_sink *sink)
{
    kn_step_options options = {.unit_mm = feed_byte(f) % 4 ? 0.0 : feed_number(f)};
    switch (feed_byte(f) % 5) {
    case 0: return kn_step_sink(f->ctx, sink, "/dev/null", &options);
    case 1: return kn_stl_sink(f->ctx, sink, "/dev/null");
    case 2: return kn_obj_sink(f->ctx, sink, "/dev/null/none/x.obj"); // no such place
    case 3: return kn_iges_sink(f->ctx, sink, "/dev/null", &(kn_iges_options){.surfaces = feed_byte(f) % 2});
    default: return kn_null_sink(f->ctx, sink);
    }
}

static kn_status keep_nothing(kn_ctx *ctx, void *user, const unsigned char *state, size_t bytes)
{
    (void)ctx, (void)user;
    return state && bytes > 0 ? KN_OK : KN_EDOMAIN;
}

// A whole run, one of some cells, and runs that are noted or go on from bytes that no run has noted.
static void run_sink(feed *f, const kn_job *job, kn_sink *sink)
{
    const kn_cell_range ranges[2] = {{(size_t)feed_int(f, 0, 1), (size_t)feed_int(f, 0, 2)}, {2, 1}};
    const kn_job *const layers[2] = {job, job};
    unsigned char state[64];
    switch (feed_byte(f) % 4) {
    case 0: feed_any(kn_job_run_cells(f->ctx, job, ranges, 1 + (size_t)feed_byte(f) % 2, sink, 1)); break;
    case 1: {
        for (size_t i = 0; i < sizeof state; i++) state[i] = (unsigned char)feed_byte(f);
        kn_job_notes notes = {.note = keep_nothing, .seconds = -1.0};
        if (feed_byte(f) % 2) notes.state = state, notes.bytes = 1 + (size_t)feed_int(f, 0, 63);
        feed_any(feed_byte(f) % 2 ? kn_job_run_from(f->ctx, job, sink, 1, &notes)
                                  : kn_job_run_layers_from(f->ctx, layers, 2, sink, 1, &notes));
        break;
    }
    case 2: feed_any(kn_run_with_journal(f->ctx, layers, 1, sink, 1, "/dev/null/none.journal", false, 0.0, 0)); break;
    default: feed_any(kn_job_run(f->ctx, job, sink, 1));
    }
}

static void run_job(feed *f, kn_job *job)
{
    kn_job_report report = kn_job_describe(job);
    kn_sink sink;
    kn_patch_id id = {feed_wild(f, 0, 1),
                      {feed_wild(f, 0, 2), feed_wild(f, 0, 2)},
                      feed_wild(f, 0, 1),
                      feed_wild(f, 0, 1),
                      feed_wild(f, 0, 1),
                      feed_wild(f, 0, 1),
                      0};
    kn_patch_place place;
    kn_bezier source = {0};
    feed_any(kn_job_source(f->ctx, &source, &place, job, &id));
    kn_bezier_clear(f->ctx, &source);
    if (kn_job_tile(job)->nparts < 1 || !kn_job_shell(job, 0) || !kn_job_lines(job, 0, 1)) abort();
    if (kn_job_lines(job, id.surface + 2, 0) && id.surface + 2 >= report.nsurfaces) abort();
    if (report.patches > 200 || open_sink(f, &sink) != KN_OK) return;
    run_sink(f, job, &sink);
    kn_sink_close(f->ctx, &sink);
}

static void jobs(feed *f, const kn_spline *surface)
{
    kn_tile tile;
    kn_job *job = NULL;
    kn_job_options options = kn_job_defaults();
    options.count[0] = feed_count(f, 1, 3), options.count[1] = feed_count(f, 1, 3);
    options.height = feed_byte(f) % 2 ? 0.05 : feed_number(f);
    options.normal_tol = feed_byte(f) % 8 ? 0.05 : feed_number(f);
    options.max_degree = feed_byte(f) % 4 ? 0 : feed_wild(f, 10, KN_MAX_DEGREE);
    options.quarter_turns = feed_wild(f, 0, 3);
    options.symbolic = feed_byte(f) % 8 == 0;
    options.mesh_tol = feed_byte(f) % 8 ? 0.2 : feed_number(f);
    if (options.count[0] < 1 || options.count[1] < 1) options.size[0] = feed_byte(f) % 2 ? 0.5 : feed_number(f);
    if (!make_tile(f, &tile)) return;
    if (options.size[0] == 0.0 || options.size[0] > 0.2)
        if (kn_job_create(f->ctx, &job, surface, feed_count(f, 1, 1), &tile, &options) == KN_OK) run_job(f, job);
    kn_job_destroy(f->ctx, job);
    kn_tile_clear(f->ctx, &tile);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    int which = feed_byte(&f);
    kn_spline surface;
    kn_shell *shell = NULL;
    make_surface(&f, &surface);
    kn_ctx_clear_error(f.ctx);
    if (which % 2) {
        jobs(&f, &surface);
    } else {
        kn_shell_options options = make_shell_options(&f);
        if (kn_shell_create(f.ctx, &shell, &surface, &options) == KN_OK) {
            use_shell(&f, shell);
            use_normals(&f, shell);
            use_inverse(&f, shell);
        }
        kn_shell_destroy(f.ctx, shell);
    }
    kn_spline_clear(f.ctx, &surface);
    feed_end(&f);
    return 0;
}
