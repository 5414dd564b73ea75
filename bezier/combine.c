// SPDX-License-Identifier: Apache-2.0
// Sums of products of components, on scaled coefficients.
#include "bezier/combine.h"

#include <string.h>

// ---- lists of terms ----
int kn_product_terms(kn_term *terms, int na, int nb, bool rational)
{
    int dim = na > nb ? na : nb;
    for (int i = 0; i < dim; i++) terms[i] = (kn_term){i, na > 1 ? i : 0, nb > 1 ? i : 0, 1.0};
    terms[dim] = (kn_term){dim, na, nb, 1.0};
    return dim + rational;
}

int kn_dot_terms(kn_term *terms, int dim, bool rational)
{
    for (int i = 0; i < dim; i++) terms[i] = (kn_term){0, i, i, 1.0};
    terms[dim] = (kn_term){1, dim, dim, 1.0};
    return dim + rational;
}

int kn_cross_terms(kn_term *terms, bool rational)
{
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        terms[2 * i] = (kn_term){i, j, k, 1.0};
        terms[2 * i + 1] = (kn_term){i, k, j, -1.0};
    }
    terms[6] = (kn_term){3, 3, 3, 1.0};
    return 6 + rational;
}

int kn_sum_terms(kn_term *terms, int dim, double sign)
{
    for (int i = 0; i < dim; i++) {
        terms[2 * i] = (kn_term){i, i, dim, 1.0};
        terms[2 * i + 1] = (kn_term){i, dim, i, sign};
    }
    terms[2 * dim] = (kn_term){dim, dim, dim, 1.0};
    return 2 * dim + 1;
}

// ---- steps ----
void kn_operand_init(kn_operand *o, const kn_bezier *a, bool with_one)
{
    size_t step = 1;
    for (int d = a->nvars - 1; d >= 0; d--) o->step[d] = step, step *= (size_t)a->degree[d] + 1;
    o->coef = a->coef, o->component = step, o->ncomp = a->ncomp, o->with_one = with_one, o->unscaled = false;
}

bool kn_terms_want(const kn_term *terms, int nterms, int which, int n)
{
    bool wanted = false;
    for (int i = 0; i < nterms; i++) wanted |= (which ? terms[i].b : terms[i].a) == n;
    return wanted;
}

kn_status kn_pairing_init(kn_ctx *ctx, kn_pairing *p, int nvars, const int *da, const int *db, int na, int nb,
                          int ncomp)
{
    kn_convolution_init(&p->plan, kn_convolve_best(), nvars, da, db);
    p->ncomp = ncomp;
    p->thin_comps = (size_t)(p->plan.swapped ? nb : na), p->wide_comps = (size_t)(p->plan.swapped ? na : nb);
    size_t thin = p->thin_comps * p->plan.thin_room, wide = p->wide_comps * p->plan.wide_room;
    p->thin = kn_scratch(ctx, thin + wide + (size_t)ncomp * p->plan.sum_room, sizeof *p->thin);
    if (!p->thin) return KN_ENOMEM;
    p->wide = p->thin + thin, p->sums = p->wide + wide;
    return KN_OK;
}

// Its Bernstein coefficients, one step of 0 in each variable apart.
static const double one[KN_MAX_DEGREE + 1] = {
    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
    1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1,
};

static void pack(const kn_convolution *plan, double *to, const kn_operand *o, bool thin)
{
    static const size_t still[KN_MAX_VARS] = {0};
    size_t room = thin ? plan->thin_room : plan->wide_room;
    for (int c = 0; c < o->ncomp + o->with_one; c++, to += room) {
        const double *from = c < o->ncomp ? o->coef + (size_t)c * o->component : one;
        const size_t *step = c < o->ncomp ? o->step : still;
        if (thin)
            kn_convolution_pack_thin(plan, to, from, step, !o->unscaled);
        else
            kn_convolution_pack_wide(plan, to, from, step, !o->unscaled);
    }
}

void kn_pairing_run(const kn_pairing *p, const kn_operand *a, const kn_operand *b, const kn_term *terms, int nterms)
{
    const kn_convolution *plan = &p->plan;
    pack(plan, p->thin, plan->swapped ? b : a, true);
    pack(plan, p->wide, plan->swapped ? a : b, false);
    for (size_t c = 0; c < (size_t)p->ncomp; c++) kn_convolution_clear(plan, p->sums + c * plan->sum_room);
    for (const kn_term *t = terms; t < terms + nterms; t++) {
        size_t i = (size_t)(plan->swapped ? t->b : t->a), j = (size_t)(plan->swapped ? t->a : t->b);
        kn_convolution_run(plan, p->sums + (size_t)t->to * plan->sum_room, p->thin + i * plan->thin_room,
                           p->wide + j * plan->wide_room, t->sign);
    }
}

void kn_pairing_result(kn_operand *o, const kn_pairing *p)
{
    o->coef = p->sums, o->component = p->plan.sum_room, o->ncomp = p->ncomp, o->with_one = false, o->unscaled = true;
    memcpy(o->step, p->plan.sum_step, sizeof o->step);
}

void kn_pairing_store(const kn_pairing *p, double *out, size_t component, const size_t *step)
{
    for (size_t c = 0; c < (size_t)p->ncomp; c++)
        kn_convolution_divide(&p->plan, out + c * component, step, p->sums + c * p->plan.sum_room);
}

// ---- chains of products ----
kn_formula kn_determinant_formula(kn_determinant_terms *room, bool rational)
{
    kn_formula f = {.ncomp = 1 + rational, .rational = rational, .terms = room->outer, .inner = room->inner};
    f.nterms = kn_dot_terms(room->outer, 3, rational);
    f.ninner = kn_cross_terms(room->inner, rational);
    f.inner_comps = 3 + rational;
    return f;
}

