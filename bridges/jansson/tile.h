// SPDX-License-Identifier: Apache-2.0
// Tile descriptions in JSON: docs/tile.schema.json.
#ifndef BRIDGES_JANSSON_TILE_H
#define BRIDGES_JANSSON_TILE_H

#include <knurl/tile.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { KN_TILE_DEFAULTS = 16, KN_TILE_MAX_PARTS = 256, KN_TILE_MAX_PARAMETERS = 32 };

// What a description proposes where nothing else is said: an option of `knurl apply` and its text.
typedef struct kn_tile_default {
    char key[KN_NAME_BYTES], value[2 * KN_NAME_BYTES];
} kn_tile_default;

// A zero-initialised one is a valid empty one; kn_tile_clear of its tile ends it.
typedef struct kn_tile_file {
    kn_tile tile;
    kn_tile_default defaults[KN_TILE_DEFAULTS];
    int ndefaults;
} kn_tile_file;

// Reads the geometry of a part, splines or a mesh, from a file that a description names: part is empty, and stays so
// on failure.
typedef kn_status kn_tile_part_reader(kn_ctx *ctx, void *user, kn_tile_part *part, const char *path);

// The tile that a description and the files beside it describe. Files are read by `read`, which gets `user`.
// out:   overwritten; the tile over the unit cell (kn_tile_set_cell), checked (kn_tile_check).
// fails: KN_EPARSE bad JSON ("PATH:LINE: ..."), a key that is unknown, missing or has a value of the wrong kind
//        (PATH: "KEY": ...), a target that does not fit its part; KN_EDOMAIN what kn_tile_check says; KN_ELIMIT;
//        KN_EIO; KN_ENOMEM; what read answers. out unchanged.
KN_API KN_CHECKED kn_status kn_json_tile_read(kn_ctx *ctx, kn_tile_file *out, const char *path,
                                              kn_tile_part_reader *read, void *user);

#ifdef __cplusplus
}
#endif
#endif
