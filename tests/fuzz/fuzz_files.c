// SPDX-License-Identifier: Apache-2.0
// Fuzzes the readers of files: the bytes are the file, its name and the cell of a tile come from the first of them.
#include "tests/fuzz/feed.h"

#include <knurl/io.h>

#include <stdio.h>
#include <unistd.h>

static void write_file(const char *path, const uint8_t *data, size_t size)
{
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(data, 1, size, file) != size || fclose(file) != 0) abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const endings[] = {".g2", ".bpt", ".itd", ".txt"};
    feed f = feed_begin(data, size);
    char path[64];
    int which = feed_byte(&f);
    snprintf(path, sizeof path, "/tmp/knurl-fuzz-%ld%s", (long)getpid(), endings[which % 4]);
    write_file(path, f.at, f.left);
    kn_model model = {0};
    kn_tile tile = {0};
    const double cell[4] = {-1.0, 0.0, 1.0, which & 128 ? 2.0 : -2.0};
    kn_status status = KN_OK;
    switch (which / 4 % 5) {
    case 0: status = kn_read_model(f.ctx, &model, path); break;
    case 1: status = kn_read_g2(f.ctx, &model, path); break;
    case 2: status = kn_read_bpt(f.ctx, &model, path); break;
    case 3: status = kn_read_itd(f.ctx, &model, path); break;
    default: status = kn_read_tile(f.ctx, &tile, path, which & 64 ? cell : NULL); break;
    }
    remove(path);
    if ((status == KN_OK) != (kn_ctx_error(f.ctx) == KN_OK)) abort();
    for (int i = 0; i < model.nsplines; i++)
        if (kn_spline_check(f.ctx, &model.splines[i]) != KN_OK) abort();
    kn_model_clear(f.ctx, &model);
    kn_tile_clear(f.ctx, &tile);
    feed_end(&f);
    return 0;
}
