// SPDX-License-Identifier: Apache-2.0
// Inside write: what sinks of text have in common. A format says how one patch is written; files, blocks, threads,
// journals, and what the format cannot hold, are looked after here.
#ifndef WRITE_TEXT_SINK_H
#define WRITE_TEXT_SINK_H

#include <knurl/write.h>

#include "io/out_file.h"
#include "io/text_buffer.h"

// What a format can hold.
enum { KN_WRITE_CURVES = 1, KN_WRITE_SURFACES = 2, KN_WRITE_VOLUMES = 4, KN_WRITE_TRIMMED = 8, KN_WRITE_MESHES = 16 };

typedef struct kn_write_look {
    char name[KN_NAME_BYTES]; // of the tile's part, or "part" and its number where it has none
    kn_material material;
} kn_write_look;

struct kn_write_format;
typedef struct kn_write_text {
    const struct kn_write_format *format;
    kn_out_file *file;
    kn_write_look *looks;
    int nlooks;
    double lo[3], hi[3]; // of the control points and vertices written so far; lo > hi: nothing is
    double cell_size;    // of the job's report
} kn_write_text;

// A patch as its file has it: turned so that r x t looks outside, and volumes right-handed, by swapping the first two
// variables, which changes no number.
typedef struct kn_write_item {
    const kn_patch *patch;
    kn_spline spline; // empty for a mesh
    kn_trim trim;     // of a surface; empty: all of it
    const kn_write_look *look;
} kn_write_item;

typedef struct kn_write_format {
    const char *name; // for messages
    unsigned holds;
    void (*head)(kn_text *text, const kn_write_text *w); // NULL: none; so too tail
    // One of these two: a patch, or all patches of a block.
    kn_status (*patch)(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *item);
    kn_status (*block)(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *items, size_t n);
    void (*tail)(kn_text *text, const kn_write_text *w);
} kn_write_format;

// The sink of a format for path. fails: as those of write.h.
KN_CHECKED kn_status kn_write_text_sink(kn_ctx *ctx, kn_sink *out, const char *path, const kn_write_format *format);

// ---- also for sinks of their own ----
KN_CHECKED kn_status kn_write_take_looks(kn_ctx *ctx, kn_write_look **looks, int *nlooks, const kn_tile *tile);
// KN_EDOMAIN with a message: a kind of patch that the format does not hold, another dimension than 3, a look that is
// none, numbers that are not finite, weights that are not positive.
KN_CHECKED kn_status kn_write_check(kn_ctx *ctx, const kn_write_format *format, int nlooks, const kn_patch *patch);
// KN_EDOMAIN: "NAME: patch .. of .. WHY".
KN_CHECKED kn_status kn_write_refuse(kn_ctx *ctx, const char *name, const kn_patch_id *id, const char *why);
// KN_EDOMAIN: the report announces what the format does not hold.
KN_CHECKED kn_status kn_write_check_report(kn_ctx *ctx, const kn_write_format *format, const kn_job_report *report);
// The item of a checked patch; kn_write_item_clear frees what had to be turned.
KN_CHECKED kn_status kn_write_item_init(kn_ctx *ctx, kn_write_item *out, const kn_patch *patch);
void kn_write_item_clear(kn_ctx *ctx, kn_write_item *item);

// " x", as few digits as read back as x.
void kn_write_real(kn_text *text, double x);
// Control point k of a spline in the order of most formats, the first variable fastest: its place in coef.
size_t kn_write_place(const kn_spline *s, size_t k);

#endif
