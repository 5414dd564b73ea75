// SPDX-License-Identifier: Apache-2.0
// Whether patches cover a box: the boundary of a sum of patches that are oriented alike winds round a point as often
// as they cover it, counted with sign, as long as it does not pass through it. Edges that two of them share, run
// opposite ways, are no boundary. Summed are once all bits as they are oriented, where folds count against each
// other, and once those that certainly do not fold, turned to face up; of both each connected part for itself, so
// that one sheet covers a box in which another one ends.
#include "tile/cover.h"
#include "kernel/union_find.h"

#include <float.h>
#include <math.h>

typedef struct sums {
    const kn_tile_net *net;
    const kn_tile_bit *bits;
    const double *lo, *hi;
    int n, level;
    int *slot; // open addressing by what a bit is: 1 + number
    size_t nslots;
    int *parent;
    int8_t *sign; // 0: not in the sum
    bool *open;   // of a part: its boundary meets the box
    double *angle;
} sums;

// ---- bits ----

void kn_tile_bound(kn_tile_bit *bit, const kn_tile_net *net)
{
    size_t n = kn_bezier_count(&net->pieces[bit->piece].surface);
    for (size_t c = 0; c < 2; c++) {
        bit->lo[c] = INFINITY, bit->hi[c] = -INFINITY;
        for (size_t k = 0; k < n; k++) {
            bit->lo[c] = fmin(bit->lo[c], bit->coef[c * n + k]);
            bit->hi[c] = fmax(bit->hi[c], bit->coef[c * n + k]);
        }
        if (bit->lo[c] == bit->hi[c]) continue; // means of equal numbers are exact
        bit->lo[c] -= bit->error[c] * (1.0 + 4.0 * DBL_EPSILON);
        bit->hi[c] += bit->error[c] * (1.0 + 4.0 * DBL_EPSILON);
    }
}

// De Casteljau at 1/2 in place: x becomes the half towards 0, y the other one, n + 1 numbers `step` apart. Whether
// all means were exact: with the short binary fractions of most tiles they are, and then nothing has to be widened.
static bool halve(double *x, double *y, int n, size_t step)
{
    bool exact = true;
    for (int k = 0; k <= n; k++) {
        y[(size_t)(n - k) * step] = x[(size_t)n * step];
        for (int i = n; i > k; i--) {
            double a = x[(size_t)(i - 1) * step], b = x[(size_t)i * step], s = a + b, t = s - a;
            exact = exact && (a - (s - t)) + (b - t) == 0.0;
            x[(size_t)i * step] = 0.5 * s;
        }
    }
    return exact;
}

// Of one direction: out[0] the half towards 0, in place of what it holds, out[1] the other one.
static void halve_all(kn_tile_bit *first, kn_tile_bit *second, const int degree[2], int var)
{
    size_t n = (size_t)(degree[0] + 1) * (size_t)(degree[1] + 1), row = (size_t)degree[1] + 1;
    size_t step = var == 0 ? row : 1, next = var == 0 ? 1 : row, lines = (size_t)degree[1 - var] + 1;
    for (size_t c = 0; c < 2; c++) {
        bool exact = true;
        double most = 0.0;
        for (size_t k = 0; k < n; k++) most = fmax(most, fabs(first->coef[c * n + k]));
        for (size_t i = 0; i < lines; i++) {
            size_t at = c * n + i * next;
            exact = halve(first->coef + at, second->coef + at, degree[var], step) && exact;
        }
        if (!exact) first->error[c] += degree[var] * most * DBL_EPSILON;
        second->error[c] = first->error[c];
    }
    second->piece = first->piece;
    for (int c = 0; c < 2; c++) second->cell[c] = first->cell[c], second->index[c] = first->index[c];
    first->index[var] *= 2;
    second->index[var] = first->index[var] + 1;
}

kn_status kn_tile_quarter(kn_ctx *ctx, kn_tile_bit out[4], const kn_tile_net *net, const kn_tile_bit *bit)
{
    const int *degree = net->pieces[bit->piece].surface.degree;
    size_t n = 2 * kn_bezier_count(&net->pieces[bit->piece].surface);
    for (int k = 0; k < 4; k++)
        if (!(out[k].coef = kn_scratch(ctx, n, sizeof *out[k].coef))) return KN_ENOMEM;
    double *coef = out[0].coef;
    out[0] = *bit;
    out[0].coef = coef;
    for (size_t k = 0; k < n; k++) coef[k] = bit->coef[k];
    halve_all(&out[0], &out[2], degree, 0);
    halve_all(&out[0], &out[1], degree, 1);
    halve_all(&out[2], &out[3], degree, 1);
    for (int k = 0; k < 4; k++) kn_tile_bound(&out[k], net);
    return KN_OK;
}

