// SPDX-License-Identifier: Apache-2.0
// kn_cad_write.
#include "cad/stream.h"
#include "io/state.h"

#include <string.h>

static void put_u32(kn_state *s, uint32_t x)
{
    unsigned char bytes[4];
    for (int i = 0; i < 4; i++) bytes[i] = (unsigned char)(x >> (8 * i));
    kn_state_put(s, bytes, sizeof bytes);
}

static void put_int(kn_state *s, int x)
{
    put_u32(s, (uint32_t)x); // two's complement
}

static void put_f64(kn_state *s, const double *x, size_t n)
{
    for (size_t k = 0; k < n; k++) {
        uint64_t bits;
        unsigned char bytes[8];
        memcpy(&bits, &x[k], sizeof bits);
        for (int i = 0; i < 8; i++) bytes[i] = (unsigned char)(bits >> (8 * i));
        kn_state_put(s, bytes, sizeof bytes);
    }
}

static void put_name(kn_state *s, const char *name)
{
    char padded[KN_NAME_BYTES] = {0};
    memcpy(padded, name, strlen(name));
    kn_state_put(s, padded, sizeof padded);
}

static void put_spline(kn_state *s, const kn_spline *a)
{
    put_int(s, a->nvars);
    put_int(s, a->ncomp);
    put_int(s, a->rational);
    for (int d = 0; d < a->nvars; d++) {
        put_int(s, a->degree[d]);
        put_int(s, a->count[d]);
        put_f64(s, a->knots[d], (size_t)(a->count[d] + a->degree[d] + 1));
    }
    put_f64(s, a->coef, kn_spline_count(a) * (size_t)a->ncomp);
}

static void put_face(kn_state *s, const kn_cad_face *f)
{
    put_name(s, f->name);
    put_int(s, (int)f->type);
    put_int(s, f->body);
    put_int(s, f->shell);
    put_int(s, (f->colored ? KN_CAD_COLORED : 0) | (f->whole ? KN_CAD_WHOLE : 0) | (f->use ? KN_CAD_USES : 0));
    put_f64(s, f->color, 3);
    put_f64(s, &f->error, 1);
    put_f64(s, &f->trim_error, 1);
    put_spline(s, &f->surface);
    put_int(s, f->trim.ncurves);
    put_int(s, f->trim.nloops);
    for (int i = 0; i < f->trim.nloops; i++) put_int(s, f->trim.loop_end[i]);
    for (int i = 0; i < f->trim.ncurves; i++) put_int(s, f->edge[i]);
    for (int i = 0; i < f->trim.ncurves; i++) put_spline(s, &f->trim.curves[i]);
    for (int i = 0; f->use && i < f->trim.ncurves; i++) {
        const kn_cad_use *use = &f->use[i];
        put_int(s, (use->against ? KN_CAD_AGAINST : 0) | (use->plane.nvars > 0 ? KN_CAD_HAS_PLANE : 0));
        if (use->plane.nvars > 0) put_spline(s, &use->plane);
    }
}

static void put_edge(kn_state *s, const kn_cad_edge *e)
{
    bool line = e->line.nvars > 0;
    for (int k = 0; k < 2; k++) put_int(s, e->face[k]);
    for (int k = 0; k < 2; k++) put_int(s, e->curve[k]);
    put_int(s, (e->more ? KN_CAD_MORE : 0) | (e->point ? KN_CAD_POINT : 0) | (line ? KN_CAD_HAS_LINE : 0));
    put_f64(s, &e->angle, 1);
    for (int k = 0; k < 2 && line; k++) put_int(s, e->vertex[k]);
    if (line) put_f64(s, &e->error, 1), put_spline(s, &e->line);
}

kn_status kn_cad_write(kn_ctx *ctx, unsigned char **data, size_t *bytes, const kn_cad *cad)
{
    kn_state s = {.ctx = ctx};
    const unsigned char head[8] = {'K', 'N', 'C', 'A', 'D', 0, 0, KN_CAD_VERSION};
    kn_state_put(&s, head, sizeof head);
    put_int(&s, cad->nbodies);
    put_int(&s, cad->nvertices);
    put_int(&s, cad->nedges);
    put_int(&s, cad->nfaces);
    for (int i = 0; i < cad->nbodies; i++) {
        const kn_cad_body *b = &cad->bodies[i];
        put_name(&s, b->name);
        put_int(&s, b->solid);
        put_int(&s, b->instances);
        put_f64(&s, b->place, 12);
    }
    for (int i = 0; i < cad->nvertices; i++) put_f64(&s, cad->vertices[i].at, 3);
    for (int i = 0; i < cad->nedges; i++) put_edge(&s, &cad->edges[i]);
    for (int i = 0; i < cad->nfaces; i++) put_face(&s, &cad->faces[i]);
    return kn_state_give(&s, data, bytes, KN_OK);
}
