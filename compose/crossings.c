// SPDX-License-Identifier: Apache-2.0
// Where a function in Bernstein form meets the knots of another spline.
#include "compose/crossings.h"
#include "kernel/bernstein.h"

#include <math.h>
#include <string.h>

static const double slack = 0x1p-40; // of the largest |x|: what rounding leaves beyond a knot counts as on it

enum { MOST_HALVINGS = 52, MOST_BOXES = 2000 };

// ---- lists ----
kn_status kn_numbers_add(kn_ctx *ctx, kn_numbers *numbers, double value)
{
    if (numbers->count == numbers->room) {
        int room = numbers->room > 0 ? 2 * numbers->room : 64;
        double *list = kn_scratch(ctx, (size_t)room, sizeof *list);
        if (!list) return KN_ENOMEM;
        if (numbers->count > 0) memcpy(list, numbers->list, (size_t)numbers->count * sizeof *list);
        *numbers = (kn_numbers){list, numbers->count, room};
    }
    numbers->list[numbers->count++] = value;
    return KN_OK;
}

// Shell sort: no recursion, no allocation.
static void sort(double *x, int n)
{
    for (int gap = n / 2; gap > 0; gap /= 2)
        for (int i = gap; i < n; i++) {
            double value = x[i];
            int j = i;
            for (; j >= gap && x[j - gap] > value; j -= gap) x[j] = x[j - gap];
            x[j] = value;
        }
}