bool kn_formula_wants_one(const kn_formula *f, int i, int ncomp)
{
    if (f->ninner == 0) return kn_terms_want(f->terms, f->nterms, i, ncomp);
    return i == 0 ? kn_terms_want(f->terms, f->nterms, 0, ncomp) : kn_terms_want(f->inner, f->ninner, i - 1, ncomp);
}

kn_status kn_chain_init(kn_ctx *ctx, kn_chain *c, const kn_formula *f, int nvars, const int *const *degree,
                        const int *comps)
{
    int inner[KN_MAX_VARS];
    c->formula = f;
    if (f->ninner == 0)
        return kn_pairing_init(ctx, &c->outer, nvars, degree[0], degree[1], comps[0], comps[1], f->ncomp);
    for (int d = 0; d < nvars; d++) inner[d] = degree[1][d] + degree[2][d];
    kn_status status = kn_pairing_init(ctx, &c->inner, nvars, degree[1], degree[2], comps[1], comps[2],
                                       f->inner_comps);
    if (status != KN_OK) return status;
    return kn_pairing_init(ctx, &c->outer, nvars, degree[0], inner, comps[0], f->inner_comps, f->ncomp);
}

void kn_chain_run(const kn_chain *c, const kn_operand *operands, double *out, size_t component, const size_t *step)
{
    const kn_formula *f = c->formula;
    const kn_operand *second = &operands[1];
    kn_operand inner;
    if (f->ninner > 0) {
        kn_pairing_run(&c->inner, &operands[1], &operands[2], f->inner, f->ninner);
        kn_pairing_result(&inner, &c->inner);
        second = &inner;
    }
    kn_pairing_run(&c->outer, &operands[0], second, f->terms, f->nterms);
    kn_pairing_store(&c->outer, out, component, step);
}

// ---- pieces ----
static void small_operand(kn_small_operand *s, const kn_bezier *a, bool with_one)
{
    s->coef = a->coef, s->ncomp = a->ncomp, s->with_one = with_one;
    s->rows = a->nvars > 1 ? a->degree[0] + 1 : 1;
    s->columns = a->nvars > 0 ? a->degree[a->nvars - 1] + 1 : 1;
}

// Small products of two operands: true when it is done, or has failed.
static bool multiply_small(kn_ctx *ctx, kn_status *status, kn_bezier *out, kn_bezier *c,
                           const kn_bezier *const *operands, const kn_formula *f)
{
    kn_small_operand a, b;
    if (c->nvars > 2 || f->ninner > 0 || !kn_small_in_order(f->terms, f->nterms, f->ncomp)) return false;
    small_operand(&a, operands[0], kn_terms_want(f->terms, f->nterms, 0, operands[0]->ncomp));
    small_operand(&b, operands[1], kn_terms_want(f->terms, f->nterms, 1, operands[1]->ncomp));
    if (!kn_small_fits(a.rows, a.columns, a.ncomp + a.with_one, b.rows, b.columns, b.ncomp + b.with_one))
        return false;
    *status = kn_bezier_begin_checked(ctx, c, out, false);
    if (*status == KN_OK) {
        kn_small_run(c->coef, &a, &b, f->terms, f->nterms);
        kn_bezier_end(ctx, out, c);
    }
    return true;
}

kn_status kn_bezier_multiply(kn_ctx *ctx, const char *what, kn_bezier *out, const kn_bezier *const *operands,
                             const kn_formula *f)
{
    int n = f->ninner > 0 ? 3 : 2, comps[3];
    const int *degree[3];
    kn_operand o[3], to;
    kn_chain chain;
    kn_bezier c; // filled field by field: clearing it first would cost a small product a tenth of its time
    c.nvars = operands[0]->nvars, c.ncomp = f->ncomp, c.rational = f->rational;
    for (int d = 0; d < c.nvars; d++) {
        c.degree[d] = operands[0]->degree[d] + operands[1]->degree[d];
        if (n == 3) c.degree[d] += operands[2]->degree[d];
    }
    for (int d = c.nvars; d < KN_MAX_VARS; d++) c.degree[d] = 0;
    kn_status status = kn_bezier_check(ctx, what, c.nvars, c.ncomp, c.rational, c.degree);
    if (status != KN_OK || multiply_small(ctx, &status, out, &c, operands, f)) return status;
    for (int i = 0; i < n; i++) {
        kn_operand_init(&o[i], operands[i], kn_formula_wants_one(f, i, operands[i]->ncomp));
        comps[i] = o[i].ncomp + o[i].with_one, degree[i] = operands[i]->degree;
    }
    kn_mark mark = kn_scratch_mark(ctx);
    status = kn_chain_init(ctx, &chain, f, c.nvars, degree, comps);
    // Operands are packed before out is written to, even when it is one of them.
    if (status == KN_OK) status = kn_bezier_begin_checked(ctx, &c, out, false);
    if (status == KN_OK) {
        kn_operand_init(&to, &c, false);
        kn_chain_run(&chain, o, c.coef, to.component, to.step);
        kn_bezier_end(ctx, out, &c);
    }
    kn_scratch_release(ctx, mark);
    return status;
}

kn_status kn_bezier_combine(kn_ctx *ctx, const char *what, kn_bezier *out, kn_bezier *c, const kn_bezier *a,
                            const kn_bezier *b, const kn_term *terms, int nterms)
{
    const kn_bezier *const operands[] = {a, b};
    kn_formula f = {.ncomp = c->ncomp, .rational = c->rational, .terms = terms, .nterms = nterms};
    for (int d = 0; d < a->nvars; d++) c->degree[d] = a->degree[d] + b->degree[d];
    return kn_bezier_multiply(ctx, what, out, operands, &f);
}