// +1 or -1 where u_r v_t - u_t v_r certainly has that sign: every difference along r with every one along t. 0 else.
static int8_t facing(const kn_tile_net *net, const kn_tile_bit *bit)
{
    const int *degree = net->pieces[bit->piece].surface.degree;
    int m = degree[0], n = degree[1], row = n + 1, sign = 0;
    double error = fmax(bit->error[0], bit->error[1]);
    const double *u = bit->coef, *v = u + (size_t)(m + 1) * (size_t)row;
    for (int a = 0; a < m * row; a++)
        for (int b = 0; b < (m + 1) * n; b++) {
            int t = b / n * row + b % n;
            double ru = u[a + row] - u[a], rv = v[a + row] - v[a], tu = u[t + 1] - u[t], tv = v[t + 1] - v[t];
            double cross = ru * tv - rv * tu, rr = fabs(ru) + fabs(rv), tt = fabs(tu) + fabs(tv);
            double wrong = 4.0 * DBL_EPSILON * rr * tt + 4.0 * error * (rr + tt + error);
            int one = cross > wrong ? 1 : cross < -wrong ? -1 : 0;
            if (one == 0 || (sign != 0 && one != sign)) return 0;
            sign = one;
        }
    return (int8_t)sign;
}

// ---- sums ----

static bool same_bit(const kn_tile_bit *a, int piece, const int cell[2], const uint32_t index[2])
{
    return a->piece == piece && a->cell[0] == cell[0] && a->cell[1] == cell[1] && a->index[0] == index[0] &&
           a->index[1] == index[1];
}

static size_t find_slot(const sums *s, int piece, const int cell[2], const uint32_t index[2])
{
    uint64_t h = (uint64_t)piece * 0x9E3779B97F4A7C15u;
    h = (h ^ (uint32_t)cell[0]) * 0xBF58476D1CE4E5B9u, h = (h ^ (uint32_t)cell[1]) * 0x94D049BB133111EBu;
    h = (h ^ index[0]) * 0x9E3779B97F4A7C15u, h = (h ^ index[1]) * 0xBF58476D1CE4E5B9u;
    size_t at = (size_t)(h ^ h >> 31) & (s->nslots - 1);
    while (s->slot[at] && !same_bit(&s->bits[s->slot[at] - 1], piece, cell, index)) at = (at + 1) & (s->nslots - 1);
    return at;
}

// The bit beyond side k (2 var + end) of bit i, -1: not in the list; whether r x t of the two face alike.
static int beyond(const sums *s, int i, int k, bool *alike)
{
    const kn_tile_bit *b = &s->bits[i];
    uint32_t last = (uint32_t)((1u << s->level) - 1), index[2] = {b->index[0], b->index[1]};
    int var = k / 2, piece = b->piece, cell[2] = {b->cell[0], b->cell[1]};
    *alike = true;
    if (index[var] == (k % 2 ? last : 0)) {
        const kn_tile_side *side = &s->net->sides[4 * piece + k];
        if (side->mate < 0 || s->net->sides[side->mate].mate != 4 * piece + k) return -1;
        int to = side->mate % 4;
        uint32_t along = index[1 - var];
        const kn_tile_piece *list = s->net->pieces;
        bool both = list[piece].inwards == list[side->mate / 4].inwards;
        *alike = kn_tile_side_agrees(s->net, 4 * piece + k) == both;
        piece = side->mate / 4;
        cell[0] += side->offset[0], cell[1] += side->offset[1];
        index[to / 2] = to % 2 ? last : 0;
        index[1 - to / 2] = side->reversed ? last - along : along;
    } else
        index[var] += k % 2 ? 1 : (uint32_t)-1;
    return s->slot[find_slot(s, piece, cell, index)] - 1;
}

// The bit beyond a side that cancels it, or -1.
static int partner(const sums *s, int i, int k)
{
    bool alike;
    int j = beyond(s, i, k, &alike);
    return j >= 0 && s->sign[j] != 0 && alike == (s->sign[i] == s->sign[j]) ? j : -1;
}