static bool is_among(const double *list, int n, double value)
{
    int lo = 0, hi = n;
    while (lo < hi) {
        int middle = lo + (hi - lo) / 2;
        if (list[middle] < value)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo < n && list[lo] == value;
}

void kn_numbers_merge(kn_numbers *numbers, const double *keep, int nkeep, double near)
{
    int n = 0;
    double *x = numbers->list;
    sort(x, numbers->count);
    for (int i = 0; i < numbers->count; i++) {
        bool kept = is_among(keep, nkeep, x[i]);
        if (n == 0 || x[i] - x[n - 1] > near || (kept && x[i] > x[n - 1] && is_among(keep, nkeep, x[n - 1])))
            x[n++] = x[i];
        else if (kept)
            x[n - 1] = x[i];
    }
    numbers->count = n;
}

double kn_nearness(const double *breaks, int n)
{
    return 0x1p-44 * (breaks[n - 1] - breaks[0]) + 0x1p-51 * fmax(fabs(breaks[0]), fabs(breaks[n - 1]));
}

// ---- one variable alone ----
// Component c of a piece: n numbers X and the weight, NULL for 1.
typedef struct component {
    const double *x, *w;
} component;

static component component_of(const kn_bezier *piece, int c)
{
    size_t n = kn_bezier_count(piece);
    return (component){piece->coef + (size_t)c * n,
                       piece->rational ? piece->coef + (size_t)(piece->ncomp - 1) * n : NULL};
}

// X_i w_first = X_first w_i along every line in the other directions: a line starts at the coefficients of the edge.
static bool separates(double *at_x, double *at_w, const kn_bezier *piece, const component *f, int var)
{
    size_t n = kn_bezier_count(piece), m = (size_t)piece->degree[var] + 1;
    size_t inner = kn_bernstein_count(piece->nvars - var - 1, piece->degree + var + 1);
    const double tiny = 0x1p-46; // a few dozen roundings
    double most = 0.0;
    for (size_t k = 0; k < n; k++) most = fmax(most, fabs(f->x[k]));
    for (size_t i = 0; i < m; i++) {
        at_x[i] = f->x[i * inner];
        at_w[i] = f->w ? f->w[i * inner] : 1.0;
    }
    for (size_t k = 0; k < n; k++) {
        size_t i = k / inner % m, edge = k - i * inner; // the line's end in the direction of var
        double w = f->w ? f->w[k] : 1.0, profile = f->w ? f->w[edge] : 1.0;
        double size = most * (at_w[i] + w);
        if (fabs(f->x[k] * at_w[i] - at_x[i] * w) > tiny * size) return false;
        if (fabs(w * at_w[0] - profile * at_w[i]) > tiny * fabs(w * at_w[0])) return false;
    }
    return true;
}

int kn_depends_alone(double *at_x, double *at_w, const kn_bezier *piece, int c)
{
    component f = component_of(piece, c);
    for (int d = 0; d < piece->nvars; d++)
        if (separates(at_x, at_w, piece, &f, d)) return d;
    return -1;
}

// ---- crossings ----
typedef struct search {
    const double *value; // of the whole polynomial
    int degree;
    double lo, hi; // of the variable
    kn_numbers *out;
} search;

static int sign(double x)
{
    return (x > 0.0) - (x < 0.0);
}

// Changes of sign among n numbers, zeros left out, and the first and last sign.
static int sign_changes(const double *x, int n, int *first, int *last)
{
    int changes = 0;
    *first = *last = 0;
    for (int i = 0; i < n; i++) {
        int s = sign(x[i]);
        if (s == 0) continue;
        if (*first == 0) *first = s;
        changes += *last != 0 && s != *last;
        *last = s;
    }
    return changes;
}

static kn_status add(kn_ctx *ctx, const search *s, double at)
{
    double t = s->lo + at * (s->hi - s->lo);
    return t > s->lo && t < s->hi ? kn_numbers_add(ctx, s->out, t) : KN_OK;
}

// One change of sign is one root (Descartes): bisection until the ends are neighbours.
static double root(const search *s, double lo, double hi, int first)
{
    double basis[KN_MAX_DEGREE + 1];
    for (;;) {
        double middle = lo + (hi - lo) / 2.0, value;
        if (middle <= lo || middle >= hi) return middle;
        kn_bernstein_basis(basis, s->degree, middle);
        kn_bernstein_contract(&value, s->value, 1, s->degree + 1, 1, basis);
        if (value == 0.0) return middle;
        if (sign(value) == first)
            lo = middle;
        else
            hi = middle;
    }
}

static kn_status isolate(kn_ctx *ctx, const search *s, const double *x, double lo, double hi, int depth)
{
    int first, last, changes = sign_changes(x, s->degree + 1, &first, &last);
    if (changes == 0) return KN_OK;
    if (changes == 1) return add(ctx, s, root(s, lo, hi, first));
    double middle = lo + (hi - lo) / 2.0;
    if (depth == MOST_HALVINGS) return first != last ? add(ctx, s, middle) : KN_OK;
    double left[KN_MAX_DEGREE + 1], right[KN_MAX_DEGREE + 1];
    int before, after, unused;
    kn_bernstein_split(left, right, x, 1, s->degree, 1, 0.5);
    sign_changes(left, s->degree + 1, &unused, &before);
    sign_changes(right, s->degree + 1, &after, &unused);
    kn_status status = isolate(ctx, s, left, lo, middle, depth + 1);
    if (status == KN_OK && right[0] == 0.0 && before != after) status = add(ctx, s, middle);
    return status == KN_OK ? isolate(ctx, s, right, middle, hi, depth + 1) : status;
}

kn_status kn_crossings(kn_ctx *ctx, kn_numbers *out, const double *x, const double *w, int degree, double value,
                       double lo, double hi)
{
    double f[KN_MAX_DEGREE + 1];
    search s = {.value = f, .degree = degree, .lo = lo, .hi = hi, .out = out};
    for (int i = 0; i <= degree; i++) f[i] = x[i] - value * (w ? w[i] : 1.0);
    return isolate(ctx, &s, f, 0.0, 1.0, 0);
}

// ---- which span ----
typedef enum verdict { CROSSES, STAYS, OPEN, NO_MEMORY } verdict;

// Whether x >= -tolerance on the whole box, by halving.
static verdict stays(kn_ctx *ctx, const kn_bezier *shape, const double *x, double tolerance, int depth, int *budget)
{
    size_t n = kn_bezier_count(shape);
    size_t corner = 0;
    bool all = true;
    for (size_t i = 0; i < n; i++) all = all && x[i] >= -tolerance;
    if (all) return STAYS;
    for (int k = 0; k < 1 << shape->nvars; k++) {
        corner = 0;
        for (int d = 0; d < shape->nvars; d++)
            corner = corner * ((size_t)shape->degree[d] + 1) + (size_t)((k >> d & 1) * shape->degree[d]);
        if (x[corner] < -tolerance) return CROSSES;
    }
    if (--*budget < 0 || depth == MOST_HALVINGS || shape->nvars == 0) return OPEN;
    int var = depth % shape->nvars;
    verdict answer = NO_MEMORY;
    kn_mark mark = kn_scratch_mark(ctx);
    double *half = kn_scratch(ctx, 2 * n, sizeof *half);
    if (half) {
        kn_bernstein_split(half, half + n, x, kn_bernstein_count(var, shape->degree), shape->degree[var],
                           kn_bernstein_count(shape->nvars - var - 1, shape->degree + var + 1), 0.5);
        answer = stays(ctx, shape, half, tolerance, depth + 1, budget);
        if (answer == STAYS) answer = stays(ctx, shape, half + n, tolerance, depth + 1, budget);
    }
    kn_scratch_release(ctx, mark);
    return answer;
}

// Whether side * (x - value) >= 0 within the tolerance, everywhere.
static verdict lies(kn_ctx *ctx, const kn_bezier *piece, const component *f, double value, double side,
                    double tolerance)
{
    size_t n = kn_bezier_count(piece);
    int budget = MOST_BOXES;
    verdict answer = NO_MEMORY;
    double most = f->w ? 0.0 : 1.0;
    kn_mark mark = kn_scratch_mark(ctx);
    double *x = kn_scratch(ctx, n, sizeof *x);
    for (size_t i = 0; x && i < n; i++) {
        double w = f->w ? f->w[i] : 1.0;
        x[i] = side * (f->x[i] - value * w);
        if (w > most) most = w;
    }
    if (x) answer = stays(ctx, piece, x, tolerance * most, 0, &budget);
    kn_scratch_release(ctx, mark);
    return answer;
}

static void range(double *lo, double *hi, const component *f, size_t n)
{
    *lo = INFINITY, *hi = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        double x = f->w ? f->x[i] / f->w[i] : f->x[i];
        *lo = fmin(*lo, x);
        *hi = fmax(*hi, x);
    }
}

