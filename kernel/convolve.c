// SPDX-License-Identifier: Apache-2.0
// Products of coefficient arrays: how they are cut, the variables before the last two, and the choice of the machine.
#include "kernel/convolve_plane.h"

#include <string.h>

#include "kernel/bernstein.h"
#include "kernel/binomial.h"

kn_convolve_level kn_convolve_best(void)
{
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq"))
        return KN_CONVOLVE_AVX512;
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return KN_CONVOLVE_AVX2;
#endif
    return KN_CONVOLVE_SSE2;
}

const char *kn_convolve_level_name(kn_convolve_level level)
{
    static const char *const names[] = {"SSE2", "AVX2", "AVX-512"};
    return (unsigned)level < KN_CONVOLVE_LEVELS ? names[level] : "?";
}

static const kn_convolve_kernels *kernels_of(kn_convolve_level level)
{
#if defined(__x86_64__)
    if (level == KN_CONVOLVE_AVX512) return &kn_convolve_avx512;
    if (level == KN_CONVOLVE_AVX2) return &kn_convolve_avx2;
#endif
    (void)level;
    return &kn_convolve_sse2;
}

// ---- how a product is cut ----
typedef struct cut {
    int parts, part, vectors, columns, rows;
    float cost; // per row of thin and row of wide, in multiply-adds of vectors
} cut;

// W vectors hold a part of n numbers shifted by 0 .. W lanes - n, hence that many columns and one more. Beside the
// multiply-adds a row of wide costs W additions to c (loads and stores: 3 W), moves of the sums and some overhead.
static void try_cut(cut *best, int lanes, int parts, int part, int vectors, int rows, int columns)
{
    cut c = {parts, part, vectors, lanes * vectors - part + 1, kn_plane_rows(lanes, vectors), 0.0f};
    if (c.rows == 0) return;
    if (c.columns > columns) c.columns = columns;
    if (c.rows > rows) c.rows = rows;
    float w = (float)vectors, r = (float)c.rows;
    float block = r * w * (float)c.columns + 3.0f * w + 0.3f * r * w + 4.0f;
    c.cost = (float)parts * block * (float)columns / (r * (float)c.columns);
    if (c.cost < best->cost) *best = c;
}

// rows, columns: of the thin operand; wide: columns of the other.
static void choose_cut(cut *best, int lanes, int rows, int columns, int wide)
{
    best->cost = 1e30f;
    if (columns + wide - 1 <= lanes) {
        try_cut(best, lanes, 1, wide, 1, rows, columns);
    } else {
        int widest = lanes == 8 ? KN_PLANE_VECTORS : 4, parts = 1;
        while (parts * widest * lanes < wide) parts++;
        for (int more = 0; more < 2; more++, parts++) {
            int part = parts == 1 ? wide : (wide + parts - 1) / parts, least = (part + lanes - 1) / lanes;
            try_cut(best, lanes, parts, part, least, rows, columns);
            try_cut(best, lanes, parts, part, least + 1, rows, columns);
            if (best->columns == columns) break; // one sweep sees all columns
        }
    }
    if (best->rows < rows) { // blocks of nearly equal height
        int blocks = (rows + best->rows - 1) / best->rows;
        best->rows = (rows + blocks - 1) / blocks;
    }
}

// Of `all` indices in groups of `size` the groups that a run of `pairs` indices meets, at most.
static int groups(int all, int size, int pairs)
{
    int most = (all + size - 1) / size, met = (pairs + size - 2) / size + 1;
    return met < most ? met : most;
}

// How many rounded additions a term meets: at most rows x columns in a block, one where even and odd columns are put
// together, and one for each block of rows and of columns (or part) that gives to the same number, r and c pairs of
// rows and columns being its terms. With the blocks of rows put together aside the last is a sum instead of a product.
// M planes in a sum: for all degrees up to 56 and all machines 20 + M (r + c + 40) is enough, as kernel/convolve.h says
// (tests/kernel/t_convolve.c counts).
static bool puts_aside(const kn_convolution *p, int rows, int sum_rows)
{
    int n = p->nvars - 1, columns = p->thin[n] + 1, r = sum_rows + 1 - rows, c = p->wide[n] + 1;
    if (rows < r) r = rows;
    if (columns < c) c = columns;
    int met = groups(rows, p->rows, r) * (groups(columns, p->columns, c) + p->parts - 1);
    return sum_rows <= KN_ASIDE_ROWS && met > r + c + 40;
}

