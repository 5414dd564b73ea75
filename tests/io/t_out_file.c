// SPDX-License-Identifier: Apache-2.0
// The output file that appears whole or not at all, and what every writer does when the disk is full.
#include "tests/support/patches.h"
#include <knurl/step.h>

#include "io/out_file.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

// ---- a folder of its own, to see what is left in it ----

static void make_folder(char path[TEST_PATH_BYTES])
{
    test_tmp_path(path, "folder");
    assert_int_equal(mkdir(path, 0700), 0);
}

static void in_folder(char path[TEST_PATH_BYTES], const char *folder, const char *name)
{
    assert_true(snprintf(path, TEST_PATH_BYTES, "%.400s/%.90s", folder, name) < TEST_PATH_BYTES);
}

static int files_in(const char *folder)
{
    int n = 0;
    DIR *d = opendir(folder);
    assert_non_null(d);
    for (const struct dirent *e = readdir(d); e != NULL; e = readdir(d)) n += e->d_name[0] != '.';
    closedir(d);
    return n;
}

static void expect_content(const char *path, const char *expected)
{
    size_t bytes = 0;
    char *text = test_read_file(path, &bytes);
    assert_non_null(text);
    assert_string_equal(text, expected);
    free(text);
}

// Files of this process end after `bytes` from now on; writing further fails as on a full disk, with EFBIG.
static struct rlimit limit_file_size(rlim_t bytes)
{
    struct rlimit old, new;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    new = old;
    new.rlim_cur = bytes;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &new), 0);
    return old;
}

static void restore_file_size(struct rlimit old)
{
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &old), 0);
    signal(SIGXFSZ, SIG_DFL);
}

// ---- the file itself ----

static void whole_or_nothing(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    char folder[TEST_PATH_BYTES], path[TEST_PATH_BYTES], other[TEST_PATH_BYTES];
    make_folder(folder);
    in_folder(path, folder, "out.txt");
    kn_out_file *file = NULL, *second = NULL;
    assert_int_equal(kn_out_open(ctx, &file, path), KN_OK);
    assert_int_equal(kn_out_write(ctx, file, "Hello", 5), KN_OK);
    assert_int_equal(kn_out_write(ctx, file, NULL, 0), KN_OK);
    assert_int_equal(access(path, F_OK), -1);                 // not there before commit
    assert_int_equal(kn_out_open(ctx, &second, path), KN_OK); // another writer of the same name
    assert_int_equal(files_in(folder), 2);
    assert_int_equal(kn_out_write(ctx, second, "second", 6), KN_OK);
    assert_int_equal(kn_out_write(ctx, file, ", world", 7), KN_OK);
    assert_int_equal(kn_out_rewrite(ctx, file, 0, "J", 1), KN_OK);
    assert_int_equal(kn_out_write(ctx, file, "!", 1), KN_OK);
    assert_int_equal(kn_out_bytes(file), 13);
    assert_int_equal(kn_out_commit(ctx, file), KN_OK);
    assert_int_equal(kn_out_bytes(file), 13);
    kn_out_close(ctx, file);
    expect_content(path, "Jello, world!");
    kn_out_close(ctx, second); // abandoned: what is there stays
    kn_out_close(ctx, NULL);
    expect_content(path, "Jello, world!");
    assert_int_equal(files_in(folder), 1);

    in_folder(other, folder, "out.txt.tmp-0"); // somebody else's: not touched
    test_write_file(other, "mine", 4);
    assert_int_equal(kn_out_open(ctx, &file, path), KN_OK);
    assert_int_equal(kn_out_write(ctx, file, "new", 3), KN_OK);
    assert_int_equal(kn_out_commit(ctx, file), KN_OK);
    kn_out_close(ctx, file);
    expect_content(path, "new");
    expect_content(other, "mine");
    remove(other);
    remove(path);
    assert_int_equal(rmdir(folder), 0);
    test_ctx_end(ctx, &memory);
}

static void refusals(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_out_file *file = NULL;
    assert_int_equal(kn_out_open(ctx, &file, "/nowhere/out.txt"), KN_EIO);
    assert_string_equal(kn_ctx_message(ctx), "/nowhere/out.txt: cannot create: No such file or directory");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_out_open(ctx, &file, "/tmp"), KN_EIO);
    assert_string_equal(kn_ctx_message(ctx), "/tmp: cannot create: Is a directory");
    kn_ctx_clear_error(ctx);
    assert_int_equal(kn_out_open(ctx, &file, ""), KN_EIO);
    assert_null(file);
    test_ctx_end(ctx, &memory);
}

