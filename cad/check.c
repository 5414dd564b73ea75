// SPDX-License-Identifier: Apache-2.0
// kn_cad_check.
#include <knurl/cad.h>

#include "kernel/context.h"

#include <math.h>
#include <string.h>

static kn_status check_name(kn_ctx *ctx, const char *name, const char *kind, int i)
{
    if (!memchr(name, '\0', KN_NAME_BYTES))
        return kn_fail(ctx, KN_EDOMAIN, "cad: %s %d: its name does not end", kind, i);
    for (const char *c = name; *c; c++)
        if ((unsigned char)*c < ' ' || *c == 127)
            return kn_fail(ctx, KN_EDOMAIN, "cad: %s %d: a control character in its name", kind, i);
    return KN_OK;
}

static kn_status check_body(kn_ctx *ctx, const kn_cad *cad, int i)
{
    const kn_cad_body *b = &cad->bodies[i];
    if (b->instances < 1) return kn_fail(ctx, KN_EDOMAIN, "cad: body %d: %d instances", i, b->instances);
    for (int k = 0; k < 12; k++)
        if (!isfinite(b->place[k])) return kn_fail(ctx, KN_EDOMAIN, "cad: body %d: its placement is not finite", i);
    return check_name(ctx, b->name, "body", i);
}

// Whether curve c lies on a side of the square: one coordinate is 0 or 1 all along.
static bool on_side(const kn_spline *c)
{
    int n = c->count[0];
    for (int v = 0; v < 2; v++) {
        const double *x = c->coef + v * n;
        bool all = x[0] == 0.0 || x[0] == 1.0;
        for (int k = 1; all && k < n; k++) all = x[k] == x[0];
        if (all) return true;
    }
    return false;
}

static kn_status check_face(kn_ctx *ctx, const kn_cad *cad, int i)
{
    const kn_cad_face *f = &cad->faces[i];
    if (!kn_cad_type_name(f->type)) return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: type %d", i, (int)f->type);
    if (f->shell < 0) return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: shell %d", i, f->shell);
    if (f->body < 0 || f->body >= cad->nbodies)
        return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: body %d of %d", i, f->body, cad->nbodies);
    for (int c = 0; c < 3; c++)
        if (!(f->color[c] >= 0.0 && f->color[c] <= 1.0))
            return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: colour %g", i, f->color[c]);
    if (!(f->error >= 0.0 && isfinite(f->error) && f->trim_error >= 0.0 && isfinite(f->trim_error)))
        return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: errors %g, %g", i, f->error, f->trim_error);
    if (f->surface.nvars != 2 || kn_spline_dim(&f->surface) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: no surface in three dimensions", i);
    kn_status status = kn_spline_check(ctx, &f->surface);
    if (status == KN_OK) status = kn_trim_check(ctx, &f->trim);
    if (status != KN_OK) return status;
    if (f->trim.nloops == 0 || !f->edge) return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: no trim", i);
    bool sides = f->trim.nloops == 1;
    for (int k = 0; k < f->trim.ncurves; k++) {
        if (f->edge[k] < 0 || f->edge[k] >= cad->nedges)
            return kn_fail(ctx, KN_EDOMAIN, "cad: face %d, curve %d: edge %d of %d", i, k, f->edge[k], cad->nedges);
        const kn_cad_edge *e = &cad->edges[f->edge[k]];
        bool used = (e->face[0] == i && e->curve[0] == k) || (e->face[1] == i && e->curve[1] == k);
        if (!used && !e->more)
            return kn_fail(ctx, KN_EDOMAIN, "cad: face %d, curve %d: edge %d has other faces", i, k, f->edge[k]);
        sides = sides && on_side(&f->trim.curves[k]);
    }
    if (f->whole && !sides) return kn_fail(ctx, KN_EDOMAIN, "cad: face %d: its trim is not the whole square", i);
    return check_name(ctx, f->name, "face", i);
}

static kn_status check_line(kn_ctx *ctx, const kn_cad *cad, int i)
{
    const kn_cad_edge *e = &cad->edges[i];
    const kn_spline *l = &e->line;
    int n = l->count[0];
    if (e->point || l->nvars != 1 || kn_spline_dim(l) != 3)
        return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: no line in three dimensions", i);
    kn_status status = kn_spline_check(ctx, l);
    if (status != KN_OK) return status;
    if (!(e->error >= 0.0 && isfinite(e->error)))
        return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: error %g", i, e->error);
    for (int k = 0; k < 2; k++) {
        if (e->vertex[k] < 0 || e->vertex[k] >= cad->nvertices)
            return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: vertex %d of %d", i, e->vertex[k], cad->nvertices);
        double square = 0.0, size = 0.0;
        for (int c = 0; c < 3; c++) {
            int at = k == 0 ? 0 : n - 1;
            double x = l->coef[c * n + at] / (l->rational ? l->coef[3 * n + at] : 1.0);
            double y = cad->vertices[e->vertex[k]].at[c];
            square += (x - y) * (x - y), size += fabs(y);
        }
        if (!(sqrt(square) <= e->error + 1e-12 * size)) // rounding, of weights too
            return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d does not end at vertex %d", i, e->vertex[k]);
    }
    return KN_OK;
}

static kn_status check_edge(kn_ctx *ctx, const kn_cad *cad, int i)
{
    const kn_cad_edge *e = &cad->edges[i];
    for (int k = 0; k < 2; k++) {
        int face = e->face[k], curve = e->curve[k];
        if (k == 1 && face == -1) continue;
        if (face < 0 || face >= cad->nfaces)
            return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: face %d of %d", i, face, cad->nfaces);
        const kn_cad_face *f = &cad->faces[face];
        if (curve < 0 || curve >= f->trim.ncurves || f->edge[curve] != i)
            return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: curve %d of face %d does not lie along it", i, curve,
                           face);
    }
    if (e->face[0] == e->face[1] && e->curve[0] == e->curve[1])
        return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: one curve twice", i);
    if (!(e->angle >= 0.0 && e->angle <= 3.1415926535897936))
        return kn_fail(ctx, KN_EDOMAIN, "cad: edge %d: angle %g", i, e->angle);
    return e->line.nvars != 0 ? check_line(ctx, cad, i) : KN_OK;
}

