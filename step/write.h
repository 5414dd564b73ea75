// SPDX-License-Identifier: Apache-2.0
// Inside step: the pieces of a STEP file (ISO 10303-21, 10303-214, -242, -203) and its numbering.
//
// Threads write what belongs to one patch alone, with numbers that count from the patch (kn_text_relative): points,
// surface, curves of its edges. Then, in the job's order, patch after patch gets its numbers, the edges that it shares
// with earlier ones are found (brep.h), and what they have in common is written once.
// All numbers count from that of the last entity of a host body:
//     1 .. 21                    context, units, product, representations
//     30 .. 59                   what AP203 wants beside these
//     100 + 16 p ..              surface model and colour of look p
//     KN_STEP_PARTS + 16 nparts  all else, in the order of the file
#ifndef STEP_WRITE_H
#define STEP_WRITE_H

#include <knurl/step.h>

#include "io/brep.h"
#include "io/text_buffer.h"

enum {
    KN_STEP_PRODUCT_CONTEXT = 3,
    KN_STEP_DEFINITION_CONTEXT = 4,
    KN_STEP_DEFINITION = 8,
    KN_STEP_GEOMETRY_CONTEXT = 15,
    KN_STEP_PLACEMENT = 19,
    KN_STEP_REPRESENTATION = 20,
    KN_STEP_PRESENTATION = 21,
    KN_STEP_PARTS = 100,       // the first number of look 0
    KN_STEP_PART_NUMBERS = 16, // of each look: its surface model first, then its colour
};

typedef enum kn_step_kind {
    KN_STEP_FACE,
    KN_STEP_TRIMMED,
    KN_STEP_CURVE,
} kn_step_kind;

// An edge of a face. Its text stands behind that of the item: points of its own, then the curve without "#n=".
typedef struct kn_step_edge {
    kn_brep_edge edge;
    bool along; // the loop runs along the curve, which runs along the key
    size_t begin, curve_begin, curve_end;
    bool corners;       // its vertices are points of the face's text, else such as nobody has yet
    uint32_t corner[2]; // which
    double at[2][3];    // or where
    uint32_t pcurve;    // 0: none
} kn_step_edge;

typedef struct kn_step_loop {
    uint32_t nedges;
    bool outer; // the holes in it follow
} kn_step_loop;

// What a thread wrote of one face or curve, from text_begin to text_end, and then of its edges.
typedef struct kn_step_item {
    kn_step_kind kind;
    int look;
    kn_patch_id id;
    int group;       // kn_patch.body
    int body, shell; // as kn_patch_bounds; body -1: not told
    bool reversed, exact;
    size_t text_begin, text_end;
    uint32_t numbers; // that the text uses, from 0 on
    uint32_t main;    // the number of the face's surface; of the curve
    // The edges of a plain face that are no points, in the order of its loop.
    int nedges;
    kn_step_edge edge[4];
    kn_brep_key pair[4][2];
    int npairs;
    // Of a trimmed one: the first in the lists of its thread, and how many.
    size_t loops, nloops, edges, pairs;
    size_t points,
        npoints; // of instances: its numbers among those that the thread noted, and by what its form is known
    kn_brep_key form;
} kn_step_item;

// What trimmed faces have.
typedef struct kn_step_lists {
    kn_step_loop *loops;
    kn_step_edge *edges;
    kn_brep_key (*pairs)[2];
    size_t nloops, loop_room, nedges, edge_room, npairs, pair_room;
} kn_step_lists;

// What the beginning of the file says.
typedef struct kn_step_about {
    char *product, *time_stamp;
    kn_step_schema schema;
    double uncertainty_mm;
    char text[3][120]; // of FILE_DESCRIPTION
} kn_step_about;
// The header section; the product structure; units, uncertainty and an origin.
void kn_step_put_header(kn_text *text, const kn_step_about *about);
void kn_step_put_product(kn_text *text, uint64_t origin, const kn_step_about *about);
void kn_step_put_units(kn_text *text, uint64_t origin, const kn_step_about *about);
// A form whose every "#k" is number origin + k.
void kn_step_put_fixed(kn_text *text, uint64_t origin, const char *form);

// Appends patch's points in millimetres, surface and curves, and says in *item, of trimmed ones in *lists, too, how they
// are to be joined; a curve's points and the curve.
// fails: KN_EUNDEFINED (a weight that is not positive, a control point that is not finite), KN_ENOMEM.
KN_CHECKED kn_status kn_step_put_face(kn_text *text, kn_step_item *item, kn_step_lists *lists, const kn_patch *patch,
                                      double mm);
KN_CHECKED kn_status kn_step_put_curve(kn_text *text, kn_step_item *item, const kn_patch *patch, double mm);
// The colour of a look, whose numbers start at `first`: first + 3 is the style.
void kn_step_put_style(kn_text *text, const kn_material *material, uint64_t first);
// "#number=STYLED_ITEM" of something in the style of a look.
void kn_step_put_styled(kn_text *text, uint64_t number, uint64_t first, uint64_t item);
// "#n=" of an entity.
void kn_step_put_number(kn_text *text, uint64_t n);

#endif
