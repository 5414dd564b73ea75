// SPDX-License-Identifier: Apache-2.0
// All roots of a function of one variable: Descartes' rule of signs on Bernstein coefficients in twofold arithmetic.
//
// The number of sign changes of the coefficients over (a,b) is at least the number of roots there, with multiplicity,
// and differs from it by an even number: none means none, one means one. Every coefficient carries its error, which
// stays zero as long as sums are exact: a coefficient 0 +- 0 is an exact zero.
#include "solve/cells.h"
#include "solve/twofold.h"

#include "kernel/bernstein.h"
#include "kernel/context.h"

#include <string.h>

typedef struct number {
    kn_twofold v;
    double error;
} number;

// An interval of a cell: [at, at + 1] 2^-depth.
typedef struct node {
    double lo, hi;
    int depth;
} node;

typedef struct seeker {
    kn_cells *cells;
    kn_solve_options options;
    int degree;
    number *stack, *work;
    double *line;
    node *nodes;
    kn_root *root;
    size_t nroots, room;
    kn_solve_report report;
} seeker;

enum { SIGN_UNKNOWN = 2, RESOLUTION = 100 };

static int sign_of(const number *x)
{
    if (x->v.hi == 0.0 && x->error == 0.0) return 0;
    if (fabs(x->v.hi) * (1.0 - 0x1p-50) > x->error) return x->v.hi > 0.0 ? 1 : -1;
    return SIGN_UNKNOWN;
}

// (x + y) / 2. Of two doubles it is exact.
static number mean(number x, number y)
{
    bool exact = x.v.lo == 0.0 && y.v.lo == 0.0;
    number out = {.v = kn_twofold_add(x.v, y.v), .error = 0.5 * (x.error + y.error) * (1.0 + 0x1p-50)};
    out.v.hi *= 0.5, out.v.lo *= 0.5;
    double size = fabs(out.v.hi);
    if (!exact) out.error += 0x1p-104 * size;
    if (out.error > 0.0 || (size > 0.0 && size < 0x1p-900)) out.error += kn_underflow();
    return out;
}

static void halve(number *left, number *right, int n)
{
    for (int k = 0; k <= n; k++) { // right holds the whole
        left[k] = right[0];
        for (int i = 0; i < n - k; i++) right[i] = mean(right[i], right[i + 1]);
    }
}

// The fewest and the most sign changes, over all signs that unknown ones may have; exact zeros do not count.
// Row s: the changes so far when the last sign is s.
static void changes(const number *c, int n, int *least, int *most, int *known)
{
    int few[2] = {0, 0}, many[2] = {0, 0};
    bool started = false;
    *known = 0;
    for (int i = 0; i <= n; i++) {
        int s = sign_of(&c[i]), next_few[2], next_many[2];
        if (s == 0) continue;
        *known += s != SIGN_UNKNOWN;
        for (int t = 0; t < 2; t++) {
            bool may = s == SIGN_UNKNOWN || s == (t ? 1 : -1);
            next_few[t] = few[t] < few[!t] + 1 ? few[t] : few[!t] + 1;
            next_many[t] = many[t] > many[!t] + 1 ? many[t] : many[!t] + 1;
            if (!started) next_few[t] = next_many[t] = 0;
            if (!may) next_few[t] = 1000, next_many[t] = -1000;
        }
        memcpy(few, next_few, sizeof few);
        memcpy(many, next_many, sizeof many);
        started = true;
    }
    *least = few[0] < few[1] ? few[0] : few[1];
    *most = many[0] > many[1] ? many[0] : many[1];
}

static kn_status keep(kn_ctx *ctx, seeker *s, const kn_root *r)
{
    if (s->nroots == s->room) {
        size_t room = 2 * s->room + 8;
        kn_root *more = s->root ? kn_resize(ctx, s->root, room, sizeof *more) : kn_alloc(ctx, room, sizeof *more);
        if (!more) return KN_ENOMEM;
        s->root = more;
        s->room = room;
    }
    s->root[s->nroots++] = *r;
    return KN_OK;
}

static kn_status keep_found(kn_ctx *ctx, seeker *s, size_t cell, kn_root_kind kind, double lo, double at, double hi,
                            int least, int most)
{
    kn_found r = {.cell = cell, .kind = kind, .at = {at}, .lo = {lo}, .hi = {hi}};
    kn_root root = kn_cells_root(s->cells, &r);
    root.least = least;
    root.most = most;
    return keep(ctx, s, &root);
}

