// SPDX-License-Identifier: Apache-2.0
// Fuzzes shells of other kinds than S + w n, the pieces between creases, and jobs over them.
#include "tests/fuzz/feed.h"

#include <knurl/knurl.h>

// Control points near a grid over the unit square or cube: random ones rarely make a shell, and folded ones are slow.
static void make_base(feed *f, kn_spline *s, int nvars)
{
    feed_spline(f, s, nvars);
    if (s->nvars != nvars || kn_spline_dim(s) != 3 || feed_byte(f) % 16 == 0) return;
    size_t n = kn_spline_count(s);
    for (size_t i = 0; i < n; i++) {
        double w = s->rational ? s->coef[3 * n + i] : 1.0, x[3] = {0};
        size_t rest = i;
        for (int v = nvars - 1; v >= 0; rest /= (size_t)s->count[v], v--)
            x[v] = (double)(rest % (size_t)s->count[v]) / (s->count[v] > 1 ? s->count[v] - 1 : 1);
        for (size_t c = 0; c < 3; c++) s->coef[c * n + i] = w * (x[c] + s->coef[c * n + i] / 256.0);
    }
    if (kn_spline_check(f->ctx, s) != KN_OK) kn_spline_clear(f->ctx, s);
}

// A field over [0,1]^2 or the domain of `like`, or what else the bytes say; middle is added to its coefficients.
static const kn_spline *make_field(feed *f, kn_spline *out, const kn_spline *like, int ncomp, double middle)
{
    *out = (kn_spline){0};
    if (feed_byte(f) % 2) return NULL;
    feed_spline(f, out, 2);
    if (out->nvars != 2 || out->rational || out->ncomp < ncomp || feed_byte(f) % 16 == 0) return out;
    feed_any(kn_spline_components(f->ctx, out, out, 0, ncomp));
    for (size_t i = 0; i < (size_t)out->ncomp * kn_spline_count(out); i++)
        out->coef[i] = middle + out->coef[i] / 32.0;
    for (int v = 0; v < 2; v++) {
        double lo = 0.0, hi = 1.0;
        if (like && like->nvars >= 2) kn_spline_domain(like, v, &lo, &hi);
        feed_any(kn_spline_reparameterize(f->ctx, out, out, v, lo, hi));
    }
    return out;
}

static void use_shell(feed *f, const kn_shell *shell)
{
    double p[3], j[9], w[2], lo[2] = {0, 0}, hi[2] = {1, feed_byte(f) % 2 ? 1.0 : feed_number(f)};
    int cells[2], cell[2] = {feed_wild(f, -1, 3) % 100, feed_wild(f, -1, 3) % 100};
    bool fits;
    kn_shell_piece piece;
    kn_spline volume = {0};
    kn_shell_heights(shell, w);
    kn_shell_cells(shell, cells);
    if (!(w[0] < w[1]) || !kn_shell_certificate(shell).certified || cells[0] < 1 || cells[1] < 1) abort();
    feed_any(kn_shell_eval(f->ctx, p, j, shell, feed_number(f), feed_number(f), feed_number(f)));
    feed_any(kn_shell_unit_normal(f->ctx, p, shell, feed_number(f), feed_number(f)));
    if (kn_shell_piece_init(f->ctx, &piece, &fits, shell, cell, lo, hi, feed_wild(f, 0, 8)) == KN_OK && fits)
        kn_shell_piece_clear(f->ctx, &piece);
    if (kn_shell_volume(f->ctx, &volume, shell, feed_number(f), feed_number(f)) == KN_OK)
        if (volume.nvars != 3 || kn_spline_dim(&volume) != 3) abort();
    kn_spline_clear(f->ctx, &volume);
}

static void shells(feed *f, const kn_spline *base)
{
    kn_shell *shell = NULL;
    kn_spline h, d, psi;
    kn_shell_options o = {.normal_tol = 0.05, .max_spans = 15};
    o.thickness = make_field(f, &h, base, 1, 1.0);
    o.direction = make_field(f, &d, base, 3, 0.5);
    o.attraction = make_field(f, &psi, base, 3, 0.0);
    o.attraction_power = feed_wild(f, 0, 4);
    kn_ctx_clear_error(f->ctx);
    kn_status status = base->nvars == 3 ? kn_shell_from_volume(f->ctx, &shell, base, &o)
                                        : kn_shell_create(f->ctx, &shell, base, &o);
    if (status == KN_OK) use_shell(f, shell);
    kn_shell_destroy(f->ctx, shell);
    kn_spline_clear(f->ctx, &h), kn_spline_clear(f->ctx, &d), kn_spline_clear(f->ctx, &psi);
}

static void creases(feed *f, const kn_spline *base)
{
    kn_spline *pieces = NULL;
    int counts[2];
    double angle = feed_byte(f) % 4 ? feed_byte(f) / 200.0 : feed_number(f);
    if (kn_shell_split_creases(f->ctx, &pieces, counts, base, angle) != KN_OK) return;
    if (counts[0] < 1 || counts[1] < 1) abort();
    for (int i = 0; i < counts[0] * counts[1]; i++) {
        if (kn_spline_check(f->ctx, &pieces[i]) != KN_OK) abort();
        kn_spline_clear(f->ctx, &pieces[i]);
    }
    kn_free(f->ctx, pieces);
}