// Adds a side of a bit's boundary: whether it meets the box, else the angle from end to end round the box's middle,
// which is less than half a turn, for the side lies in a box beside it.
static void add_side(sums *s, int i, int k)
{
    const kn_tile_bit *b = &s->bits[i];
    const kn_tile_piece *piece = &s->net->pieces[b->piece];
    int m = piece->surface.degree[0], n = piece->surface.degree[1], row = n + 1;
    int points = k / 2 ? m : n, start = k == 1 ? m * row : k == 3 ? n : 0, step = k / 2 ? row : 1;
    uint32_t last = (uint32_t)((1u << s->level) - 1);
    if (s->net->sides[4 * b->piece + k].point && b->index[k / 2] == (k % 2 ? last : 0)) return;
    const double *u = b->coef + start, *v = u + (size_t)(m + 1) * (size_t)row;
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY}, p[2], q[2];
    for (int j = 0; j <= points; j++) {
        lo[0] = fmin(lo[0], u[j * step]), hi[0] = fmax(hi[0], u[j * step]);
        lo[1] = fmin(lo[1], v[j * step]), hi[1] = fmax(hi[1], v[j * step]);
    }
    int part = kn_class_root(s->parent, i);
    bool beside = false;
    for (int c = 0; c < 2; c++) {
        double wrong = lo[c] == hi[c] ? 0.0 : b->error[c] * (1.0 + 4.0 * DBL_EPSILON), move = b->cell[c];
        beside = beside || hi[c] + wrong + move <= s->lo[c] || lo[c] - wrong + move >= s->hi[c];
    }
    if (!beside) s->open[part] = true;
    for (int c = 0; c < 2; c++) {
        double middle = 0.5 * (s->lo[c] + s->hi[c]) - b->cell[c];
        p[c] = (c ? v : u)[0] - middle;
        q[c] = (c ? v : u)[points * step] - middle;
    }
    double turn = atan2(p[0] * q[1] - p[1] * q[0], p[0] * q[0] + p[1] * q[1]);
    s->angle[part] += (k == 1 || k == 2) ? s->sign[i] * turn : -s->sign[i] * turn;
}

static bool sum_covers(sums *s)
{
    for (int i = 0; i < s->n; i++) s->parent[i] = i, s->open[i] = false, s->angle[i] = 0.0;
    for (int i = 0; i < s->n; i++)
        for (int k = 0; s->sign[i] && k < 4; k++) {
            int j = partner(s, i, k);
            if (j >= 0) kn_class_unite(s->parent, i, j);
        }
    for (int i = 0; i < s->n; i++)
        for (int k = 0; s->sign[i] && k < 4; k++)
            if (partner(s, i, k) < 0) add_side(s, i, k);
    const double half = acos(-1.0);
    for (int i = 0; i < s->n; i++)
        if (s->sign[i] && kn_class_root(s->parent, i) == i && !s->open[i] && fabs(s->angle[i]) > half) return true;
    return false;
}

kn_status kn_tile_covers_box(kn_ctx *ctx, bool *yes, const kn_tile_net *net, const kn_tile_bit *bits, int n,
                             int level, const double lo[2], const double hi[2])
{
    sums s = {.net = net, .bits = bits, .lo = lo, .hi = hi, .n = n, .level = level, .nslots = 4};
    while (s.nslots < 2 * (size_t)n) s.nslots *= 2;
    kn_mark mark = kn_scratch_mark(ctx);
    s.slot = kn_scratch(ctx, s.nslots, sizeof *s.slot);
    s.parent = kn_scratch(ctx, (size_t)n, sizeof *s.parent);
    s.sign = kn_scratch(ctx, (size_t)n, sizeof *s.sign);
    s.open = kn_scratch(ctx, (size_t)n, sizeof *s.open);
    s.angle = kn_scratch(ctx, (size_t)n, sizeof *s.angle);
    kn_status status = s.slot && s.parent && s.sign && s.open && s.angle ? KN_OK : KN_ENOMEM;
    if (status == KN_OK) {
        for (size_t k = 0; k < s.nslots; k++) s.slot[k] = 0;
        for (int i = 0; i < n; i++) s.slot[find_slot(&s, bits[i].piece, bits[i].cell, bits[i].index)] = i + 1;
        for (int i = 0; i < n; i++) s.sign[i] = net->pieces[bits[i].piece].inwards ? -1 : 1;
        *yes = sum_covers(&s);
        for (int i = 0; i < n && !*yes; i++) s.sign[i] = facing(net, &bits[i]);
        *yes = *yes || sum_covers(&s);
    }
    kn_scratch_release(ctx, mark);
    return status;
}
