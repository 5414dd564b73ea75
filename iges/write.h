// SPDX-License-Identifier: Apache-2.0
// Inside iges: the pieces of an IGES 5.3 file (US PRO/IPO-100).
//
// An entity is two lines of the directory section, which hold the number of its first parameter line and how many
// there are, and its parameter lines, which hold the number of its first directory line: entity e has lines 2 e + 1
// and 2 e + 2, and is called by the former. Threads write the parameters of what refers to nothing, with blanks for
// the numbers (surfaces and curves: nearly all of the file); then, in the job's order, entities get numbers, and
// those that refer to others follow.
#ifndef IGES_WRITE_H
#define IGES_WRITE_H

#include <knurl/job.h>

#include "io/brep.h"
#include "io/closed_shells.h"
#include "io/naming.h"
#include "io/patch_net.h"
#include "io/text_buffer.h"

enum {
    KN_IGES_COLUMNS = 64,    // of parameters in a line
    KN_IGES_LINE_BYTES = 81, // with the end of the line
    KN_IGES_MOST = 9999999,  // lines of a section
};

// ---- lines.c: parameters, each with the comma behind it ----
void kn_iges_put_integer(kn_text *text, uint64_t n);
void kn_iges_put_real(kn_text *text, double x);
void kn_iges_put_string(kn_text *text, const char *string); // 5Hknurl; cut over lines where it is long
void kn_iges_end(kn_text *text);                            // the last comma becomes a semicolon; fills the line
// Takes kn_iges_end back, for more parameters.
void kn_iges_reopen(kn_text *text);
// Lines of the start and global sections.
void kn_iges_put_start(kn_text *text, const char *product, const char *time_stamp, double uncertainty_mm,
                       uint64_t lines[2]);

// ---- face.c, trimmed.c ----

typedef enum kn_iges_kind {
    KN_IGES_FACE,    // a surface and the curves of its edges
    KN_IGES_TRIMMED, // a surface and the curves of its loops
    KN_IGES_CURVE,
} kn_iges_kind;

// An edge of a face. Its lines: those of its curve in the plane, which runs along the loop, then those of the one in space,
// along its key.
typedef struct kn_iges_edge {
    kn_brep_edge edge;
    bool along;          // the loop runs along the curve
    double vertex[2][3]; // where the curve starts and ends
    uint32_t plane_lines, lines;
} kn_iges_edge;

typedef struct kn_iges_loop {
    uint32_t curves; // without shells those in the plane come first, then those in space
    bool outer;      // the holes in it follow
} kn_iges_loop;

// What a thread wrote of one patch: the surface's lines, then those of each curve.
typedef struct kn_iges_item {
    kn_iges_kind kind;
    int look;
    kn_patch_id id;
    int group;       // kn_patch.body
    int body, shell; // as kn_patch_bounds; body -1: not told
    bool reversed, exact;
    size_t begin;
    uint32_t surface_lines;
    // Of a plain face, the edges that are no points, in the order of its loop.
    int nedges;
    kn_iges_edge edge[4];
    kn_brep_key pair[4][2];
    int npairs;
    // Of a trimmed one: the first ones in the lists of kn_iges_written, how many loops.
    size_t loops, nloops, lines, edges, pairs;
} kn_iges_item;

// What a thread makes of a block.
typedef struct kn_iges_written {
    kn_text text;
    kn_iges_item *items;
    size_t nitems;
    kn_iges_loop *loops;
    uint32_t *lines;     // without shells, of each curve of a trimmed face
    kn_iges_edge *edges; // else its edges
    kn_brep_key (*pairs)[2];
    size_t nloops, loop_room, nlines, line_room, nedges, edge_room, npairs, pair_room;
} kn_iges_written;

// Appends an item and its lines.
// fails: KN_EUNDEFINED (a weight that is not positive, a control point that is not finite), KN_ENOMEM.
KN_CHECKED kn_status kn_iges_put_face(kn_iges_written *w, const kn_patch *patch, double mm, bool edges);
KN_CHECKED kn_status kn_iges_put_trimmed(kn_iges_written *w, const kn_patch *patch, double mm, bool edges);
KN_CHECKED kn_status kn_iges_put_line(kn_iges_written *w, const kn_patch *patch, double mm);
// turned: round, so that its normal looks to the other side.
void kn_iges_put_surface(kn_text *text, const kn_patch_net *f, bool turned);
// closed: its ends are one point; plane: in the plane of the parameters.
void kn_iges_put_curve(kn_text *text, const kn_patch_curve *line, bool turned, bool closed, bool plane);
uint32_t kn_iges_count_lines(const kn_text *text, size_t begin);

// ---- join.c: what threads wrote, put together in the job's order ----

typedef struct kn_iges_look {
    char name[KN_NAME_BYTES];
    kn_material material;
    uint64_t colour; // entity + 1; 0: not written yet
} kn_iges_look;

typedef struct kn_iges_join {
    kn_brep *brep;
    kn_text directory, parameters; // not yet in files
    uint64_t next, lines;          // entities, and parameter lines, so far
    kn_iges_look *looks;
    int nlooks;
    bool surfaces;
    const kn_naming *naming;
    kn_closed_shells closed;
} kn_iges_join;

kn_status kn_iges_join_begin(kn_ctx *ctx, kn_iges_join *j, const kn_tile *tile);
void kn_iges_join_clear(kn_ctx *ctx, kn_iges_join *j);
// Appends one item to both texts; where it closes a body, the solid follows. fails: KN_ENOMEM; KN_ELIMIT lines.
kn_status kn_iges_join_item(kn_ctx *ctx, kn_iges_join *j, const kn_iges_written *w, const kn_iges_item *item);
// Shells that are open. put(user) empties the texts where they have become long.
kn_status kn_iges_join_end(kn_ctx *ctx, kn_iges_join *j, kn_status (*put)(void *user), void *user);
void kn_iges_join_save(const kn_iges_join *j, kn_state *state);
kn_status kn_iges_join_restore(kn_ctx *ctx, kn_iges_join *j, kn_state_reader *r);

#endif
