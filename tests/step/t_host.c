// SPDX-License-Identifier: Apache-2.0
// Patches in a body that another writer made: its edges and vertices are used, and what would leave it open is refused.
// What another CAD system makes of it: tests/bridges/t_occt_bodies.c.
#include "tests/support/host.h"
#include "tests/support/patches.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct world {
    test_memory memory;
    kn_ctx *ctx;
    test_host h;
    test_tile tile;
    kn_patch patch[4];
    char path[TEST_PATH_BYTES];
} world;

static void world_make(world *w)
{
    memset(w, 0, sizeof *w);
    w->memory = (test_memory)TEST_MEMORY_INIT;
    w->ctx = test_ctx(&w->memory, 1);
    test_host_make(w->ctx, &w->h, 1);
    test_tile_make(&w->tile, 1);
    for (int k = 0; k < 4; k++) w->patch[k].bezier = w->h.lid[k], w->patch[k].id.patch = k, w->patch[k].exact = true;
    test_tmp_path(w->path, "host.step");
}

static void world_clear(world *w)
{
    remove(w->path);
    test_host_clear(w->ctx, &w->h);
    test_ctx_end(w->ctx, &w->memory);
}

static kn_status write_host(kn_ctx *ctx, world *w, int n)
{
    kn_sink sink;
    kn_job_report report = test_report((size_t)n, 1, 1);
    kn_status status = kn_step_sink(ctx, &sink, w->path, &(kn_step_options){.host = &w->h.host});
    if (status != KN_OK) return status;
    status = test_feed(ctx, &sink, &w->tile.tile, &report, w->patch, (size_t)n, 2);
    kn_sink_close(ctx, &sink);
    return status;
}

static int count(const char *text, const char *word)
{
    int n = 0;
    for (const char *at = strstr(text, word); at != NULL; at = strstr(at + 1, word)) n++;
    return n;
}

static void joined(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    assert_int_equal(write_host(w.ctx, &w, 4), KN_OK);
    char *text = test_read_file(w.path, NULL);
    assert_non_null(text);
    assert_int_equal(count(text, "=EDGE_CURVE("), 16 + 4); // the box's own, and four inside the lid
    assert_int_equal(count(text, "=VERTEX_POINT("), 12 + 1);
    assert_int_equal(count(text, "=CLOSED_SHELL("), 1);
    assert_int_equal(count(text, "=PRODUCT("), 1); // the host's
    assert_int_equal(count(text, "=STYLED_ITEM("), 4);
    free(text);
    world_clear(&w);
}

static void expect_refused(world *w, int n, const char *message)
{
    assert_int_equal(write_host(w->ctx, w, n), KN_EDOMAIN);
    assert_non_null(strstr(kn_ctx_message(w->ctx), message));
    kn_ctx_clear_error(w->ctx);
    assert_null(test_read_file(w->path, NULL));
}

static void refusals(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    expect_refused(&w, 3, "would be open: 4 edges have one face only"); // two of the rim, two inside
    w.h.seed[3].shell = 1;
    expect_refused(&w, 4, "shell 1 of 1");
    w.h.seed[3].shell = 0;
    w.h.seed[3].vertex[0]++;
    expect_refused(&w, 4, "are one point");
    w.h.seed[3].vertex[0]--;
    w.h.seed[3].forward = true;
    expect_refused(&w, 4, "look out of shell");
    w.h.seed[3].forward = false;
    w.h.shell.closed = false; // an open shell may stay open
    assert_int_equal(write_host(w.ctx, &w, 3), KN_OK);
    world_clear(&w);
}

// Patches that meet none of the body's edges stand in a product of their own.
static void apart(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    w.h.shell.closed = false;
    for (int k = 0; k < 4; k++) w.h.lid[0].coef[8 + k] += 10.0;
    assert_int_equal(write_host(w.ctx, &w, 1), KN_OK);
    char *text = test_read_file(w.path, NULL);
    assert_non_null(text);
    assert_int_equal(count(text, "=PRODUCT("), 2);
    assert_int_equal(count(text, "=OPEN_SHELL("), 2);
    free(text);
    world_clear(&w);
}

static kn_status starved(kn_ctx *ctx, void *user)
{
    return write_host(ctx, user, 4);
}

static void without_memory(void **state)
{
    (void)state;
    world w;
    world_make(&w);
    test_allocation_failures(starved, &w);
    world_clear(&w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joined),
        cmocka_unit_test(refusals),
        cmocka_unit_test(apart),
        cmocka_unit_test(without_memory),
    };
    return cmocka_run_group_tests_name("step/host", tests, NULL, NULL);
}
