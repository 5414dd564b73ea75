// SPDX-License-Identifier: Apache-2.0
// Every operation on splines under every allocation failure: KN_ENOMEM, nothing leaks, outputs as they were.
#include <string.h>

#include "tests/support/support.h"

static const double knots_u[] = {0, 0, 0, 1, 2, 2, 2}, knots_v[] = {0, 0, 1, 2, 2};
static const double *const knots[2] = {knots_u, knots_v};

static kn_status make(kn_ctx *ctx, kn_spline *s, bool rational)
{
    double coef[48];
    for (int i = 0; i < 48; i++) coef[i] = 1 + i % 5;
    return kn_spline_init(ctx, s, 2, 3 + rational, rational, (int[]){2, 1}, (int[]){4, 3}, knots, coef);
}

typedef kn_status (*operation)(kn_ctx *ctx, kn_spline *out, const kn_spline *a);

static kn_status copy(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_copy(ctx, out, a);
}
static kn_status sum(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_spline b = {0};
    kn_status status = kn_spline_copy(ctx, &b, a);
    if (status == KN_OK && b.rational) b.coef[kn_spline_count(&b) * 3] += 1; // another weight
    if (status == KN_OK) status = kn_spline_sum(ctx, out, a, &b);
    kn_spline_clear(ctx, &b);
    return status;
}
static kn_status sum_of_other_knots(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_spline b = {0};
    kn_status status = kn_spline_elevate(ctx, &b, a, (int[]){3, 1});
    if (status == KN_OK) status = kn_spline_sum(ctx, out, a, &b);
    kn_spline_clear(ctx, &b);
    return status;
}
static kn_status product(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_product(ctx, out, a, a);
}
static kn_status dot(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_dot(ctx, out, a, a);
}
static kn_status cross(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_cross(ctx, out, a, a);
}
static kn_status derivative(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_derivative(ctx, out, a, 0);
}
static kn_status elevate(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_elevate(ctx, out, a, (int[]){4, 2});
}
static kn_status insert(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_insert_knots(ctx, out, a, 0, (double[]){1.5, 0.5}, 2);
}
static kn_status narrow(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    return kn_spline_restrict(ctx, out, a, (double[]){0.5, -1}, (double[]){1.5, 1});
}
static kn_status halves(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_spline right = {0};
    kn_status status = kn_spline_subdivide(ctx, out, &right, a, 1, 0.5);
    if (status != KN_OK) assert_int_equal(right.nvars, 0);
    kn_spline_clear(ctx, &right);
    return status;
}
static kn_status pieces_and_back(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    const double breaks[] = {0, 1, 2};
    const double *const at[] = {breaks, breaks};
    kn_bezier *pieces = NULL;
    size_t n = 99;
    kn_status status = kn_spline_to_bezier(ctx, &pieces, &n, a);
    if (status != KN_OK) {
        assert_null(pieces);
        assert_int_equal(n, 99);
        return status;
    }
    status = kn_spline_from_bezier(ctx, out, pieces, (int[]){3, 3}, at, (int[]){1, 0});
    for (size_t i = 0; i < n; i++) kn_bezier_clear(ctx, &pieces[i]);
    kn_free(ctx, pieces);
    return status;
}
static kn_status of_bezier(kn_ctx *ctx, kn_spline *out, const kn_spline *a)
{
    kn_bezier b;
    kn_status status = kn_bezier_init(ctx, &b, 2, a->ncomp, a->rational, a->degree);
    if (status != KN_OK) return status;
    status = kn_spline_of_bezier(ctx, out, &b);
    kn_bezier_clear(ctx, &b);
    return status;
}

typedef struct job {
    operation op;
    bool rational;
} job;

// On failure both an empty output and the operand as output stay as they were.
static kn_status run(kn_ctx *ctx, void *user)
{
    const job *j = user;
    kn_spline a = {0}, out = {0};
    kn_status status = make(ctx, &a, j->rational);
    if (status == KN_OK) status = j->op(ctx, &out, &a);
    if (status != KN_OK) assert_true(out.nvars == 0 && !out.coef);
    if (status == KN_OK) {
        kn_spline before = a;
        status = j->op(ctx, &a, &a);
        if (status != KN_OK) assert_memory_equal(&before, &a, sizeof a);
    }
    kn_spline_clear(ctx, &a);
    kn_spline_clear(ctx, &out);
    return status;
}

static void every_operation(void **state)
{
    (void)state;
    static const operation all[] = {
        copy,   sum,    sum_of_other_knots, product,  dot, cross, derivative, elevate, insert,
        narrow, halves, pieces_and_back,    of_bezier};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        for (int rational = 0; rational < 2; rational++) {
            job j = {all[i], rational};
            test_allocation_failures(run, &j);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_operation)};
    return cmocka_run_group_tests_name("spline/memory", tests, NULL, NULL);
}
