// SPDX-License-Identifier: Apache-2.0
// Fuzzes what comes out of the reader of CAD files: any bytes give a status, what is parsed is a model that goes out
// and in again bit for bit, faces are found in it by any text, and joined whatever they are; they go out as STEP and as IGES
// with what the bytes say of their edges.
#include "tests/fuzz/feed.h"

#include <knurl/cad.h>
#include <knurl/iges.h>
#include <knurl/step.h>

#include <stdio.h>
#include <unistd.h>

static void find(feed *f, const kn_cad *cad, const uint8_t *data, size_t size)
{
    static const char *const texts[] = {"0",         "type:*", "name:a*b?", "body:0&type:plane", "color:#ff0000",
                                        "near:1,2,3"};
    char text[64];
    size_t n = size < sizeof text - 1 ? size : sizeof text - 1;
    memcpy(text, data + size - n, n);
    text[n] = '\0';
    for (size_t i = 0; i <= sizeof texts / sizeof *texts; i++) {
        const char *t = i < sizeof texts / sizeof *texts ? texts[i] : text;
        size_t points = 0;
        for (int k = 0; k < cad->nfaces; k++) points += kn_spline_count(&cad->faces[k].surface);
        if (t[0] == 'n' && t[2] == 'a' && points > 64) continue; // slow is not wrong
        int *faces = NULL, count = 0;
        kn_ctx_clear_error(f->ctx);
        if (kn_cad_find(f->ctx, &faces, &count, cad, t) != KN_OK) continue;
        if (count < 1 || count > cad->nfaces) abort();
        for (int k = 0; k < count; k++)
            if (faces[k] < 0 || faces[k] >= cad->nfaces || (k > 0 && faces[k] <= faces[k - 1])) abort();
        kn_free(f->ctx, faces);
    }
}

// All faces, or all but the first; the angle and whether anything is to be joined are a byte in the middle.
static void join(feed *f, const kn_cad *cad, const uint8_t *data, size_t size)
{
    enum { FACES = 6, POINTS = 256 }; // slow is not wrong
    const int how = data[size / 2];
    int faces[FACES], first = how % 4 == 1 && cad->nfaces > 1, n = cad->nfaces - first;
    size_t points = 0;
    for (int k = 0; k < cad->nfaces; k++) points += kn_spline_count(&cad->faces[k].surface);
    if (n < 1 || n > FACES || points > POINTS) return;
    for (int k = 0; k < n; k++) faces[k] = n - 1 - k + first;
    const kn_cad_join_options o = {.angle = how / 80.0, .tolerance = 0.5, .none = how % 8 == 7};
    kn_cad_joined joined = {0};
    kn_ctx_clear_error(f->ctx);
    if (kn_cad_join(f->ctx, &joined, cad, faces, n, &o) == KN_OK) {
        if (joined.n != n || !(joined.moved >= 0.0)) abort();
        for (int k = 0; k < n; k++) {
            if (kn_spline_check(f->ctx, &joined.surfaces[k]) != KN_OK || joined.turns[k] < 0 || joined.turns[k] > 3)
                abort();
            if (joined.trims[k].ncurves > 0 && kn_trim_check(f->ctx, &joined.trims[k]) != KN_OK) abort();
        }
        for (int k = 0; k < joined.nseams; k++) {
            const kn_cad_seam *seam = &joined.seams[k];
            if (seam->edge < 0 || seam->edge >= cad->nedges || seam->joined != !seam->why) abort();
            if ((o.none && seam->joined) || (seam->joined && !(seam->moved <= joined.moved))) abort();
        }
    } else if (joined.n > 0) {
        abort();
    }
    kn_cad_joined_clear(f->ctx, &joined);
}

// What face i tells of its edges; a byte of the input moves numbers and bodies.
static void tell(const kn_cad *cad, int i, int how, kn_patch_edge *edges, kn_patch_bounds *bounds)
{
    const kn_cad_face *face = &cad->faces[i];
    *bounds = (kn_patch_bounds){.edges = edges, .body = face->body - how % 2, .shell = face->shell};
    for (int k = 0; face->use && k < face->trim.ncurves; k++) {
        const kn_cad_edge *e = &cad->edges[face->edge[k]];
        if (face->use[k].plane.nvars == 0) continue;
        edges[k] = (kn_patch_edge){.number = (uint64_t)(face->edge[k] / (1 + how % 3)),
                                   .curve = &e->line,
                                   .plane = &face->use[k].plane,
                                   .against = face->use[k].against != (how % 16 == 15)};
        for (int v = 0; v < 2; v++) {
            edges[k].vertex[v] = (uint64_t)(e->vertex[v] / (1 + how % 5 / 3));
            edges[k].point[v] = cad->vertices[e->vertex[v]].at;
        }
    }
}