// Over the domain of the edge's line, from end to end of the trim's curve.
static bool lies_along(const kn_spline *plane, const kn_spline *line, const kn_spline *curve, bool against)
{
    double lo[2], hi[2];
    int n = plane->count[0], m = curve->count[0];
    bool good = plane->nvars == 1 && plane->ncomp == 2 && !plane->rational;
    if (!good) return false;
    kn_spline_domain(plane, 0, &lo[0], &hi[0]);
    kn_spline_domain(line, 0, &lo[1], &hi[1]);
    good = lo[0] == lo[1] && hi[0] == hi[1];
    for (int c = 0; c < 2; c++) {
        const double *x = plane->coef + c * n, *y = curve->coef + c * m;
        good = good && x[0] == y[against ? m - 1 : 0] && x[n - 1] == y[against ? 0 : m - 1];
        for (int k = 0; k < n; k++) good = good && x[k] >= -1.0 && x[k] <= 2.0; // as of a trim
    }
    return good;
}

static kn_status check_uses(kn_ctx *ctx, const kn_cad *cad, int i)
{
    const kn_cad_face *f = &cad->faces[i];
    for (int k = 0; f->use && k < f->trim.ncurves; k++) {
        const kn_spline *plane = &f->use[k].plane, *line = &cad->edges[f->edge[k]].line;
        if (plane->nvars == 0) continue;
        kn_status status = kn_spline_check(ctx, plane);
        if (status != KN_OK) return status;
        if (line->nvars == 0 || !lies_along(plane, line, &f->trim.curves[k], f->use[k].against))
            return kn_fail(ctx, KN_EDOMAIN, "cad: face %d, curve %d: its plane does not lie along edge %d", i, k,
                           f->edge[k]);
    }
    return KN_OK;
}

kn_status kn_cad_check(kn_ctx *ctx, const kn_cad *cad)
{
    if (cad->nfaces < 0 || cad->nedges < 0 || cad->nbodies < 0 || cad->nvertices < 0 ||
        (cad->nfaces > 0 && !cad->faces) || (cad->nedges > 0 && !cad->edges) || (cad->nbodies > 0 && !cad->bodies) ||
        (cad->nvertices > 0 && !cad->vertices))
        return kn_fail(ctx, KN_EDOMAIN, "cad: %d faces, %d edges, %d vertices, %d bodies", cad->nfaces, cad->nedges,
                       cad->nvertices, cad->nbodies);
    kn_status status = KN_OK;
    for (int i = 0; status == KN_OK && i < cad->nbodies; i++) status = check_body(ctx, cad, i);
    for (int i = 0; status == KN_OK && i < cad->nfaces; i++) status = check_face(ctx, cad, i);
    for (int i = 0; status == KN_OK && i < cad->nedges; i++) status = check_edge(ctx, cad, i);
    for (int i = 0; status == KN_OK && i < cad->nfaces; i++) status = check_uses(ctx, cad, i);
    return status;
}
