// SPDX-License-Identifier: Apache-2.0
// The knot boxes of S that a patch meets, and the pieces of the shell over them.
#include "job/cross.h"

#include <math.h>

// Composition in the coordinates of a box loses this factor at most where D reaches beyond it: the sum of the
// Bernstein polynomials' absolute values there.
#define MOST_GROWTH 4096.0

static void range(double *lo, double *hi, const kn_bezier *d, int c)
{
    size_t n = kn_bezier_count(d);
    const double *x = d->coef + (size_t)c * n;
    *lo = *hi = x[0];
    for (size_t i = 1; i < n; i++) {
        *lo = fmin(*lo, x[i]);
        *hi = fmax(*hi, x[i]);
    }
}

// Whether the cells on both sides of line `at` are of one width: a tile that reaches over it is not bent there.
static bool is_even(const kn_job_surface *s, int var, int at)
{
    const double *line = s->lines[var];
    int before = at > 0 ? at - 1 : s->cells[var] - 1, after = at < s->cells[var] ? at : 0;
    double a = line[before + 1] - line[before], b = line[after + 1] - line[after];
    return fabs(a - b) <= 1e-12 * fmax(fabs(line[0]), fabs(line[s->cells[var]])) + 1e-12 * fmax(a, b);
}

bool kn_job_is_knot(const kn_job *job, const kn_job_surface *s, const int cell[2], int var, double line)
{
    int at = cell[var] + (int)line, n = s->cells[var];
    if (s->closed[var]) at = (at % n + n) % n;
    if (at < 0 || at > n || (!s->closed[var] && (at == 0 || at == n))) return false;
    return s->knot[var][at] || (job->options.crossing != KN_CROSSING_REFUSE && !is_even(s, var, at));
}

void kn_crossing_init(bool *yes, kn_crossing *x, kn_job_cell_plan *plan, const kn_job_leaf *leaf,
                      const kn_job_place *place, const kn_bezier *d)
{
    const kn_job_surface *s = &plan->job->surfaces[place->surface];
    double w[2];
    *x = (kn_crossing){.plan = plan, .leaf = leaf, .place = place, .d = d};
    *yes = true;
    for (int c = 0; c < 2; c++) range(&x->lo[c], &x->hi[c], d, c);
    kn_job_clip_ends(x->end, plan->job, place);
    bool clips = kn_job_clip_box(x->lo, x->hi, (const double(*)[2])x->end) == KN_CLIP_ACROSS;
    for (int c = 0; c < 2; c++) {
        if (!clips || !(x->lo[c] < x->end[c][0])) x->end[c][0] = -INFINITY;
        if (!clips || !(x->hi[c] > x->end[c][1])) x->end[c][1] = INFINITY;
        for (double line = floor(x->lo[c]) + 1.0; line < x->hi[c]; line += 1.0) {
            if (!kn_job_is_knot(plan->job, s, place->cell, c, line)) continue;
            if (x->n[c] == KN_CROSS_LINES)
                *yes = false;
            else
                x->line[c][x->n[c]++] = line;
        }
    }
    range(&w[0], &w[1], d, 2);
    x->top = fmax(fabs(w[0]), fabs(w[1]));
}

// How close around D: all of a cell, where the patch meets one cell of it; sides on multiples of an eighth; or of a
// power of two that is an eighth to a quarter of D's width (kn_job_box).
typedef enum reach { WHOLE, EIGHTHS, CLOSE, REACHES } reach;

static double step_of(const kn_crossing *x, int var, reach how)
{
    int exponent;
    (void)frexp(fmax((x->hi[var] - x->lo[var]) / 4.0, 0x1p-10), &exponent);
    return how == CLOSE && exponent - 1 < -3 ? ldexp(1.0, exponent - 1) : 0.125;
}

// The interval of the box in one variable, between the knots, and the ends at which D is cut off.
static void interval(double *lo, double *hi, int *shift, const kn_crossing *x, int var, int k, reach how)
{
    double from = k > 0 ? x->line[var][k - 1] : x->end[var][0], to = k < x->n[var] ? x->line[var][k] : x->end[var][1];
    double step = step_of(x, var, how);
    double a = fmax(floor(x->lo[var] / step) * step, from), b = fmin(ceil(x->hi[var] / step) * step, to);
    const kn_job_surface *s = &x->plan->job->surfaces[x->place->surface];
    double first = -x->place->cell[var], last = first + s->cells[var] - 1;
    if (!(b > a)) { // D lies on a line of steps, and on no knot
        if (!s->closed[var] && a == last + 1.0)
            a -= step;
        else
            b = a + step;
    }
    double cell = floor(a);
    if (!s->closed[var]) cell = fmin(fmax(cell, first), last); // the end cells go on beyond the domain
    if (how == WHOLE && a >= cell && b <= cell + 1.0) a = cell, b = cell + 1.0;
    *shift = (int)cell;
    *lo = a - cell, *hi = b - cell;
}

