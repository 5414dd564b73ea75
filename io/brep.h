// SPDX-License-Identifier: Apache-2.0
// Inside io: which faces meet along which edges, found while the faces pass by.
//
// Composed patches that are neighbours have the control points of their edge in common bit for bit (docs/numerics.md,
// "compose"), so that an edge is known by its control points, and no distance decides anything. Of what has passed only
// the edges are kept that still wait for their other face, the vertices at their ends, and the numbers of the faces of
// bodies that are not closed yet: memory follows the front of a job that goes from cell to cell.
#ifndef IO_BREP_H
#define IO_BREP_H

#include <knurl/base.h>

#include "io/state.h"

// Stands for the numbers that were hashed: 128 bits.
typedef struct kn_brep_key {
    uint64_t a, b;
} kn_brep_key;

static inline bool kn_brep_same(kn_brep_key a, kn_brep_key b)
{
    return a.a == b.a && a.b == b.b;
}
// Of `ncomp` arrays of n numbers each, stride apart: coefficient i of component c at x[c * comp + i * step]. *turned:
// the numbers were taken from the last to the first, because that order is the lesser one; both orders give one key.
// A zero's sign does not count.
kn_brep_key kn_brep_hash(bool *turned, const double *x, int ncomp, size_t comp, size_t n, ptrdiff_t step);

// The key of what a key stands for and one more number.
kn_brep_key kn_brep_mix(kn_brep_key key, double x);

// An edge as one face uses it.
typedef struct kn_brep_edge {
    kn_brep_key key, vertex[2]; // vertices where it starts and ends, in the direction of its key
    bool forward;               // the face's boundary runs along that direction (counterclockwise seen from outside)
    uint64_t pcurve;            // what the face calls its own description of the edge; 0: it has none
} kn_brep_edge;

// What an edge is called: numbers, and whether they are new, so that their entities have to be written.
typedef struct kn_brep_name {
    uint64_t vertex[2], edge;
    bool new_vertex[2], new_edge;
    bool against;       // the edge runs against the direction of its key (kn_brep_seed)
    bool last;          // no face is to come: the edge's entity is written now, unless it is a seed's
    bool seam;          // this face uses the edge twice
    uint64_t pcurve[2]; // of the faces that use it, as far as they have one
} kn_brep_name;

enum { KN_BREP_NONE = -1, KN_BREP_PAIRS = 64 };

typedef struct kn_brep kn_brep;
kn_status kn_brep_create(kn_ctx *ctx, kn_brep **out);
void kn_brep_destroy(kn_ctx *ctx, kn_brep *b); // NULL is fine

// One more face with n edges, which shares them with faces of its group alone. names[i]: of edges[i]; new vertices take
// one number each from *next on, in their order, then new edges two each: its curve's is the one before. Equal edges of
// one face (a seam) become one. The face's own number is told afterwards.
// pairs: npairs of vertices that are one, because an edge between them is a point. Where both have numbers already, and
// different ones, or where there are more than KN_BREP_PAIRS (others are then not read), the face stands alone: its names
// are new, and its body is never closed.
// fails: KN_ENOMEM, KN_ELIMIT; the file is lost then.
kn_status kn_brep_add(kn_ctx *ctx, kn_brep *b, int group, const kn_brep_edge *edges, int n,
                      const kn_brep_key (*pairs)[2], int npairs, uint64_t *next, kn_brep_name *names);
// The number and the look of the face added last. *closed: the body that it closed, none of whose edges waits for
// another face and each of which two faces use in opposite directions; KN_BREP_NONE: none, or one that is held.
kn_status kn_brep_end_face(kn_ctx *ctx, kn_brep *b, uint64_t number, int look, int *closed);

// A body of faces that meet nobody, or a list of any numbers: never closed.
kn_status kn_brep_open(kn_ctx *ctx, kn_brep *b, int *out);
// One more number in such a body.
kn_status kn_brep_append(kn_ctx *ctx, kn_brep *b, int at, uint64_t number, int look);

// ---- bodies of others, whose edges are there before the faces ----
// A body that is told and found again by kn_brep_root, and never told to be closed.
kn_status kn_brep_hold(kn_ctx *ctx, kn_brep *b, int *out);
// A face of that body, for those of a group, uses the edge already, in the direction of its key or not (forward): what it and its vertices
// are called, and whether the edge of that name runs against that direction. Twice, once for each direction: two faces
// are to come.
// fails: KN_EDOMAIN there is another edge of this key, or a vertex of one of these keys with another number.
kn_status kn_brep_seed(kn_ctx *ctx, kn_brep *b, int group, int at, const kn_brep_edge *edge, uint64_t number,
                       const uint64_t vertex[2], bool against);
// The face that was added last belongs to this body.
void kn_brep_tie(kn_brep *b, int at);
// What the body has become a part of; whether a held one is; its edges that wait, and whether two faces use one of its
// edges in the same direction.
int kn_brep_root(const kn_brep *b, int at);
bool kn_brep_held(const kn_brep *b, int at);
uint32_t kn_brep_waiting(const kn_brep *b, int at, bool *odd);

// Bodies that wait at the end: *at = the next one after *at (KN_BREP_NONE: from the first on); false: no more.
bool kn_brep_next_body(const kn_brep *b, int *at);
// A body's faces in the order of their arrival, look by look as told.
typedef struct kn_brep_walk {
    uint32_t chunk, at;
    uint64_t number;
    int look;
    uint64_t left; // faces
} kn_brep_walk;
kn_brep_walk kn_brep_faces(const kn_brep *b, int at);
bool kn_brep_step(const kn_brep *b, kn_brep_walk *walk); // number and look of one more face; false: no more
// The body's look, or KN_BREP_NONE where its faces have several.
int kn_brep_look(const kn_brep *b, int at);
// Forgets a closed body.
void kn_brep_drop(kn_brep *b, int at);

// An edge that waits, its vertices in the direction of its key.
typedef struct kn_brep_open_edge {
    uint64_t edge, vertex[2], pcurve;
} kn_brep_open_edge;
// Edges that wait at the end, those of kn_brep_seed apart: *at = 0 before the first; false: no more.
bool kn_brep_next_edge(const kn_brep *b, size_t *at, kn_brep_open_edge *edge);

// For journals.
void kn_brep_save(const kn_brep *b, kn_state *state);
kn_status kn_brep_restore(kn_ctx *ctx, kn_brep *b, kn_state_reader *r);

#endif