// A device is written to as it is: renaming a file over it would replace it.
static void devices(void **state)
{
    (void)state;
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    kn_out_file *file = NULL;
    struct stat there;
    assert_int_equal(kn_out_open(ctx, &file, "/dev/null"), KN_OK);
    assert_int_equal(kn_out_write(ctx, file, "x", 1), KN_OK);
    assert_int_equal(kn_out_commit(ctx, file), KN_OK);
    kn_out_close(ctx, file);
    assert_int_equal(stat("/dev/null", &there), 0);
    assert_true(S_ISCHR(there.st_mode));
    if (stat("/dev/full", &there) == 0 && S_ISCHR(there.st_mode)) { // a disk that is always full
        assert_int_equal(kn_out_open(ctx, &file, "/dev/full"), KN_OK);
        assert_int_equal(kn_out_write(ctx, file, "x", 1), KN_OK); // waits in a buffer
        assert_int_equal(kn_out_commit(ctx, file), KN_EIO);
        assert_string_equal(kn_ctx_message(ctx), "/dev/full: cannot write: No space left on device");
        kn_out_close(ctx, file);
        assert_int_equal(stat("/dev/full", &there), 0);
    }
    test_ctx_end(ctx, &memory);
}

static kn_status open_write_commit(kn_ctx *ctx, void *user)
{
    kn_out_file *file = NULL;
    kn_status status = kn_out_open(ctx, &file, user);
    if (status != KN_OK) {
        assert_null(file);
        return status;
    }
    status = kn_out_write(ctx, file, "x", 1);
    if (status == KN_OK) status = kn_out_commit(ctx, file);
    kn_out_close(ctx, file);
    return status;
}

static void without_memory(void **state)
{
    (void)state;
    char folder[TEST_PATH_BYTES], path[TEST_PATH_BYTES];
    make_folder(folder);
    in_folder(path, folder, "out.txt");
    test_allocation_failures(open_write_commit, path);
    assert_int_equal(files_in(folder), 1);
    remove(path);
    assert_int_equal(rmdir(folder), 0);
}

// ---- every writer on a full disk ----

typedef kn_status (*make_sink)(kn_ctx *ctx, kn_sink *out, const char *path);

static kn_status make_step(kn_ctx *ctx, kn_sink *out, const char *path)
{
    return kn_step_sink(ctx, out, path, NULL);
}

// The disk is full after `room` bytes: KN_EIO with the system's words, the old file as it was, nothing beside it.
static void expect_full(kn_ctx *ctx, make_sink make, const char *folder, const char *path, const kn_patch *patches,
                        size_t count, rlim_t room)
{
    test_tile tile;
    kn_job_report report = test_report(count, 3, 3);
    kn_sink sink;
    test_tile_make(&tile, 1);
    assert_int_equal(make(ctx, &sink, path), KN_OK);
    struct rlimit old = limit_file_size(room);
    kn_status status = test_feed(ctx, &sink, &tile.tile, &report, patches, count, 2);
    restore_file_size(old);
    assert_int_equal(status, KN_EIO);
    assert_non_null(strstr(kn_ctx_message(ctx), path));
    assert_non_null(strstr(kn_ctx_message(ctx), "cannot write: File too large"));
    kn_ctx_clear_error(ctx);
    kn_sink_close(ctx, &sink);
    expect_content(path, "old");
    assert_int_equal(files_in(folder), 1);
}

static void full_disk(void **state)
{
    (void)state;
    static const struct {
        make_sink make;
        const char *name;
    } writers[] = {{make_step, "full.step"}, {kn_stl_sink, "full.stl"}, {kn_obj_sink, "full.obj"}};
    test_memory memory = TEST_MEMORY_INIT;
    kn_ctx *ctx = test_ctx(&memory, 1);
    test_rng rng = test_random(6);
    kn_patch patch[6];
    char folder[TEST_PATH_BYTES], path[TEST_PATH_BYTES];
    make_folder(folder);
    for (int i = 0; i < 6; i++) test_patch(ctx, &patch[i], &rng, 3, 3, false, i, 0.1);
    for (size_t w = 0; w < sizeof writers / sizeof *writers; w++) {
        in_folder(path, folder, writers[w].name);
        test_write_file(path, "old", 3);
        expect_full(ctx, writers[w].make, folder, path, patch, 6, 0);
        expect_full(ctx, writers[w].make, folder, path, patch, 6, 50);
        expect_full(ctx, writers[w].make, folder, path, patch, 6, 5000);
        remove(path);
    }
    for (int i = 0; i < 6; i++) kn_bezier_clear(ctx, &patch[i].bezier);
    assert_int_equal(rmdir(folder), 0);
    test_ctx_end(ctx, &memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_or_nothing), cmocka_unit_test(refusals),  cmocka_unit_test(devices),
        cmocka_unit_test(without_memory),   cmocka_unit_test(full_disk),
    };
    return cmocka_run_group_tests_name("io/out_file", tests, NULL, NULL);
}