static size_t whole(size_t n)
{
    return (n + 7) / 8 * 8;
}

void kn_convolution_init(kn_convolution *p, kn_convolve_level level, int nvars, const int *da, const int *db)
{
    int n = nvars < 1 ? 1 : nvars, lanes = 2 << (int)level, zero = 0;
    if (nvars < 1) da = db = &zero;
    int rows_a = n > 1 ? da[n - 2] + 1 : 1, rows_b = n > 1 ? db[n - 2] + 1 : 1;
    int columns_a = da[n - 1] + 1, columns_b = db[n - 1] + 1;
    cut c, other;
    choose_cut(&c, lanes, rows_a, columns_a, columns_b);
    p->level = level, p->nvars = n, p->swapped = false;
    if (rows_a != rows_b || columns_a != columns_b) {
        choose_cut(&other, lanes, rows_b, columns_b, columns_a);
        p->swapped = other.cost < c.cost;
        if (p->swapped) c = other;
    }
    const int *thin = p->swapped ? db : da, *wide = p->swapped ? da : db;
    for (int d = 0; d < n; d++) p->thin[d] = thin[d], p->wide[d] = wide[d], p->sum[d] = thin[d] + wide[d];
    p->parts = c.parts, p->part = c.part, p->vectors = c.vectors, p->columns = c.columns, p->rows = c.rows;
    p->aside = n > 1 && puts_aside(p, p->thin[n - 2] + 1, p->sum[n - 2] + 1);
    p->before = whole((size_t)c.columns - 1);
    p->padded = p->before + whole((size_t)(lanes * c.vectors));
    p->thin_room = whole((size_t)thin[n - 1] + 1);
    p->wide_room = (size_t)c.parts * p->padded;
    p->sum_room = whole((size_t)p->sum[n - 1] + 1);
    p->thin_step[n - 1] = p->wide_step[n - 1] = p->sum_step[n - 1] = 1;
    for (int d = n - 2; d >= 0; d--) {
        p->thin_step[d] = p->thin_room, p->thin_room *= (size_t)thin[d] + 1;
        p->wide_step[d] = p->wide_room, p->wide_room *= (size_t)wide[d] + 1;
        p->sum_step[d] = p->sum_room, p->sum_room *= (size_t)p->sum[d] + 1;
    }
    p->sum_room += 8; // which the last vector may reach into
}

void kn_convolution_clear(const kn_convolution *p, double *sums)
{
    memset(sums, 0, p->sum_room * sizeof *sums);
}

// ---- packing, and division by the binomials: one plane after another ----
enum { MOST = KN_MAX_DEGREE + 1 + 8 };
#define ONES_8 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0
static const double ones[MOST + 7] = {ONES_8, ONES_8, ONES_8, ONES_8, ONES_8, ONES_8, ONES_8, ONES_8, ONES_8};

// The weights of the last two variables. Structs are filled where they lie: small products feel every copy.
static void last_two(kn_weighed *w, int nvars, const int *degree, const size_t *step, const size_t *packed_step,
                     bool scaled)
{
    int n = degree[nvars - 1], m = nvars > 1 ? degree[nvars - 2] : 0;
    w->rows = m + 1, w->columns = n + 1;
    w->step = nvars > 1 ? step[nvars - 2] : 0, w->packed_step = nvars > 1 ? packed_step[nvars - 2] : 0;
    w->column = scaled ? kn_pascal(n) : ones, w->column_inverse = kn_pascal_inverse(n);
    w->row = scaled ? kn_pascal(m) : ones, w->row_inverse = kn_pascal_inverse(m);
    w->before = w->before_inverse = 1.0;
}

