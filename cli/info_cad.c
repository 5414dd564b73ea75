// SPDX-License-Identifier: Apache-2.0
// knurl info FILE.step: the bodies and faces of a CAD file.
#include "cli/cli.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

// The colour as #rrggbb, "" without one.
typedef struct hex {
    char text[8];
} hex;
static hex color_of(const kn_cad_face *f)
{
    hex out = {""};
    int x[3];
    for (int c = 0; c < 3; c++) {
        double l = f->color[c];
        x[c] = (int)lround(255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * pow(l, 1 / 2.4) - 0.055));
    }
    if (f->colored) snprintf(out.text, sizeof out.text, "#%02x%02x%02x", x[0] & 255, x[1] & 255, x[2] & 255);
    return out;
}

// The neighbours of a face across its edges, each once, ascending; a seam is none. Answers their number.
static int neighbours(const kn_cad *cad, int face, int *out, int most)
{
    const kn_cad_face *f = &cad->faces[face];
    int n = 0;
    for (int k = 0; k < f->trim.ncurves; k++) {
        const kn_cad_edge *e = &cad->edges[f->edge[k]];
        int other = e->face[0] == face ? e->face[1] : e->face[0], i = 0;
        if (other < 0 || other == face) continue;
        while (i < n && out[i] < other) i++;
        if (n == most || (i < n && out[i] == other)) continue;
        memmove(out + i + 1, out + i, (size_t)(n - i) * sizeof *out);
        out[i] = other;
        n++;
    }
    return n;
}

static int open_edges(const kn_cad *cad, const kn_cad_face *f)
{
    int n = 0;
    for (int k = 0; k < f->trim.ncurves; k++)
        n += cad->edges[f->edge[k]].face[1] < 0 && !cad->edges[f->edge[k]].point;
    return n;
}

enum { MOST_SHOWN = 256 };

static json_t *face_json(const kn_cad *cad, int i)
{
    const kn_cad_face *f = &cad->faces[i];
    int next[MOST_SHOWN], n = neighbours(cad, i, next, MOST_SHOWN);
    double u[2], v[2];
    kn_spline_domain(&f->surface, 0, &u[0], &u[1]);
    kn_spline_domain(&f->surface, 1, &v[0], &v[1]);
    json_t *across = json_array();
    for (int k = 0; k < n; k++) json_array_append_new(across, json_integer(next[k]));
    return json_pack("{s:i,s:o,s:s,s:o,s:i,s:[ii],s:b,s:[[ff],[ff]],s:b,s:i,s:i,s:i,s:o,s:f,s:f}", "face", i, "name",
                     cli_json_text(f->name), "type", kn_cad_type_name(f->type), "color",
                     f->colored ? json_string(color_of(f).text) : json_null(), "body", f->body, "degree",
                     f->surface.degree[0], f->surface.degree[1], "rational", f->surface.rational, "domain", u[0],
                     u[1], v[0], v[1], "whole", f->whole, "loops", f->trim.nloops, "edges", f->trim.ncurves,
                     "open_edges", open_edges(cad, f), "neighbours", across, "error", f->error, "trim_error",
                     f->trim_error);
}

static json_t *body_json(const kn_cad_body *b)
{
    json_t *place = json_array();
    for (int k = 0; k < 12; k++) json_array_append_new(place, json_real(b->place[k]));
    return json_pack("{s:o,s:b,s:i,s:o}", "name", cli_json_text(b->name), "solid", b->solid, "instances",
                     b->instances, "place", place);
}

static json_t *edge_json(const kn_cad_edge *e)
{
    return json_pack("{s:[i,i],s:b,s:b,s:o}", "faces", e->face[0], e->face[1], "point", e->point, "more", e->more,
                     "angle", e->face[1] >= 0 && !e->point ? json_real(e->angle * (180 / acos(-1.0))) : json_null());
}

static void print_cad_json(const char *file, const kn_cad *cad)
{
    json_t *faces = json_array(), *bodies = json_array(), *edges = json_array();
    for (int i = 0; i < cad->nfaces; i++) json_array_append_new(faces, face_json(cad, i));
    for (int i = 0; i < cad->nbodies; i++) json_array_append_new(bodies, body_json(&cad->bodies[i]));
    for (int i = 0; i < cad->nedges; i++) json_array_append_new(edges, edge_json(&cad->edges[i]));
    json_t *o = json_pack("{s:o,s:s,s:s,s:o,s:o,s:o}", "file", cli_json_text(file), "format", "CAD", "unit", "mm",
                          "bodies", bodies, "faces", faces, "edges", edges);
    json_dumpf(o, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(15));
    putchar('\n');
    json_decref(o);
}

static void print_face(const kn_cad *cad, int i)
{
    const kn_cad_face *f = &cad->faces[i];
    int next[MOST_SHOWN], n = neighbours(cad, i, next, MOST_SHOWN);
    char degrees[32];
    snprintf(degrees, sizeof degrees, "%dx%d%s", f->surface.degree[0], f->surface.degree[1],
             f->surface.rational ? " rat" : "");
    printf("%5d  %-10s %-9s %-8s %-16s", i, kn_cad_type_name(f->type), degrees, color_of(f).text,
           *f->name ? f->name : "-");
    printf(f->whole ? " whole" : " %d loop%s", f->trim.nloops, f->trim.nloops == 1 ? "" : "s");
    for (int k = 0; k < n && k < 12; k++) printf("%s%d", k > 0 ? "," : "; beside ", next[k]);
    if (n > 12) printf(",..");
    if (open_edges(cad, f) > 0) printf("; %d open", open_edges(cad, f));
    putchar('\n');
}

static void print_cad(const char *file, const kn_cad *cad)
{
    printf("%s: CAD, in millimetres, each part in its own coordinates\n", file);
    printf("      %d bod%s, %d face%s, %d edge%s\n", cad->nbodies, cad->nbodies == 1 ? "y" : "ies", cad->nfaces,
           cad->nfaces == 1 ? "" : "s", cad->nedges, cad->nedges == 1 ? "" : "s");
    printf(" face  type       degree    colour   name\n");
    for (int b = 0, i = 0; b < cad->nbodies; b++) {
        const kn_cad_body *body = &cad->bodies[b];
        printf("body %d '%s', %s, %d time%s\n", b, body->name, body->solid ? "solid" : "open", body->instances,
               body->instances == 1 ? "" : "s");
        for (; i < cad->nfaces && cad->faces[i].body == b; i++) print_face(cad, i);
    }
}

int cli_info_cad(cli_session *session, const char *file, bool json)
{
    kn_cad cad = {0};
    kn_status status = cli_read_cad(cli_ctx(session), &cad, file);
    if (status != KN_OK) return cli_fail(session, status, true);
    if (json)
        print_cad_json(file, &cad);
    else
        print_cad(file, &cad);
    kn_cad_clear(cli_ctx(session), &cad);
    return EXIT_OK;
}