// The certain sign at x; 0: not certain. *value: about f(x). Plainly first: gamma(4n + 1) sum |c_i| B_i.
static int sign_at(seeker *s, size_t cell, double x, double *value)
{
    int n = s->degree;
    double error = 0.0, size = 0.0, basis[KN_MAX_DEGREE + 1];
    if (x >= 0.0 && x <= 1.0) {
        const double *c = s->cells->coef + cell * (size_t)(n + 1);
        kn_bernstein_basis(basis, n, x);
        *value = 0.0;
        for (int i = 0; i <= n; i++) *value += basis[i] * c[i], size += basis[i] * fabs(c[i]);
        error = kn_rounding(4.0 * n + 8.0) * size + s->cells->error[cell] + kn_underflow();
        if (fabs(*value) > error) return *value > 0.0 ? 1 : -1;
    }
    kn_cell_value(s->cells, cell, &x, value, &error, s->line);
    return *value > error ? 1 : *value < -error ? -1 : 0;
}

// The root between l and r, where the signs are first and -first: secants, each followed by a point a little beyond
// the root, and halvings where these fail. Ends when the bracket is a few units wide or signs are no longer certain.
static void bracket(seeker *s, size_t cell, int first, double *l, double *r)
{
    double fl = 0.0, fr = 0.0, v = 0.0;
    for (int step = 0; step < 120 && *r - *l > 0x1p-51 * fmax(fabs(*l), fabs(*r)); step++) {
        double width = *r - *l, x = *l + 0.5 * width, slope = (fr - fl) / width;
        bool secant = fl != 0.0 && fr != 0.0 && step % 4 != 3;
        if (secant) x = fmin(fmax(*l - fl / slope, *l + 1e-3 * width), *r - 1e-3 * width);
        int sign = sign_at(s, cell, x, &v);
        if (sign == 0) { // as near as it gets: the nearest certain signs on both sides
            bool low = false, high = false;
            for (double d = 0x1p-52 * fabs(x) + 0x1p-1000; d < width && !(low && high); d *= 4.0) {
                if (!low && x - d > *l && sign_at(s, cell, x - d, &v) == first) *l = x - d, low = true;
                if (!high && x + d < *r && sign_at(s, cell, x + d, &v) == -first) *r = x + d, high = true;
            }
            return;
        }
        if (sign == first) *l = x, fl = v;
        if (sign != first) *r = x, fr = v;
        if (!secant || fl == 0.0 || fr == 0.0) continue;
        double beyond = x - 2.0 * v / slope; // the secant's slope has the sign of the derivative
        if (!(beyond > *l && beyond < *r)) continue;
        sign = sign_at(s, cell, beyond, &v);
        if (sign == first) *l = beyond, fl = v;
        if (sign == -first) *r = beyond, fr = v;
    }
}

static kn_status keep_simple(kn_ctx *ctx, seeker *s, size_t cell, const node *a, const number *c)
{
    int first = 0;
    for (int i = 0; i <= s->degree && first == 0; i++) first = sign_of(&c[i]);
    double l = a->lo, r = a->hi;
    bracket(s, cell, first, &l, &r);
    double v, inner_l = nextafter(l, r), inner_r = nextafter(r, l); // the ends of the interval may be roots, too
    bool open_l = l == a->lo && sign_of(&c[0]) % SIGN_UNKNOWN == 0;
    bool open_r = r == a->hi && sign_of(&c[s->degree]) % SIGN_UNKNOWN == 0;
    if (open_l && inner_l < r && sign_at(s, cell, inner_l, &v) == first) l = inner_l, open_l = false;
    if (open_r && inner_r > l && sign_at(s, cell, inner_r, &v) == -first) r = inner_r, open_r = false;
    bool apart = !open_l && !open_r;
    return keep_found(ctx, s, cell, apart ? KN_ROOT_UNIQUE : KN_ROOT_POSSIBLE, l, l + 0.5 * (r - l), r, 1,
                      apart ? 1 : -1);
}

// Exact zeros in a row from the end at on: the multiplicity of a root there.
static int zeros_from(const number *c, int n, int at, int step)
{
    int count = 0;
    for (int i = at; i >= 0 && i <= n && sign_of(&c[i]) == 0; i += step) count++;
    return count;
}