// Planes of an array and of its packed counterpart, one index of the leading variables after the other.
typedef struct walk {
    int index[KN_MAX_VARS];
    const size_t *step, *packed_step;
    size_t at, packed_at;
} walk;

static void start(walk *k, int nvars, const size_t *step, const size_t *packed_step)
{
    k->step = step, k->packed_step = packed_step, k->at = k->packed_at = 0;
    for (int d = 0; d < nvars - 2; d++) k->index[d] = 0;
}

// The next plane and what its leading variables weigh; false after the last one.
static bool advance(walk *k, kn_weighed *w, int nvars, const int *degree, bool scaled)
{
    int d = nvars - 3;
    for (; d >= 0; d--) {
        k->at += k->step[d], k->packed_at += k->packed_step[d];
        if (++k->index[d] <= degree[d]) break;
        k->at -= (size_t)k->index[d] * k->step[d], k->packed_at -= (size_t)k->index[d] * k->packed_step[d];
        k->index[d] = 0;
    }
    if (d < 0) return false;
    w->before = w->before_inverse = 1.0;
    for (d = 0; d < nvars - 2 && scaled; d++) {
        w->before *= kn_pascal(degree[d])[k->index[d]];
        w->before_inverse *= kn_pascal_inverse(degree[d])[k->index[d]];
    }
    return true;
}

void kn_convolution_pack_thin(const kn_convolution *p, double *thin, const double *from, const size_t *step,
                              bool scaled)
{
    kn_weighed w;
    walk k;
    last_two(&w, p->nvars, p->thin, step, p->thin_step, scaled);
    start(&k, p->nvars, step, p->thin_step);
    do kernels_of(p->level)->pack(thin + k.packed_at, from + k.at, &w, w.columns, 0, whole((size_t)w.columns));
    while (advance(&k, &w, p->nvars, p->thin, scaled));
}

void kn_convolution_pack_wide(const kn_convolution *p, double *wide, const double *from, const size_t *step,
                              bool scaled)
{
    kn_weighed w;
    walk k;
    last_two(&w, p->nvars, p->wide, step, p->wide_step, scaled);
    start(&k, p->nvars, step, p->wide_step);
    do kernels_of(p->level)->pack(wide + k.packed_at, from + k.at, &w, p->part, p->before, p->padded);
    while (advance(&k, &w, p->nvars, p->wide, scaled));
}

// x / d for d a product of N binomials, below 2^44, by r = the product of their reciprocals, |d r - 1| <= (2 N - 1) u:
// q = fl(x r), e = x - q d, q' = fl(q + e r). e is a multiple of the product of the last places of q and d, and below
// 2^53 of them: the fused operation gives it exactly. q + e r = x / d + (q - x / d)(1 - d r) differs from x / d by at
// most 2 N (2 N - 1) u^2 |x / d|, up to terms in u^3, 2^-98 for N <= 8. An x / d that is no double lies no nearer than
// 2^-54 / d |x / d| to the middle of two doubles (mid d - x is a multiple of mid's last place, and mid d = x would
// need 54 bits in x). Hence q' is x / d rounded to nearest, and x / d itself where that is a double (Markstein,
// Computation of elementary functions on the IBM RISC System/6000 processor, IBM J. R. D. 34, 1990).
// For larger d the same steps leave the roundings of d, one more, and terms in u^2.
void kn_convolution_divide(const kn_convolution *p, double *out, const size_t *step, const double *sums)
{
    kn_weighed w;
    walk k;
    last_two(&w, p->nvars, p->sum, step, p->sum_step, true);
    start(&k, p->nvars, step, p->sum_step);
    do kernels_of(p->level)->divide(out + k.at, sums + k.packed_at, &w);
    while (advance(&k, &w, p->nvars, p->sum, true));
}

// ---- products: the variables before the last two ----
static void run_from(const kn_convolution *p, int d, double *sums, const double *thin, const double *wide,
                     const kn_plane *plane)
{
    if (p->nvars - d <= 2) {
        kernels_of(p->level)->plane(sums, thin, wide, p, plane);
        return;
    }
    for (size_t i = 0; i <= (size_t)p->thin[d]; i++)
        for (size_t k = 0; k <= (size_t)p->wide[d]; k++)
            run_from(p, d + 1, sums + (i + k) * p->sum_step[d], thin + i * p->thin_step[d],
                     wide + k * p->wide_step[d], plane);
}