// One bilinear patch, perhaps beyond its cell.
static bool make_tile(feed *f, kn_tile *tile)
{
    const double k[4] = {0, 0, 1, 1}, *knots[2] = {k, k}, wide = feed_byte(f) % 4 ? 0.0 : 0.25;
    const double coef[12] = {-wide, -wide, 1 + wide, 1 + wide, 0, 1, 0, 1, 0, 0.5, 0.5, 1};
    kn_spline s = {0};
    kn_status status = kn_spline_init(f->ctx, &s, 2, 3, false, (const int[2]){1, 1}, (const int[2]){2, 2}, knots,
                                      coef);
    if (status == KN_OK) status = kn_tile_init(f->ctx, tile, "tile", 1);
    if (status == KN_OK) status = kn_tile_add(f->ctx, tile, 0, &s);
    kn_spline_clear(f->ctx, &s);
    return status == KN_OK;
}

static void place_and_select(feed *f, kn_job_options *o)
{
    for (int v = 0; v < 2; v++) {
        o->placement.shift[v] = 0.25 * feed_int(f, 0, 5);
        o->placement.mirror[v] = feed_byte(f) % 4 == 0;
        o->placement.border[v] = (kn_job_border)feed_wild(f, 0, 2);
        o->select.skip[v] = feed_int(f, 0, 3);
    }
    o->placement.stagger[feed_byte(f) % 2] = feed_byte(f) % 2 ? 0.5 : 0.0;
    unsigned char seed = (unsigned char)feed_byte(f);
    o->placement.scatter = (kn_job_scatter){.distance = feed_byte(f) % 4 ? 0.0 : 0.3, .seed = seed};
    o->select.slab = feed_byte(f) % 4 == 0;
    o->select.slab_z[0] = feed_number(f), o->select.slab_z[1] = feed_number(f);
}

// What is in a slab is a cell of the job.
static void ask_slabs(feed *f, const kn_job *job)
{
    kn_job_slabs *slabs = NULL;
    kn_cell_range *ranges = NULL;
    size_t n = 0;
    double z[2];
    if (kn_job_slabs_create(f->ctx, &slabs, job) != KN_OK) return;
    kn_job_slabs_range(slabs, z);
    double at = z[0] <= z[1] ? 0.5 * (z[0] + z[1]) : 0.0;
    if (kn_job_slabs_find(f->ctx, &ranges, &n, slabs, at, at) == KN_OK)
        for (size_t i = 0; i < n; i++)
            if (ranges[i].count < 1 || (i > 0 && ranges[i].first <= ranges[i - 1].first)) abort();
    kn_free(f->ctx, ranges);
    kn_job_slabs_destroy(f->ctx, slabs);
}

// Few patches behind limits of degrees, and merged; sink stays as it is after a failure.
static void lower(feed *f, kn_sink *sink, size_t patches)
{
    kn_sink merged, limited;
    const kn_limit_options limits = {.max_degree = feed_wild(f, 3, 9), .tolerance = 0.5};
    if (patches > 12 ||
        kn_merge_sink(f->ctx, &merged, sink, 1, &(kn_merge_options){.tolerance = 0.25, .cells = 2}, NULL) != KN_OK)
        return;
    *sink = merged;
    if (kn_limit_sink(f->ctx, &limited, sink, 1, &limits, NULL) == KN_OK) *sink = limited;
}

static void jobs(feed *f, const kn_spline *base)
{
    kn_tile tile = {0};
    kn_spline h, d, psi;
    kn_job *job = NULL;
    kn_job_options o = {.normal_tol = 0.2, .max_degree = 50, .mesh_tol = 0.5};
    for (int v = 0; v < 2; v++) o.count[v] = feed_int(f, 1, 6);
    o.height = feed_byte(f) % 2 ? 0.05 : feed_number(f);
    o.side = (kn_job_side)feed_wild(f, 0, 2);
    o.thickness = make_field(f, &h, NULL, 1, 1.0);
    o.direction = make_field(f, &d, NULL, 3, 0.5);
    o.attraction = make_field(f, &psi, NULL, 3, 0.0);
    o.attraction_power = feed_wild(f, 0, 4);
    if (feed_byte(f) % 2 == 0) place_and_select(f, &o);
    kn_ctx_clear_error(f->ctx);
    if (make_tile(f, &tile) && kn_job_create(f->ctx, &job, base, 1, &tile, &o) == KN_OK) {
        kn_job_report report = kn_job_describe(job);
        kn_sink sink;
        int first[2];
        if (report.nparts < 1 || kn_job_origin(job, report.nparts - 1, first) != 0 || first[0] < 0) abort();
        if (kn_job_origin(job, report.nparts, first) != -1) abort();
        if (report.patches <= 200 && kn_null_sink(f->ctx, &sink) == KN_OK) {
            lower(f, &sink, report.patches);
            feed_any(kn_job_run(f->ctx, job, &sink, 1));
            kn_sink_close(f->ctx, &sink);
            ask_slabs(f, job);
        }
    }
    kn_job_destroy(f->ctx, job);
    kn_tile_clear(f->ctx, &tile);
    kn_spline_clear(f->ctx, &h), kn_spline_clear(f->ctx, &d), kn_spline_clear(f->ctx, &psi);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    int which = feed_byte(&f);
    kn_spline base;
    make_base(&f, &base, which % 5 < 3 ? 2 : 3);
    kn_ctx_clear_error(f.ctx);
    if (which % 5 == 0 || which % 5 == 3) shells(&f, &base);
    if (which % 5 == 1) creases(&f, &base);
    if (which % 5 == 2 || which % 5 == 4) jobs(&f, &base);
    kn_spline_clear(f.ctx, &base);
    feed_end(&f);
    return 0;
}