// One interval: settled, kept, or divided in two (the right one stays in its place, the left one comes on top).
static kn_status one(kn_ctx *ctx, seeker *s, size_t cell, size_t *top)
{
    int n = s->degree, least, most, known;
    number *c = s->stack + (*top - 1) * (size_t)(n + 1);
    node a = s->nodes[*top - 1];
    changes(c, n, &least, &most, &known);
    if (known > 0 && most == 0) {
        --*top;
        return KN_OK;
    }
    if (least == 1 && most == 1 && known > 0) {
        --*top;
        return keep_simple(ctx, s, cell, &a, c);
    }
    double mid = a.lo + 0.5 * (a.hi - a.lo);
    if (known == 0 || a.depth >= s->options.max_depth || a.depth >= RESOLUTION || mid <= a.lo || mid >= a.hi ||
        s->report.boxes > s->options.max_boxes) {
        bool zero = zeros_from(c, n, 0, 1) == n + 1; // the whole piece
        s->report.limited = s->report.limited || a.depth >= s->options.max_depth ||
                            s->report.boxes > s->options.max_boxes;
        s->report.curve_like = s->report.curve_like || zero;
        --*top;
        int ends = (sign_of(&c[0]) == SIGN_UNKNOWN) + (sign_of(&c[n]) == SIGN_UNKNOWN);
        return keep_found(ctx, s, cell, KN_ROOT_POSSIBLE, a.lo, mid, a.hi, known > 0 ? least % 2 && least == most : 0,
                          known > 0 ? most + ends : -1);
    }
    halve(c + n + 1, c, n);
    s->nodes[*top] = (node){a.lo, mid, a.depth + 1};
    s->nodes[*top - 1] = (node){mid, a.hi, a.depth + 1};
    ++*top;
    int zeros = zeros_from(c, n, 0, 1);
    return zeros > 0 ? keep_found(ctx, s, cell, KN_ROOT_UNIQUE, mid, mid, mid, zeros, zeros) : KN_OK;
}

static kn_status one_cell(kn_ctx *ctx, seeker *s, size_t cell)
{
    int n = s->degree;
    const double *coef = s->cells->coef + cell * (size_t)(n + 1);
    kn_status status = KN_OK;
    for (int i = 0; i <= n; i++) s->stack[i] = (number){{coef[i], 0.0}, s->cells->error[cell]};
    s->nodes[0] = (node){0.0, 1.0, 0};
    int left = zeros_from(s->stack, n, 0, 1), right = zeros_from(s->stack, n, n, -1);
    if (left > 0 && left <= n) status = keep_found(ctx, s, cell, KN_ROOT_UNIQUE, 0.0, 0.0, 0.0, left, left);
    if (right > 0 && right <= n && status == KN_OK)
        status = keep_found(ctx, s, cell, KN_ROOT_UNIQUE, 1.0, 1.0, 1.0, right, right);
    for (size_t top = 1; top > 0 && status == KN_OK;) {
        if (s->report.boxes++ % 1024 == 1023)
            status = kn_progress(ctx, "roots", (double)cell / (double)s->cells->count);
        if (status == KN_OK) status = one(ctx, s, cell, &top);
    }
    return status;
}

// The function grows or falls strictly over [lo,hi], across cells, and has different signs at the ends: there is one
// simple root. A difference of coefficients has twice their error.
static bool certain(seeker *s, double lo, double hi)
{
    kn_net *net = &s->cells->net;
    int n = s->degree, slope = 0, first = 0, last = 0;
    double value, reached = lo, width = s->cells->hi[0] - s->cells->lo[0];
    for (size_t c = 0; c < s->cells->count; c++) {
        const double *box = s->cells->box + 2 * c;
        bool start = box[0] == s->cells->lo[0], end = box[1] == s->cells->hi[0];
        double s0 = (lo - box[0]) / (box[1] - box[0]), s1 = (hi - box[0]) / (box[1] - box[0]);
        double error = s->cells->error[c], *coef = s->line;
        if (!start) s0 = fmax(s0, 0.0);
        if (!end) s1 = fmin(s1, 1.0);
        if (!(s0 < s1)) continue;
        if (box[0] > reached && !start) return false; // a cell is missing
        reached = box[1];
        kn_net_restrict(coef, &error, net, s->cells->coef + c * (size_t)(n + 1), &s0, &s1, coef + n + 1);
        for (int i = 0; i < n; i++) {
            double d = coef[i + 1] - coef[i];
            int sign = d > 2.1 * error ? 1 : d < -2.1 * error ? -1 : 0;
            if (sign == 0 || (slope != 0 && sign != slope)) return false;
            slope = sign;
        }
        if (first == 0) first = sign_at(s, c, s0, &value);
        if (first == 0) return false;
        last = sign_at(s, c, s1, &value);
    }
    if (reached < hi && reached < s->cells->lo[0] + width) return false;
    return n > 0 && slope != 0 && first == -last && first != 0;
}