void kn_convolution_run(const kn_convolution *p, double *sums, const double *thin, const double *wide, double sign)
{
    int n = p->nvars;
    kn_plane plane = {1, p->thin[n - 1] + 1, 1, p->wide[n - 1] + 1, 0, 0, 0, sign};
    if (n > 1) {
        plane.thin_rows = p->thin[n - 2] + 1, plane.wide_rows = p->wide[n - 2] + 1;
        plane.sum_step = p->sum_step[n - 2], plane.thin_step = p->thin_step[n - 2];
        plane.wide_step = p->wide_step[n - 2];
    }
    run_from(p, 0, sums, thin, wide, &plane);
}

// ---- dense arrays ----
static void dense_steps(size_t *step, int nvars, const int *degree)
{
    step[nvars < 1 ? 0 : nvars - 1] = 1;
    for (int d = nvars - 2; d >= 0; d--) step[d] = step[d + 1] * ((size_t)degree[d + 1] + 1);
}

size_t kn_convolve_work(int nvars, const int *da, const int *db)
{
    kn_convolution p;
    kn_convolution_init(&p, kn_convolve_best(), nvars, da, db);
    return p.thin_room + p.wide_room + p.sum_room;
}

// Rows of c, dense, and of the sums.
static void add_rows(double *c, const kn_convolution *p, const double *sums)
{
    int n = p->nvars, index[KN_MAX_VARS] = {0};
    size_t columns = (size_t)p->sum[n - 1] + 1, at = 0;
    for (;; c += columns) {
        for (size_t j = 0; j < columns; j++) c[j] += sums[at + j];
        int d = n - 2;
        for (; d >= 0; d--) {
            at += p->sum_step[d];
            if (++index[d] <= p->sum[d]) break;
            at -= (size_t)index[d] * p->sum_step[d];
            index[d] = 0;
        }
        if (d < 0) return;
    }
}

void kn_convolve_as(kn_convolve_level level, double *c, int nvars, const double *a, const int *da, const double *b,
                    const int *db, double sign, double *work)
{
    kn_convolution p;
    kn_convolution_init(&p, level, nvars, da, db);
    size_t step[KN_MAX_VARS];
    double *thin = work, *wide = thin + p.thin_room, *sums = wide + p.wide_room;
    dense_steps(step, p.nvars, p.thin);
    kn_convolution_pack_thin(&p, thin, p.swapped ? b : a, step, false);
    dense_steps(step, p.nvars, p.wide);
    kn_convolution_pack_wide(&p, wide, p.swapped ? a : b, step, false);
    kn_convolution_clear(&p, sums);
    kn_convolution_run(&p, sums, thin, wide, sign);
    add_rows(c, &p, sums);
}

void kn_convolve(double *c, int nvars, const double *a, const int *da, const double *b, const int *db, double sign,
                 double *work)
{
    kn_convolve_as(kn_convolve_best(), c, nvars, a, da, b, db, sign, work);
}

// Variable by variable, the first one outermost; the places in c add as the indices do.
void kn_convolve_plain(double *c, int nvars, const double *a, const int *da, const double *b, const int *db,
                       double sign)
{
    if (nvars == 0) {
        c[0] += sign * (a[0] * b[0]);
        return;
    }
    size_t step_a = kn_bernstein_count(nvars - 1, da + 1), step_b = kn_bernstein_count(nvars - 1, db + 1), step_c = 1;
    for (int d = 1; d < nvars; d++) step_c *= (size_t)da[d] + (size_t)db[d] + 1;
    for (size_t i = 0; i <= (size_t)da[0]; i++)
        for (size_t j = 0; j <= (size_t)db[0]; j++)
            kn_convolve_plain(c + (i + j) * step_c, nvars - 1, a + i * step_a, da + 1, b + j * step_b, db + 1, sign);
}
