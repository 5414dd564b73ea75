// SPDX-License-Identifier: Apache-2.0
// Indexed triangle meshes and the tessellation of patches.
#ifndef KNURL_MESH_H
#define KNURL_MESH_H

#include <knurl/shell.h>
#include <knurl/spline.h>
#include <knurl/trim.h>

#ifdef __cplusplus
extern "C" {
#endif

// position and normal: 3 numbers a vertex (normal unit length, or NULL: not known); triangle: 3 vertex indices each,
// counterclockwise seen from outside. A zero-initialised kn_mesh is a valid empty one; kn_mesh_clear frees it.
typedef struct kn_mesh {
    size_t nvertices, ntriangles;
    double *position, *normal;
    uint32_t *triangle;
    size_t vertex_room, triangle_room; // allocated
} kn_mesh;
// Frees the arrays; the mesh is empty afterwards. NULL and an empty mesh are fine.
KN_API void kn_mesh_clear(kn_ctx *ctx, kn_mesh *mesh);

// out = a. out: initialised, overwritten, may be a. fails: KN_ENOMEM; out unchanged.
KN_API KN_CHECKED kn_status kn_mesh_copy(kn_ctx *ctx, kn_mesh *out, const kn_mesh *a);

// Appends another mesh, not itself, whose vertices have normals as those of the first have. fails: KN_EDOMAIN no
// normals, KN_ELIMIT (more than 2^32 - 1 vertices), KN_ENOMEM; the mesh holds what it held.
KN_API KN_CHECKED kn_status kn_mesh_append(kn_ctx *ctx, kn_mesh *mesh, const kn_mesh *a);

// Appends a patch over [0,1]^2 on the uniform grid of segments[0] x segments[1]: vertices with r slowest, unit
// normals along r x t, and two triangles for each rectangle, less those of which two corners coincide.
// in:     patch of two variables in dimension 3, polynomial or rational; segments at least 1 each; reversed flips
//         triangles and normals.
// out:    (segments[0]+1)(segments[1]+1) more vertices, at most 2 segments[0] segments[1] more triangles. Points on
//         an edge depend on that edge's control points and segments alone, whichever way the edge is run, so that
//         patches which share an edge share its points bit for bit. Where r x t vanishes (a collapsed edge, a cusp)
//         the normal is its limit from inside, to about 1e-6; (0,0,1) where the patch has none there either.
// fails:  KN_EDOMAIN (shape, segments), KN_ELIMIT (more than 2^32 - 1 vertices, degree > KN_MAX_DEGREE), KN_ENOMEM;
//         the mesh holds what it held.
// error:  |point - exact| <= gamma(4 (n + m) + 2) max |control point| for degrees (n, m); rational: over the least
//         weight.
// cost:   per vertex and component about 3 (m + 1) products, and per line of r 2 (n + 1)(m + 1); no allocation but
//         the arrays' growth, by half each time.
KN_API KN_CHECKED kn_status kn_mesh_add_patch(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch,
                                              const int segments[2], bool reversed);

// ---- meshes through maps ----

// *point = the image of `from`; normal (NULL: not wanted) = that of geometry with from_normal there, unit length, or
// 0 where there is none. Called from one thread; a point has one image however often it is asked for.
typedef kn_status (*kn_mesh_function)(kn_ctx *ctx, void *user, double point[3], double *normal, const double from[3],
                                      const double *from_normal);
// Zero means the default in every field.
typedef struct kn_mesh_map_options {
    double tolerance;      // of the image, in its unit; 0: nothing is split
    bool reversed;         // triangles turn over, as where the map turns space inside out
    bool estimate_normals; // kn_mesh_map: kn_shell_map_normal_estimate, the source's, instead of the exact ones
    size_t max_triangles;  // 0: 2^24
} kn_mesh_map_options;
KN_API kn_mesh_map_options kn_mesh_map_defaults(void);
// out = the mesh through the map: vertices with their images, more where an edge is bent by more than the tolerance,
// and inside of triangles that are bent though their edges are not. An edge is cut in its middle, and whether it is
// depends on its two ends alone: triangles that share one, in this mesh or in another, agree bit for bit about all
// that it becomes, and closed meshes stay closed.
// in:     triangles refer to vertices; mesh.normal NULL: means of the normals of the triangles around a vertex.
// out:    initialised, overwritten, may be mesh. The mesh's own vertices come first, in its order; normals in the
//         space between them are means. Where the map gives no normal it is the mean of the mapped triangles'.
//         *deviation (NULL: not wanted): the largest distance that was measured and left.
// fails:  what the function answers; KN_EDOMAIN a tolerance that is negative or not finite, a vertex that is not
//         there; KN_ELIMIT triangles; KN_ECANCELLED, KN_ENOMEM; out unchanged.
// error:  distances are measured, not certified: at three points of each edge, against its chord, and in the middle
// of
//         each triangle, against its plane. An edge is halved 12 times at most: *deviation then tells.
// cost:   four calls of the function for each edge of the result and two for each triangle.
// source: Elber 2005, sidebar "Polygonal Composition Algorithm".
KN_API KN_CHECKED kn_status kn_mesh_map_by(kn_ctx *ctx, kn_mesh *out, double *deviation, const kn_mesh *mesh,
                                           kn_mesh_function function, void *user, const kn_mesh_map_options *options);
// The same through a shell: (u, v, w) are the shell's own parameters (kn_shell_eval).
KN_API KN_CHECKED kn_status kn_mesh_map(kn_ctx *ctx, kn_mesh *out, double *deviation, const kn_mesh *mesh,
                                        const kn_shell *shell, const kn_mesh_map_options *options);

// The same for what a trim leaves of the patch (kn_trim_check accepts it, and its loops do not meet; empty: all).
// out:    vertices at points along the trim, and at corners of the grid inside it. Points along edges of the square
// are
//         those of kn_mesh_add_patch there, and the ends of curves of the trim; points along other curves depend, in
//         (r,t), on the curve and the segments alone, whichever way it runs, so that both sides of a cut share them.
//         Triangles keep three tenths of a step between the grid and the trim; beside it they follow its points.
// fails:  also KN_EUNDECIDED: loops that cross or touch; KN_ELIMIT: more than 2^20 points along the trim.
// cost:   that of each vertex singly, and n^2 for n points along the trim and around the boxes inside.
KN_API KN_CHECKED kn_status kn_mesh_add_trimmed(kn_ctx *ctx, kn_mesh *mesh, const kn_bezier *patch,
                                                const kn_trim *trim, const int segments[2], bool reversed);

// A segment in the plane of a mesh's first two coordinates.
typedef struct kn_mesh_segment {
    double from[2], to[2];
} kn_mesh_segment;
// Cuts triangles, in place, so that no segment runs through the inside of one: the mesh stays what it was, point by
// point, and its triangles lie wholly on either side of each segment, seen along the third coordinate. They may stand
// upright, or lie over one another.
// in:     near > 0: what lies within it of a vertex or a segment counts as on it.
// out:    vertices as they were, then new ones, where edges cross segments and at ends of segments. A new vertex on an
//         edge, and its normal, depend on the edge's two ends and the segments alone, in whatever order these come:
//         two triangles with one edge, of one mesh or two, agree bit for bit. Coordinates that both ends of the edge,
//         or of the segment, have in common are kept.
// fails:  KN_EDOMAIN near, a segment that is not finite, a triangle that refers to no vertex; KN_ELIMIT 2^24 triangles,
//         2^32 - 1 vertices; KN_ENOMEM, KN_ECANCELLED; the mesh is unchanged.
// error:  new vertices lie on their segments to rounding, moved by `near` at most across an edge that passes its end.
// cost:   n boxes of triangles for each segment.
KN_API KN_CHECKED kn_status kn_mesh_cut(kn_ctx *ctx, kn_mesh *mesh, const kn_mesh_segment *segments, size_t n,
                                        double near);

// What kind of surface a mesh is. Of one component without irregular edges: euler = 2 - 2 genus - loops.
typedef struct kn_mesh_topology {
    size_t vertices, edges; // of its triangles
    size_t border;          // edges of one triangle
    size_t irregular;       // edges of more than two triangles, or of two that run along it the same way, or from a
                            // vertex to itself; and vertices that the border passes more than once
    int components, loops;  // loops: of the border
    long euler;             // vertices - edges + triangles
} kn_mesh_topology;
// fails: KN_EDOMAIN a triangle that refers to no vertex; KN_ENOMEM; out unchanged. cost: a sort of all edges.
KN_API KN_CHECKED kn_status kn_mesh_survey(kn_ctx *ctx, kn_mesh_topology *out, const kn_mesh *mesh);
// Lays a disk flat without a fold: its border on the unit circle, counterclockwise, by its length, all other vertices
// the weighted mean of their neighbours, with the weights of the Laplacian kept in [0.05, 20].
// in:     mesh: one component, one border loop, Euler characteristic 1; start: the border vertex that goes to (1,0).
// out:    xy: 2 numbers for each vertex, (0,0) for those that no triangle has.
// fails:  KN_EDOMAIN no disk, start; KN_EUNDECIDED the equations are not solved, or a triangle vanishes, to rounding;
//         KN_ECANCELLED, KN_ENOMEM; xy unchanged.
// error:  the residual is below 1e-9 of the first; that triangles keep their sides is checked.
// cost:   some sqrt(n) steps of conjugate gradients, n log n for the sort.
// source: Tutte, How to draw a graph, Proc. LMS 13 (1963); Floater, One-to-one piecewise linear mappings over
//         triangulations, Math. Comp. 72 (2003); Pinkall & Polthier, Computing discrete minimal surfaces and their
//         conjugates, Exp. Math. 2 (1993).
KN_API KN_CHECKED kn_status kn_mesh_flatten(kn_ctx *ctx, double *xy, const kn_mesh *mesh, uint32_t start);
// Lays a closed surface of genus 0 on the unit sphere without a fold, triangles counterclockwise seen from outside,
// turned to where they are in space: stretched as little as moving one vertex at a time finds.
// in:     mesh: one component, no border, Euler characteristic 2; triangles counterclockwise seen from outside.
// out:    xyz: 3 numbers for each vertex, of length 1 to rounding; (0,0,0) for those that no triangle has.
// fails:  KN_EDOMAIN no such surface, or one that touches itself at a vertex; KN_EUNDECIDED a vertex finds no place, a
//         triangle vanishes, to rounding; KN_ECANCELLED, KN_ENOMEM; xyz unchanged.
// error:  that each triangle is turned the right way is certain (det of its corners, with its rounding), and that
//         they cover the sphere once.
// cost:   n log n to take vertices away; some 60 moves of each, of about 1 us for each neighbour.
// source: Praun & Hoppe, Spherical parametrization and remeshing, ACM TOG 22 (2003); Horn, Closed-form solution of
//         absolute orientation using unit quaternions, JOSA A 4 (1987).
KN_API KN_CHECKED kn_status kn_mesh_to_sphere(kn_ctx *ctx, double *xyz, const kn_mesh *mesh);
// One connectivity for two meshes: out is a's surface, and vertex i of it turns into target[i] on b.
// in:     the same triangles, vertex by vertex; or two disks (kn_mesh_flatten), over one flat disk then, the border
//         vertices that lie farthest in the first coordinate on one another; or two closed surfaces of genus 0
//         (kn_mesh_to_sphere, but looking inwards or outwards), over one sphere, on which they keep their directions.
// out:    mesh: initialised, overwritten; without normals; a's vertices come first. *target: 3 numbers a vertex, for
//         kn_free. Disks: a's triangles, quartered up to four times until there are as many as b has; positions on b
//         are sampled, points of b's surface at a's vertices; what of b lies between them is lost. Closed surfaces:
//         the vertices of both and the crossings of their edges; each triangle lies in one of a and turns into one
//         that lies in one of b, and all together are a, and b, to rounding.
// fails:  KN_EDOMAIN neither (the message says what they are), KN_ELIMIT (2^24 triangles, about), and as
//         kn_mesh_flatten and kn_mesh_to_sphere; outputs unchanged.
// source: Alexa, Merging polyhedral shapes with scattered features, Visual Computer 16 (2000).
KN_API KN_CHECKED kn_status kn_mesh_morph(kn_ctx *ctx, kn_mesh *out, double **target, const kn_mesh *a,
                                          const kn_mesh *b);

#ifdef __cplusplus
}
#endif
#endif