void kn_crossing_map(double origin[2], double width[2], const kn_crossing *x, int i, int j)
{
    const kn_job_piece *p = &x->plan->pieces.list[x->piece[i][j]];
    for (int c = 0; c < 2; c++) {
        origin[c] = p->lo[c] + x->shift[i][j][c];
        width[c] = p->hi[c] - p->lo[c];
    }
}

static double growth(const kn_crossing *x, int i, int j)
{
    const kn_shell_piece *piece = &x->plan->pieces.list[x->piece[i][j]].piece;
    double origin[2], width[2], most = 1.0;
    kn_crossing_map(origin, width, x, i, j);
    for (int t = 0; t < piece->nterms; t++) {
        double product = 1.0;
        for (int c = 0; c < 2; c++) {
            double a = (x->lo[c] - origin[c]) / width[c], b = (x->hi[c] - origin[c]) / width[c];
            double size = fmax(fabs(a) + fabs(1.0 - a), fabs(b) + fabs(1.0 - b));
            product *= pow(size, piece->term[t].degree[c]);
        }
        most = fmax(most, product);
    }
    return most;
}

// Whether the weight stays positive over all of D, also where it reaches beyond the box.
static kn_status weight_stays(kn_ctx *ctx, bool *yes, const kn_crossing *x, int i, int j)
{
    const kn_shell_piece *piece = &x->plan->pieces.list[x->piece[i][j]].piece;
    kn_bezier weight = {0};
    *yes = true;
    if (!piece->term[0].rational) return KN_OK;
    double origin[2], width[2], lo, hi, from[2], to[2];
    kn_crossing_map(origin, width, x, i, j);
    for (int c = 0; c < 2; c++) {
        from[c] = (x->lo[c] - origin[c]) / width[c];
        to[c] = (x->hi[c] - origin[c]) / width[c];
    }
    kn_status status = kn_bezier_components(ctx, &weight, &piece->term[0], 3, 1);
    if (status == KN_OK) status = kn_bezier_box(ctx, &lo, &hi, &weight, from, to);
    *yes = status == KN_OK && lo > 0.0;
    kn_bezier_clear(ctx, &weight);
    return status;
}

static kn_status try_piece(kn_ctx *ctx, bool *fits, kn_crossing *x, int i, int j, reach how)
{
    const int at[2] = {i, j};
    double lo[2], hi[2];
    kn_job_place place = *x->place;
    for (int c = 0; c < 2; c++) {
        interval(&lo[c], &hi[c], &x->shift[i][j][c], x, c, at[c], how);
        place.cell[c] += x->shift[i][j][c];
    }
    kn_status status = kn_job_pieces_get(ctx, &x->piece[i][j], &x->plan->pieces, &place, lo, hi);
    if (status != KN_OK) return status;
    *fits = x->plan->pieces.list[x->piece[i][j]].fits && growth(x, i, j) <= MOST_GROWTH;
    return *fits ? weight_stays(ctx, fits, x, i, j) : KN_OK;
}

// Over a whole cell where there is a piece, and else ever more closely around D: n may be no single polynomial over
// the cell, and beyond the domain S may turn faster than anywhere on it.
kn_status kn_crossing_piece(kn_ctx *ctx, bool *fits, kn_crossing *x, int i, int j)
{
    kn_status status = KN_OK;
    *fits = false;
    for (reach how = WHOLE; status == KN_OK && !*fits && how < REACHES; how++)
        status = try_piece(ctx, fits, x, i, j, how);
    return status;
}

kn_status kn_crossing_pieces(kn_ctx *ctx, bool *fit, kn_crossing *x)
{
    kn_status status = KN_OK;
    *fit = true;
    for (int i = 0; i <= x->n[0]; i++)
        for (int j = 0; status == KN_OK && *fit && j <= x->n[1]; j++) status = kn_crossing_piece(ctx, fit, x, i, j);
    return status;
}
