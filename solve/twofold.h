// SPDX-License-Identifier: Apache-2.0
// Numbers as unevaluated sums of two doubles: 106 bits, without fused multiply-adds.
// Dekker, A floating-point technique for extending the available precision, Numer. Math. 18 (1971); the bounds:
// Joldes, Muller & Popescu, Tight and rigorous error bounds for basic building blocks of double-word arithmetic,
// ACM TOMS 44 (2017). Products need |a|, |b| < 2^990.
#ifndef SOLVE_TWOFOLD_H
#define SOLVE_TWOFOLD_H

typedef struct kn_twofold {
    double hi, lo; // hi = fl(hi + lo)
} kn_twofold;

// Exactly a + b.
static inline kn_twofold kn_two_sum(double a, double b)
{
    double s = a + b, bb = s - a;
    return (kn_twofold){s, (a - (s - bb)) + (b - bb)};
}

// Exactly a + b for |a| >= |b| or a = 0.
static inline kn_twofold kn_fast_two_sum(double a, double b)
{
    double s = a + b;
    return (kn_twofold){s, b - (s - a)};
}

// Exactly a b, barring underflow.
static inline kn_twofold kn_two_product(double a, double b)
{
    double p = a * b, ca = 134217729.0 * a, cb = 134217729.0 * b; // 2^27 + 1
    double ah = ca - (ca - a), bh = cb - (cb - b), al = a - ah, bl = b - bh;
    return (kn_twofold){p, al * bl - (((p - ah * bh) - al * bh) - ah * bl)};
}

// x + y within 3.01 u^2 |x + y|.
static inline kn_twofold kn_twofold_add(kn_twofold x, kn_twofold y)
{
    kn_twofold s = kn_two_sum(x.hi, y.hi), t = kn_two_sum(x.lo, y.lo);
    s = kn_fast_two_sum(s.hi, s.lo + t.hi);
    return kn_fast_two_sum(s.hi, s.lo + t.lo);
}

// x y within 5 u^2 |x y|.
static inline kn_twofold kn_twofold_multiply(kn_twofold x, kn_twofold y)
{
    kn_twofold p = kn_two_product(x.hi, y.hi);
    return kn_fast_two_sum(p.hi, p.lo + (x.hi * y.lo + x.lo * y.hi));
}

// x y within 3 u^2 |x y|.
static inline kn_twofold kn_twofold_scale(kn_twofold x, double y)
{
    kn_twofold p = kn_two_product(x.hi, y);
    return kn_fast_two_sum(p.hi, p.lo + x.lo * y);
}

#endif