static void out(feed *f, const kn_cad *cad, const uint8_t *data, size_t size)
{
    enum { FACES = 6, CURVES = 16, POINTS = 256 }; // slow is not wrong
    kn_patch patches[FACES];
    kn_patch_edge edges[FACES][CURVES] = {{{0}}};
    kn_patch_bounds bounds[FACES];
    kn_spline surfaces[FACES] = {{0}};
    int how = data[size / 3];
    size_t n = 0, points = 0;
    for (int i = 0; i < cad->nfaces && n < FACES; i++) {
        const kn_cad_face *face = &cad->faces[i];
        points += kn_spline_count(&face->surface);
        for (int k = 0; k < face->trim.ncurves; k++) points += kn_spline_count(&face->trim.curves[k]);
        if (points > POINTS || face->trim.ncurves > CURVES) break;
        if (kn_spline_reparameterize(f->ctx, &surfaces[n], &face->surface, 0, 0.0, 1.0) != KN_OK ||
            kn_spline_reparameterize(f->ctx, &surfaces[n], &surfaces[n], 1, 0.0, 1.0) != KN_OK) {
            kn_spline_clear(f->ctx, &surfaces[n]);
            continue;
        }
        tell(cad, i, how, edges[n], &bounds[n]);
        patches[n] = (kn_patch){.spline = &surfaces[n], .trim = &face->trim, .bounds = &bounds[n], .exact = true};
        patches[n].segments[0] = patches[n].segments[1] = 1;
        n++;
    }
    char path[64];
    kn_tile tile = {0};
    (void)snprintf(path, sizeof path, "/tmp/knurl-fuzz-cad-%ld", (long)getpid());
    kn_ctx_clear_error(f->ctx);
    if (kn_tile_init(f->ctx, &tile, "fuzz", 1) != KN_OK) abort();
    for (int iges = 0; iges < 2 && n > 0; iges++) {
        const kn_iges_options o = {.surfaces = how % 7 == 6};
        kn_sink sink = {0};
        kn_ctx_clear_error(f->ctx);
        if ((iges ? kn_iges_sink(f->ctx, &sink, path, &o) : kn_step_sink(f->ctx, &sink, path, NULL)) != KN_OK)
            abort();
        feed_any(kn_stream_patches(f->ctx, &tile, patches, n, 0.0, &sink, 1));
        kn_sink_close(f->ctx, &sink);
    }
    kn_tile_clear(f->ctx, &tile);
    for (size_t i = 0; i < FACES; i++) kn_spline_clear(f->ctx, &surfaces[i]);
    (void)remove(path);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    feed f = feed_begin(data, size);
    kn_cad cad = {0};
    if (kn_cad_parse(f.ctx, &cad, "fuzz", data, size) == KN_OK) {
        unsigned char *again = NULL;
        size_t bytes = 0;
        if (kn_cad_check(f.ctx, &cad) != KN_OK || kn_cad_write(f.ctx, &again, &bytes, &cad) != KN_OK) abort();
        kn_cad copy = {0};
        if (bytes != size || kn_cad_parse(f.ctx, &copy, "again", again, bytes) != KN_OK) abort();
        if (copy.nfaces != cad.nfaces) abort();
        for (int i = 0; i < cad.nfaces; i++)
            if (!kn_cad_type_name(cad.faces[i].type)) abort();
        find(&f, &cad, data, size);
        join(&f, &cad, data, size);
        out(&f, &cad, data, size);
        kn_free(f.ctx, again);
        kn_cad_clear(f.ctx, &copy);
    } else if (cad.faces || cad.edges || cad.bodies) {
        abort();
    }
    kn_cad_clear(f.ctx, &cad);
    feed_end(&f);
    return 0;
}
