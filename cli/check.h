// SPDX-License-Identifier: Apache-2.0
// Inside `knurl check`: what is examined and what was found. All lengths are in the base's unit.
#ifndef CLI_CHECK_H
#define CLI_CHECK_H

#include "cli/cli.h"

enum {
    CHECK_WORST = 20,   // cells that a report names at most
    CHECK_BOXES = 8,    // in which a tile's patches are gathered
    CHECK_WORK = 100000 // boxes that the search for two places with one image visits
};

// (u,v) in cells, w in length units.
typedef struct check_box {
    double lo[3], hi[3];
} check_box;

// What the tiles occupy of one cell of a shell, w in the shell's heights.
typedef struct check_cell_box {
    int shell, cell[2];
    double lo[3], hi[3];
} check_cell_box;

// A piece of a base between creases, a volume, or a surface of a job.
typedef struct check_shell {
    const kn_shell *shell;
    kn_shell *own;     // the same when it is not a job's
    kn_spline spline;  // what it is made of; empty for a job's
    int surface;       // of the base
    int first_cell[2]; // its own first cell, counted on that surface
    int cells[2];
    double range[2];   // of w
    double heights[2]; // that it has: a volume's
    double unit;       // heights of a job count in it: 1, or the height of a volume
    kn_fold_sign sign;
    kn_fold_heights safe, *cell_safe;
    bool *cell_folds;
    char failure[256]; // of work on it
} check_shell;

typedef struct check_cell {
    int shell, cell[2];
    double room; // the least share of the height that is safe; below 1 it does not fit
    bool folds;
    double at[2], point[3]; // where it has its limit, on the side that is tighter, and S there
} check_cell;

typedef struct check {
    cli_recipe recipe;
    int layer;   // of it, from 1
    cli_job job; // that layer
    const char *outputs[16];
    int noutputs, ndrawn;
    bool by_jacobian; // what the picture shows
    int pixels[2];
    size_t work;
    cli_base base;
    kn_tile tile;
    kn_job *plan;
    check_shell *shells;
    int nshells;
    check_box box[CHECK_BOXES];
    int nboxes;                 // 0 without a tile
    check_cell_box *cell_boxes; // by shell and cell, where cells are not alike (check_by_cell); then nboxes is 0
    size_t ncell_boxes, cell_boxes_room;
    kn_fold_region *regions; // what a tile or volumes occupy; NULL: all of every shell between `range`
    size_t nregions;
    double range[2];
    // Findings.
    kn_fold_verdict verdict;
    double jacobian[2];
    kn_fold_heights safe;
    check_cell *cells; // worst first
    size_t ncells, nfolding;
    kn_fold_intersection global;
    double seconds;
} check;

// Shells of the base's surfaces, cut at creases, or of the job that the tile asks for; exit code.
int check_make_shells(cli_session *session, check *c);
void check_clear(cli_session *session, check *c);
// Where they fold, cell by cell; exit code.
int check_examine(cli_session *session, check *c);
// What the tile's patches occupy of each cell, and so of the shells, into c->box and c->regions. Volumes have regions,
// too, each its own heights.
kn_status check_make_regions(kn_ctx *ctx, check *c);
// The boxes of one cell of a shell: c->nboxes regions.
void check_cell_boxes(const check *c, int shell, const int cell[2], kn_fold_region *out);
// Whether tiles are chosen, placed or varied cell by cell: then what they occupy is found for each, and cells in which
// there is nothing do not count.
bool check_by_cell(const check *c);
kn_status check_make_cell_regions(kn_ctx *ctx, check *c);
bool check_cell_region(const check *c, int shell, const int cell[2], kn_fold_region *out); // false: nothing is there

bool check_passed(const check *c);
void check_print(const check *c);
// The base coloured by what was found; exit code.
int check_draw(cli_session *session, const check *c, const char *path);
bool check_can_draw(const char *path); // prints why not

// Colours of the picture, sRGB in [0,1]: t in [-1,0) does not fit, t in [0,1] does.
void heat_color(double t, double srgb[3]);
void heat_linear_color(double t, float rgb[3]); // for light: linear

#endif