// Undecided intervals that meet are one, and often a root on a knot that rounding hides from both sides.
static void join(seeker *s)
{
    size_t n = 0;
    for (size_t i = 0; i < s->nroots; i++) {
        kn_root r = s->root[i];
        kn_root *last = n > 0 ? &s->root[n - 1] : NULL;
        if (last && last->kind == KN_ROOT_UNIQUE && r.kind == KN_ROOT_UNIQUE && last->lo[0] == r.lo[0] &&
            last->hi[0] == r.hi[0] && r.lo[0] == r.hi[0]) { // a knot, from both sides
            last->least = r.least < last->least ? r.least : last->least;
            last->most = r.most > last->most ? r.most : last->most;
            continue;
        }
        if (last && (last->kind == KN_ROOT_POSSIBLE || r.kind == KN_ROOT_POSSIBLE) && r.lo[0] <= last->hi[0]) {
            last->kind = KN_ROOT_POSSIBLE;
            last->hi[0] = fmax(last->hi[0], r.hi[0]);
            last->most = last->most < 0 || r.most < 0 ? -1 : last->most + r.most;
            last->least += r.least; // they count roots inside, which differ
            last->at_edge = last->at_edge || r.at_edge;
            last->at[0] = 0.5 * last->lo[0] + 0.5 * last->hi[0];
            continue;
        }
        s->root[n++] = r;
    }
    s->nroots = n;
    double domain = s->cells->hi[0] - s->cells->lo[0];
    for (size_t i = 0; i < n && !s->cells->jumps; i++) {
        kn_root *r = &s->root[i];
        for (double reach = 0x1p-44; reach < 0.1 && r->kind == KN_ROOT_POSSIBLE; reach *= 16.0) {
            double more = reach * domain + (r->hi[0] - r->lo[0]);
            bool crowded = (i > 0 && s->root[i - 1].hi[0] >= r->lo[0] - more) ||
                           (i + 1 < n && s->root[i + 1].lo[0] <= r->hi[0] + more);
            if (crowded) break;
            if (!certain(s, r->lo[0] - more, r->hi[0] + more)) continue;
            r->lo[0] -= more, r->hi[0] += more;
            r->kind = KN_ROOT_UNIQUE;
            r->least = r->most = 1;
            r->at_edge = r->lo[0] <= s->cells->lo[0] || r->hi[0] >= s->cells->hi[0];
        }
    }
}

static kn_status by_place(kn_ctx *ctx, seeker *s)
{
    kn_status status = kn_progress(ctx, "roots", 1.0);
    for (size_t i = 1; i < s->nroots; i++) { // nearly sorted
        kn_root r = s->root[i];
        size_t j = i;
        for (; j > 0 && (s->root[j - 1].lo[0] > r.lo[0] ||
                         (s->root[j - 1].lo[0] == r.lo[0] && s->root[j - 1].hi[0] > r.hi[0]));
             j--)
            s->root[j] = s->root[j - 1];
        s->root[j] = r;
    }
    return status;
}

static kn_status seek(kn_ctx *ctx, seeker *s)
{
    size_t m = (size_t)s->degree + 1,
           levels = (size_t)(s->options.max_depth < RESOLUTION ? s->options.max_depth : RESOLUTION) + 2;
    s->stack = kn_scratch(ctx, levels * m, sizeof *s->stack);
    s->nodes = kn_scratch(ctx, levels, sizeof *s->nodes);
    s->line = kn_scratch(ctx, 4 * m, sizeof *s->line);
    if (!s->stack || !s->nodes || !s->line) return KN_ENOMEM;
    kn_status status = KN_OK;
    for (size_t c = 0; c < s->cells->count && status == KN_OK; c++) status = one_cell(ctx, s, c);
    if (status == KN_OK) status = by_place(ctx, s);
    if (status == KN_OK) join(s);
    if (status == KN_OK && !s->root) s->root = kn_alloc(ctx, 0, sizeof *s->root);
    return status == KN_OK && !s->root ? KN_ENOMEM : status;
}

kn_status kn_solve_roots(kn_ctx *ctx, kn_root **roots, size_t *nroots, kn_solve_report *report, const kn_spline *f,
                         const kn_solve_options *options)
{
    kn_cells cells = {0};
    seeker s = {.cells = &cells};
    kn_mark mark = kn_scratch_mark(ctx);
    kn_status status = kn_solve_settle(ctx, &s.options, options);
    if (status == KN_OK && f->coef && (f->nvars != 1 || kn_spline_dim(f) != 1))
        status = kn_fail(ctx, KN_EDOMAIN, "roots: %d variables, dimension %d", f->nvars, kn_spline_dim(f));
    if (status == KN_OK) status = kn_cells_of_splines(ctx, &cells, f, 1, NULL, 0.0);
    s.degree = cells.net.degree[0];
    if (status == KN_OK) status = seek(ctx, &s);
    if (status == KN_OK) {
        *roots = s.root;
        *nroots = s.nroots;
        for (size_t i = 0; i < s.nroots; i++) s.report.possible += s.root[i].kind == KN_ROOT_POSSIBLE;
        if (report) *report = s.report;
    } else {
        kn_free(ctx, s.root);
    }
    kn_cells_clear(ctx, &cells);
    kn_scratch_release(ctx, mark);
    return status;
}