// About the most that x changes when variable d moves by blur[d] of the piece, for all d: a derivative is at most the
// degree times the largest difference of neighbours, times the spread of the weights.
static double change(const kn_bezier *piece, const component *f, const double *blur)
{
    size_t n = kn_bezier_count(piece);
    double sum = 0.0, lightest = INFINITY, heaviest = 0.0;
    for (int d = 0; d < piece->nvars; d++) {
        size_t inner = kn_bernstein_count(piece->nvars - d - 1, piece->degree + d + 1),
               m = (size_t)piece->degree[d] + 1;
        double most = 0.0;
        for (size_t i = 0; i + inner < n; i++) {
            if (i / inner % m == m - 1) continue;
            double a = f->x[i], b = f->x[i + inner];
            most = fmax(most, fabs(f->w ? b / f->w[i + inner] - a / f->w[i] : b - a));
        }
        sum += fmin(blur[d], 1.0) * piece->degree[d] * most;
    }
    for (size_t i = 0; f->w && i < n; i++) lightest = fmin(lightest, f->w[i]), heaviest = fmax(heaviest, f->w[i]);
    return f->w ? sum * heaviest / lightest : sum;
}

kn_status kn_locate(kn_ctx *ctx, const char *call, int *span, const kn_bezier *piece, int c, const double *breaks,
                    int nbreaks, const double *blur)
{
    component f = component_of(piece, c);
    size_t n = kn_bezier_count(piece);
    double lo, hi;
    range(&lo, &hi, &f, n);
    double tolerance = slack * fmax(fabs(lo), fabs(hi)) + change(piece, &f, blur), knot = NAN;
    int s = nbreaks - 2;
    while (s > 0 && lo < breaks[s] - tolerance) s--; // the highest that begins early enough
    *span = s;
    if (s == nbreaks - 2 || hi <= breaks[s + 1] + tolerance) return KN_OK;
    bool open = false;
    for (; s < nbreaks - 1 && (s == 0 || breaks[s] <= hi); s++) { // the control points leave the span: does x?
        verdict above = s == 0 ? STAYS : lies(ctx, piece, &f, breaks[s], 1.0, tolerance);
        verdict below = s == nbreaks - 2 ? STAYS : lies(ctx, piece, &f, breaks[s + 1], -1.0, tolerance);
        if (above == NO_MEMORY || below == NO_MEMORY) return KN_ENOMEM;
        if (above == STAYS && below == STAYS) {
            *span = s;
            return KN_OK;
        }
        open = open || above == OPEN || below == OPEN;
        if (above == STAYS || isnan(knot)) knot = breaks[s + (above == STAYS)];
    }
    if (open) return kn_fail(ctx, KN_EUNDECIDED, "%s: whether component %d crosses the knot %.17g", call, c, knot);
    return kn_fail(ctx, KN_EDOMAIN, "%s: component %d crosses the knot %.17g, and not along a parameter line", call,
                   c, knot);
}
