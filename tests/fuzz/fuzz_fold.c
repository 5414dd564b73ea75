// SPDX-License-Identifier: Apache-2.0
// Fuzzes the Jacobian of small shells: its pieces, signs, safe heights and zero sets, and self-intersection.
#include "tests/fuzz/feed.h"

#include <knurl/fold.h>
#include <knurl/knurl.h>

// Control points near a grid over the unit square or cube: random ones rarely make a shell.
static void make_base(feed *f, kn_spline *s, int nvars)
{
    feed_spline(f, s, nvars);
    if (s->nvars != nvars || kn_spline_dim(s) != 3) return;
    size_t n = kn_spline_count(s);
    for (size_t i = 0; i < n; i++) {
        double w = s->rational ? s->coef[3 * n + i] : 1.0, x[3] = {0};
        size_t rest = i;
        for (int v = nvars - 1; v >= 0; rest /= (size_t)s->count[v], v--)
            x[v] = (double)(rest % (size_t)s->count[v]) / (s->count[v] > 1 ? s->count[v] - 1 : 1);
        for (size_t c = 0; c < 3; c++) s->coef[c * n + i] = w * (x[c] + s->coef[c * n + i] / 32.0);
    }
    if (kn_spline_check(f->ctx, s) != KN_OK) kn_spline_clear(f->ctx, s);
}

// What pieces and splines say of the same shell must fit together.
static void pieces(feed *f, const kn_shell *shell)
{
    int grid[3], box[3], n = 0, weight = 0;
    kn_shell_jacobian_piece p;
    kn_spline *list = NULL;
    kn_shell_jacobian_grid(shell, grid);
    for (int v = 0; v < 3; v++) box[v] = feed_wild(f, 0, grid[v] < 8 ? grid[v] : 8);
    if (kn_shell_jacobian_piece_init(f->ctx, &p, shell, box) == KN_OK) {
        for (int v = 0; v < 3; v++)
            if (box[v] < 0 || box[v] >= grid[v] || !(p.lo[v] < p.hi[v])) abort();
        kn_shell_jacobian_piece_clear(f->ctx, &p);
    }
    if (kn_shell_jacobian(f->ctx, &list, &n, &weight, shell) != KN_OK) return;
    if (n < 1 || list[0].ncomp != 1) abort();
    for (int k = 0; k < n; k++) kn_spline_clear(f->ctx, &list[k]);
    kn_free(f->ctx, list);
}

// Below the safe heights the sign must not be called anything but positive.
static void heights(feed *f, const kn_shell *shell)
{
    kn_fold_heights all;
    kn_fold_sign sign;
    double lo[3], hi[3], w[2];
    if (kn_fold_safe_heights(f->ctx, NULL, &all, shell) != KN_OK) return;
    if (!(all.above >= 0.0 && all.below >= 0.0 && all.above <= all.above_most && all.below <= all.below_most))
        abort();
    kn_shell_heights(shell, w);
    for (int v = 0; v < 2; v++) kn_spline_domain(kn_shell_surface(shell), v, &lo[v], &hi[v]);
    lo[2] = w[0] == 0.0 ? 0.0 : -fmin(0.9 * all.below, 10.0);
    hi[2] = fmin(fmin(0.9 * all.above, 10.0), w[1]);
    if (all.above == 0.0 || all.below == 0.0) return; // J is not positive there
    if (kn_fold_jacobian_sign(f->ctx, &sign, shell, lo, hi) != KN_OK) return;
    if (sign.verdict == KN_FOLD_NEGATIVE || sign.verdict == KN_FOLD_MIXED) abort();
    if (sign.verdict == KN_FOLD_POSITIVE && !(sign.lo <= sign.hi)) abort();
}

static void boxes(feed *f, const kn_shell *shell)
{
    double lo[3], hi[3];
    kn_fold_sign sign;
    for (int v = 0; v < 3; v++) lo[v] = feed_number(f) / 4.0, hi[v] = lo[v] + fabs(feed_number(f)) / 4.0;
    if (kn_fold_jacobian_sign(f->ctx, &sign, shell, lo, hi) != KN_OK) return;
    if (sign.verdict == KN_FOLD_MIXED && !(sign.value <= 0.0)) abort();
}

