// SPDX-License-Identifier: Apache-2.0
// Lower degrees, on raw arrays.
#include "kernel/reduce.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include <knurl/base.h>

#include "kernel/banded.h"
#include "kernel/binomial.h"
#include "kernel/exact.h"

size_t kn_projection_room(int rows, int columns, int width)
{
    return (size_t)columns * (size_t)width + 2 * (size_t)rows * (size_t)width + (size_t)width;
}

// Weight k of row i of E.
static double weight(const kn_band *e, int i, int k)
{
    double w = e->w[(size_t)i * (size_t)e->width + (size_t)k];
    return e->divisor != 0.0 && e->terms[i] > 1 ? w / e->divisor : w;
}

void kn_projection_factor(kn_projection *p, const kn_band *e, int columns, int fixed, double *room)
{
    size_t width = (size_t)e->width;
    *p = (kn_projection){.e = e, .columns = columns, .fixed = columns > 1 ? fixed : 0, .r = room};
    p->turns = room + (size_t)columns * width;
    p->row = p->turns + 2 * (size_t)e->rows * width;
    memset(room, 0, kn_projection_room(e->rows, columns, e->width) * sizeof *room);
    int cut = p->fixed, free = columns - 2 * cut; // unknowns: columns cut .. columns - cut - 1
    for (int i = cut; i < e->rows - cut; i++) {
        int first = e->first[i] > cut ? e->first[i] - cut : 0;
        memset(p->row, 0, width * sizeof *p->row);
        for (int k = 0; k < e->terms[i]; k++) {
            int column = e->first[i] + k - cut;
            if (column >= 0 && column < free) p->row[column - first] = weight(e, i, k);
        }
        kn_banded_turn_row(p->r, free, e->width, p->row, first, p->turns + 2 * (size_t)i * width);
    }
}

void kn_projection_solve(const kn_projection *p, double *d, const double *b, size_t inner, double *work)
{
    const kn_band *e = p->e;
    int cut = p->fixed, free = p->columns - 2 * cut;
    double *x = d + (size_t)cut * inner;
    if (free <= 0) return;
    memset(x, 0, (size_t)free * inner * sizeof *x);
    for (int i = cut; i < e->rows - cut; i++) {
        memcpy(work, b + (size_t)i * inner, inner * sizeof *work);
        for (int k = 0; k < e->terms[i] && cut > 0; k++) {
            int column = e->first[i] + k;
            if (column >= cut && column < p->columns - cut) continue;
            const double *known = d + (size_t)column * inner;
            for (size_t q = 0; q < inner; q++) work[q] -= weight(e, i, k) * known[q];
        }
        int first = e->first[i] > cut ? e->first[i] - cut : 0;
        kn_banded_turn_data(x, free, e->width, work, first, p->turns + 2 * (size_t)i * (size_t)e->width, inner);
    }
    kn_banded_back(p->r, free, e->width, x, inner);
}

// C(n,i) b_i = sum_k C(m,k) C(n-m,i-k) p_k.
void kn_bernstein_elevation(kn_band *e, int m, int n)
{
    e->rows = n + 1, e->width = m + 1, e->divisor = 0.0;
    for (int i = 0; i <= n; i++) {
        int first = i > n - m ? i - (n - m) : 0, last = i < m ? i : m;
        e->first[i] = first, e->terms[i] = last - first + 1;
        for (int k = first; k <= last; k++)
            e->w[(size_t)i * (size_t)(m + 1) + (size_t)(k - first)] = kn_binomial(m, k) * kn_binomial(n - m, i - k) /
                                                                      kn_binomial(n, i);
    }
}

// The first `count` numbers C(m,k) p_k from the equations above, one after the other; step -1 reads b from its end.
static void from_end(double *scaled, int count, int m, const double *b, int n, int step)
{
    for (int i = 0; i < count; i++) {
        double sum = kn_binomial(n, i) * b[i * step];
        for (int k = 0; k < i; k++) sum -= kn_binomial(n - m, i - k) * scaled[k];
        scaled[i] = sum;
    }
}

void kn_bernstein_lower(double *p, int m, const double *b, int n)
{
    double scaled[KN_MAX_DEGREE + 1];
    int left = (m + 1) / 2, right = m + 1 - left;
    from_end(scaled, left, m, b, n, 1);
    for (int k = 0; k < left; k++) p[k] = scaled[k] / kn_binomial(m, k);
    from_end(scaled, right, m, b + n, n, -1);
    for (int k = 0; k < right; k++) p[m - k] = scaled[k] / kn_binomial(m, k);
}

bool kn_bernstein_is_elevated(const double *b, int n, const double *p, int m)
{
    double factor[KN_EXACT_TERMS], zero[KN_EXACT_TERMS] = {0}, value[KN_EXACT_TERMS];
    assert(n + 2 <= KN_EXACT_TERMS);
    for (int i = 0; i <= n; i++) {
        int terms = 0, first = i > n - m ? i - (n - m) : 0, last = i < m ? i : m;
        factor[terms] = -kn_binomial(n, i), value[terms++] = b[i];
        for (int k = first; k <= last; k++) // exact: it is at most C(n,i)
            factor[terms] = kn_binomial(m, k) * kn_binomial(n - m, i - k), value[terms++] = p[k];
        if (!kn_exact_zero(factor, zero, value, terms)) return false;
    }
    return true;
}

double kn_bernstein_misfit(const double *b, int n, const double *p, int m)
{
    double most = 0.0;
    for (int i = 0; i <= n; i++) {
        int first = i > n - m ? i - (n - m) : 0, last = i < m ? i : m;
        double sum = 0.0;
        for (int k = first; k <= last; k++) sum += kn_binomial(m, k) * kn_binomial(n - m, i - k) * p[k];
        double off = fabs(sum / kn_binomial(n, i) - b[i]);
        if (off > most || isnan(off)) most = off;
    }
    return most;
}

// In powers of t the coefficient j is C(n,j) times the j-th difference of b at 0.
int kn_bernstein_degree(const double *b, int n)
{
    double factor[KN_EXACT_TERMS], zero[KN_EXACT_TERMS] = {0};
    for (int j = n; j > 0; j--) {
        for (int i = 0; i <= j; i++) factor[i] = (j - i) % 2 ? -kn_binomial(j, i) : kn_binomial(j, i);
        if (!kn_exact_zero(factor, zero, b, j + 1)) return j;
    }
    return 0;
}
