// SPDX-License-Identifier: Apache-2.0
// Expressions as fields: values against C, what they need, messages with positions, threads.
#include "tests/support/support.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bridges/muparser/expression.h"
#include "kernel/parallel.h"

static kn_place some_place(test_rng *rng)
{
    kn_place p = {.surface = test_int(rng, 0, 40)};
    for (int c = 0; c < 2; c++) p.uv[c] = test_uniform(rng, 0, 1), p.curvature[c] = test_uniform(rng, -2, 2);
    for (int c = 0; c < 3; c++) p.point[c] = test_uniform(rng, -9, 9), p.normal[c] = test_uniform(rng, -1, 1);
    return p;
}

static double sum_of_all(const kn_place *p)
{
    return p->uv[0] + 2 * p->uv[1] + 3 * p->point[0] + 4 * p->point[1] + 5 * p->point[2] + 6 * p->normal[0] +
           7 * p->normal[1] + 8 * p->normal[2] + 9 * p->curvature[0] + 10 * p->curvature[1] + 11 * p->surface;
}

static double functions(const kn_place *p)
{
    double x = p->point[0], y = p->point[1], u = p->uv[0];
    double clamped = x < -1 ? -1 : x > 2 ? 2 : x, t = x < 0 ? 0 : x > 4 ? 1 : x / 4;
    return clamped + (y + u * (x - y)) + t * t * (3 - 2 * t) + (x - 2.5 * floor(x / 2.5)) + floor(y) +
           kn_noise(p->point, 7) + (x > y ? sin(u) : 3.0) + 3.14159265358979323846;
}

// The parser orders sums as C does, but may fold constants: a few roundings of numbers below 1000.
static void values_agree_with_c(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        double (*value)(const kn_place *p);
        unsigned needs;
    } cases[] = {
        {"u + 2*v + 3*x + 4*y + 5*z + 6*nx + 7*ny + 8*nz + 9*mean + 10*gauss + 11*face", sum_of_all,
         KN_NEEDS_POINT | KN_NEEDS_NORMAL | KN_NEEDS_CURVATURE},
        {"clamp(x,-1,2) + mix(y,x,u) + smooth(0,4,x) + mod(x,2.5) + floor(y) + noise(x,y,z) + (x>y ? sin(u) : 3) + "
         "pi",
         functions, KN_NEEDS_POINT},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(11);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kn_expression *e = NULL;
        assert_int_equal(kn_expression_create(ctx, &e, cases[i].text, 7), KN_OK);
        kn_field f = kn_expression_field(e);
        assert_int_equal(f.needs, cases[i].needs);
        for (int k = 0; k < 100; k++) {
            kn_place p = some_place(&rng);
            assert_true(fabs(f.value(f.user, &p) - cases[i].value(&p)) <= 1e-11);
        }
        kn_expression_destroy(ctx, e);
    }
    kn_expression *e = NULL;
    assert_int_equal(kn_expression_create(ctx, &e, "u >= 0.5", 0), KN_OK);
    kn_field f = kn_expression_field(e);
    kn_place p = {.uv = {0.5, 0}};
    assert_true(f.needs == 0 && f.value(f.user, &p) == 1);
    p.uv[0] = 0.25;
    assert_true(f.value(f.user, &p) == 0);
    kn_expression_destroy(ctx, e);
    kn_expression_destroy(ctx, NULL);
    test_ctx_end(ctx, &memory);
}

static void mistakes_are_placed(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"u +", "at 4"},
        {"2 * q", "\"q\" found, at 5"},
        {"u = 2", "'=' assigns; '==' compares, at 3"},
        {"sin(u", "at 6"},
        {"1, 2", "one value"},
        {"u @ v", "at 3"},
        {"", "empty"},
        {"\"a\"", "at "},
        {"noise(u)", "Too few parameters"},
        {"u <= = v", "at 6"},
    };
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 2);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        kn_expression *e = NULL;
        kn_ctx_clear_error(ctx);
        assert_int_equal(kn_expression_create(ctx, &e, cases[i][0], 0), KN_EPARSE);
        if (!strstr(kn_ctx_message(ctx), cases[i][1])) fail_msg("%s: %s", cases[i][0], kn_ctx_message(ctx));
        assert_null(strchr(kn_ctx_message(ctx), '\n'));
        assert_null(e);
    }
    test_ctx_end(ctx, &memory);
}

typedef struct shared {
    kn_field field;
    kn_place place[256];
    double value[256];
} shared;

static kn_status evaluate(kn_ctx *ctx, void *user, size_t index)
{
    (void)ctx;
    shared *s = user;
    for (int k = 0; k < 50; k++) s->value[index] = s->field.value(s->field.user, &s->place[index]);
    return KN_OK;
}

// More threads than parsers: the expression was made for one.
static void any_number_of_threads(void **state)
{
    (void)state;
    static shared s;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *one = test_ctx(&memory, 1);
    test_memory other = TEST_MEMORY_INIT;
    kn_ctx *four = test_ctx(&other, 4);
    test_rng rng = test_random(12);
    kn_expression *e = NULL;
    for (int made_by = 0; made_by < 2; made_by++) {
        assert_int_equal(kn_expression_create(made_by ? four : one, &e, "x*y - z/(u+1) + noise(x,y,z)", 3), KN_OK);
        s.field = kn_expression_field(e);
        for (int i = 0; i < 256; i++) s.place[i] = some_place(&rng);
        assert_int_equal(kn_parallel(four, 256, evaluate, &s, "evaluate"), KN_OK);
        for (int i = 0; i < 256; i++) {
            const kn_place *p = &s.place[i];
            assert_true(s.value[i] == s.field.value(s.field.user, p));
            double c = p->point[0] * p->point[1] - p->point[2] / (p->uv[0] + 1) + kn_noise(p->point, 3);
            assert_true(fabs(s.value[i] - c) <= 1e-13);
        }
        kn_expression_destroy(one, e);
    }
    test_ctx_end(one, &memory);
    test_ctx_end(four, &other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_agree_with_c),
        cmocka_unit_test(mistakes_are_placed),
        cmocka_unit_test(any_number_of_threads),
    };
    return cmocka_run_group_tests_name("bridges/expression", tests, NULL, NULL);
}