static void zero_sets(feed *f, const kn_shell *shell)
{
    kn_mesh mesh = {0};
    double *points = NULL;
    size_t *ends = NULL, nlines = 0;
    feed_any(kn_fold_surface(f->ctx, &mesh, shell, feed_number(f), feed_number(f), feed_int(f, -1, 4)));
    for (size_t i = 0; i < 3 * mesh.ntriangles; i++)
        if (mesh.triangle[i] >= mesh.nvertices) abort();
    kn_mesh_clear(f->ctx, &mesh);
    if (kn_fold_curves(f->ctx, &points, &ends, &nlines, shell, feed_number(f), feed_int(f, -1, 4)) == KN_OK) {
        for (size_t i = 1; i < nlines; i++)
            if (ends[i] <= ends[i - 1]) abort();
        kn_free(f->ctx, points);
        kn_free(f->ctx, ends);
    }
}

// A witness must be one.
static void self_intersection(feed *f, const kn_shell *shell)
{
    const kn_shell *list[2] = {shell, shell};
    const double w[2] = {feed_number(f) / 4.0, feed_number(f) / 4.0};
    kn_fold_options o = {.work = (size_t)feed_int(f, 1, 60), .size = feed_byte(f) % 8 ? 0.0 : feed_number(f)};
    kn_fold_region r[2] = {{0, {0}, {1, 1, 1}}, {feed_wild(f, 0, 1), {0}, {1, 1, 1}}};
    kn_fold_intersection out;
    for (int d = 0; d < 3; d++) r[1].lo[d] = feed_number(f) / 4.0, r[1].hi[d] = feed_number(f) / 4.0;
    bool all = feed_byte(f) % 2 == 0;
    kn_status status = kn_fold_self_intersection(f->ctx, &out, list, 1, all ? NULL : r, all ? 0 : 2, w, &o);
    if (status != KN_OK || out.verdict != KN_FOLD_FOUND) return;
    double a[3], b[3], most = 0.0, size = 0.0, lo[3], hi[3];
    double low = all ? w[0] : fmin(r[0].lo[2], r[1].lo[2]), high = all ? w[1] : fmax(r[0].hi[2], r[1].hi[2]);
    kn_spline whole = {0};
    if (kn_shell_volume(f->ctx, &whole, shell, low, high) != KN_OK) return;
    status = kn_spline_box(f->ctx, lo, hi, &whole);
    kn_spline_clear(f->ctx, &whole);
    if (status != KN_OK) return;
    for (int k = 0; k < 3; k++) size = fmax(size, fmax(fabs(lo[k]), fabs(hi[k])));
    if (kn_shell_eval(f->ctx, a, NULL, shell, out.a.lo[0], out.a.lo[1], out.a.lo[2]) != KN_OK) return;
    if (kn_shell_eval(f->ctx, b, NULL, shell, out.b.lo[0], out.b.lo[1], out.b.lo[2]) != KN_OK) return;
    for (int k = 0; k < 3; k++) most = fmax(most, fabs(a[k] - b[k]));
    if (most > 1e-9 * size) abort(); // ten times what the header says, and rounding
}

// A field over the domain of `like`, or what else the bytes say.
static void make_field(feed *f, kn_spline *out, const kn_spline *like)
{
    feed_spline(f, out, 2);
    if (out->nvars != 2 || out->rational || out->ncomp < 3) return;
    feed_any(kn_spline_components(f->ctx, out, out, 0, 3));
    for (size_t i = 0; i < 3 * kn_spline_count(out); i++) out->coef[i] /= 16.0;
    for (int v = 0; v < 2; v++) {
        double lo = 0.0, hi = 1.0;
        if (like->nvars >= 2) kn_spline_domain(like, v, &lo, &hi);
        feed_any(kn_spline_reparameterize(f->ctx, out, out, v, lo, hi));
    }
}

static void jacobian(feed *f)
{
    kn_spline s, psi = {0};
    kn_shell *shell = NULL;
    kn_shell_options o = {.normal_tol = 0.05, .max_spans = 1 + feed_byte(f) % 6};
    int nvars = feed_byte(f) % 4 == 0 ? 3 : 2;
    make_base(f, &s, nvars);
    if (feed_byte(f) % 4 == 0) {
        make_field(f, &psi, &s);
        o.attraction = &psi, o.attraction_power = feed_wild(f, 1, 4);
    }
    kn_status status = nvars == 3 ? kn_shell_from_volume(f->ctx, &shell, &s, &o)
                                  : kn_shell_create(f->ctx, &shell, &s, &o);
    if (status == KN_OK) {
        pieces(f, shell);
        boxes(f, shell);
        heights(f, shell);
        zero_sets(f, shell);
        self_intersection(f, shell);
        kn_shell_destroy(f->ctx, shell);
    }
    kn_spline_clear(f->ctx, &psi);
    kn_spline_clear(f->ctx, &s);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    jacobian(&f);
    feed_end(&f);
    return 0;
}
