// SPDX-License-Identifier: Apache-2.0
// VTK unstructured grids (.vtu) of Bezier cells, which ParaView draws as the curves, surfaces and volumes that they are.
//
// A piece for each block, its arrays as base64 of their length and their numbers, little-endian. Weights are the point
// data that the attribute RationalWeights names; degrees the cell data that HigherOrderDegrees names. Points of a cell:
// corners, edges, faces, inside (vtkHigherOrderQuadrilateral, vtkHigherOrderHexahedron since VTK 9.1; files of version
// 2.1 and later have the upright edges of a hexahedron in the order of its corners).
#include "write/text_sink.h"

#include "kernel/context.h"

#include <string.h>

enum { TRIANGLE = 5, BEZIER_CURVE = 75, BEZIER_QUADRILATERAL = 77, BEZIER_HEXAHEDRON = 79 };

// The arrays of a piece as bytes.
typedef enum array { WEIGHTS, DEGREES, PART, SURFACE, POINTS, CONNECTIVITY, OFFSETS, TYPES, ARRAYS } array;
static const struct {
    const char *type, *name, *more;
} arrays[ARRAYS] = {
    [WEIGHTS] = {"Float64", "RationalWeights", ""},
    [DEGREES] = {"Float64", "HigherOrderDegrees", " NumberOfComponents=\"3\""},
    [PART] = {"Int32", "part", ""},
    [SURFACE] = {"Int32", "surface", ""},
    [POINTS] = {"Float64", "Points", " NumberOfComponents=\"3\""},
    [CONNECTIVITY] = {"Int64", "connectivity", ""},
    [OFFSETS] = {"Int64", "offsets", ""},
    [TYPES] = {"UInt8", "types", ""},
};

typedef struct piece {
    kn_text array[ARRAYS];
    uint64_t points, cells, corners;
} piece;

static void put_little(kn_text *text, uint64_t value, int bytes)
{
    unsigned char b[8];
    for (int i = 0; i < bytes; i++) b[i] = (unsigned char)(value >> (8 * i));
    kn_text_bytes(text, b, (size_t)bytes);
}

static void put_double(kn_text *text, double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    put_little(text, bits, 8);
}

// ---- base64 (RFC 4648) ----

static void put_three(kn_text *text, const unsigned char b[3], size_t n)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    uint32_t bits = (uint32_t)b[0] << 16 | (uint32_t)b[1] << 8 | b[2];
    char out[4] = {digits[bits >> 18], digits[bits >> 12 & 63], digits[bits >> 6 & 63], digits[bits & 63]};
    for (size_t i = n + 1; i < 4; i++) out[i] = '=';
    kn_text_bytes(text, out, 4);
}

// The length, in 8 bytes, and the bytes, as one text.
static void put_base64(kn_text *text, const kn_text *from)
{
    unsigned char three[3];
    size_t n = 0, length = from->bytes;
    for (size_t i = 0; i < 8 + length; i++) {
        three[n++] = i < 8 ? (unsigned char)((uint64_t)length >> (8 * i)) : (unsigned char)from->data[i - 8];
        if (n < 3) continue;
        put_three(text, three, 3);
        n = 0;
    }
    for (size_t i = n; i < 3; i++) three[i] = 0;
    if (n > 0) put_three(text, three, n);
}

// ---- cells ----

// The place of control point (i, j, k) of a cell of degrees p.
static size_t place(int nvars, const int p[3], const int at[3])
{
    size_t i = (size_t)at[0], j = (size_t)at[1], k = (size_t)at[2];
    size_t a = (size_t)p[0] - 1, b = (size_t)p[1] - 1, c = (size_t)p[2] - 1; // inside an edge
    bool on[3] = {i == 0 || i == a + 1, j == 0 || j == b + 1, k == 0 || k == c + 1};
    size_t corner = i > 0 ? (j > 0 ? 2 : 1) : (j > 0 ? 3 : 0), ring = 2 * (a + b);
    if (nvars == 1) return on[0] ? (i > 0) : 1 + i;
    size_t base = nvars == 2 ? 4 : 8, level = nvars == 3 && k > 0;
    bool flat = nvars == 2 || on[2];
    if (on[0] && on[1] && flat) return corner + 4 * level;
    if (on[1] && flat) return base + level * ring + (j > 0 ? a + b : 0) + i - 1;
    if (on[0] && flat) return base + level * ring + (i > 0 ? a : 2 * a + b) + j - 1;
    if (nvars == 2) return base + ring + (i - 1) + a * (j - 1);
    base += 2 * ring;
    if (on[0] && on[1]) return base + corner * c + k - 1;
    base += 4 * c;
    if (on[0]) return base + (i > 0) * b * c + (j - 1) + b * (k - 1);
    base += 2 * b * c;
    if (on[1]) return base + (j > 0) * a * c + (i - 1) + a * (k - 1);
    base += 2 * a * c;
    if (on[2]) return base + (k > 0) * a * b + (i - 1) + a * (j - 1);
    return base + 2 * a * b + (i - 1) + a * ((j - 1) + b * (k - 1));
}

static void put_cell(piece *to, const kn_write_item *item, int type, const int degree[3], size_t points)
{
    to->corners += points;
    to->cells++;
    put_little(&to->array[OFFSETS], to->corners, 8);
    put_little(&to->array[TYPES], (uint64_t)type, 1);
    put_little(&to->array[PART], (uint64_t)(uint32_t)item->patch->look, 4);
    put_little(&to->array[SURFACE], (uint64_t)(uint32_t)item->patch->id.surface, 4);
    for (int d = 0; d < 3; d++) put_double(&to->array[DEGREES], degree[d]);
}

static kn_status put_bezier(kn_ctx *worker, piece *to, const kn_write_item *item, const kn_bezier *b)
{
    static const int types[] = {0, BEZIER_CURVE, BEZIER_QUADRILATERAL, BEZIER_HEXAHEDRON};
    size_t n = kn_bezier_count(b);
    int p[3] = {1, 1, 1}, none[3] = {0, 0, 0};
    kn_mark mark = kn_scratch_mark(worker);
    size_t *at = kn_scratch(worker, n, sizeof *at);
    if (!at) return KN_ENOMEM;
    for (int d = 0; d < b->nvars; d++) p[d] = none[d] = b->degree[d];
    for (size_t q = 0; q < n; q++) {
        int index[3] = {0, 0, 0};
        size_t rest = q;
        for (int d = b->nvars - 1; d >= 0; rest /= (size_t)p[d--] + 1) index[d] = (int)(rest % ((size_t)p[d] + 1));
        at[place(b->nvars, p, index)] = q;
    }
    for (size_t q = 0; q < n; q++) {
        double weight = b->rational ? b->coef[3 * n + at[q]] : 1.0;
        for (size_t c = 0; c < 3; c++) put_double(&to->array[POINTS], b->coef[c * n + at[q]] / weight);
        put_double(&to->array[WEIGHTS], weight);
        put_little(&to->array[CONNECTIVITY], to->points + q, 8);
    }
    to->points += n;
    put_cell(to, item, types[b->nvars], none, n);
    kn_scratch_release(worker, mark);
    return KN_OK;
}

static kn_status put_pieces(kn_ctx *worker, piece *to, const kn_write_item *item)
{
    kn_bezier *list = NULL;
    size_t n = 0;
    kn_status status = kn_spline_to_bezier(worker, &list, &n, &item->spline);
    for (size_t i = 0; i < n; i++) {
        int degree[3] = {0, 0, 0};
        for (int d = 0; d < list[i].nvars; d++) degree[d] = list[i].degree[d] > 1 ? list[i].degree[d] : 1;
        if (status == KN_OK) status = kn_bezier_elevate(worker, &list[i], &list[i], degree); // constants have no cell
        if (status == KN_OK) status = put_bezier(worker, to, item, &list[i]);
        kn_bezier_clear(worker, &list[i]);
    }
    kn_free(worker, list);
    return status;
}

static void put_mesh(piece *to, const kn_write_item *item, const kn_mesh *mesh)
{
    static const int none[3] = {0, 0, 0};
    for (size_t i = 0; i < 3 * mesh->nvertices; i++) put_double(&to->array[POINTS], mesh->position[i]);
    for (size_t i = 0; i < mesh->nvertices; i++) put_double(&to->array[WEIGHTS], 1.0);
    for (size_t t = 0; t < mesh->ntriangles; t++) {
        for (size_t k = 0; k < 3; k++)
            put_little(&to->array[CONNECTIVITY], to->points + mesh->triangle[3 * t + k], 8);
        put_cell(to, item, TRIANGLE, none, 3);
    }
    to->points += mesh->nvertices;
}

static kn_status put_triangles(kn_ctx *worker, piece *to, const kn_write_item *item)
{
    kn_mesh mesh = {0};
    kn_status status = kn_patch_tessellate(worker, &mesh, item->patch);
    if (status == KN_OK) put_mesh(to, item, &mesh);
    kn_mesh_clear(worker, &mesh);
    return status;
}

// ---- pieces ----

static void put_array(kn_text *text, piece *from, array which)
{
    kn_text_put(text, "<DataArray type=\"");
    kn_text_put(text, arrays[which].type);
    kn_text_put(text, "\" Name=\"");
    kn_text_put(text, arrays[which].name);
    kn_text_char(text, '"');
    kn_text_put(text, arrays[which].more);
    kn_text_put(text, " format=\"binary\">");
    put_base64(text, &from->array[which]);
    kn_text_put(text, "</DataArray>\n");
}

static void put_piece(kn_text *text, piece *from)
{
    kn_text_put(text, "<Piece NumberOfPoints=\"");
    kn_text_integer(text, from->points);
    kn_text_put(text, "\" NumberOfCells=\"");
    kn_text_integer(text, from->cells);
    kn_text_put(text, "\">\n<PointData RationalWeights=\"RationalWeights\">\n");
    put_array(text, from, WEIGHTS);
    kn_text_put(text, "</PointData>\n<CellData HigherOrderDegrees=\"HigherOrderDegrees\">\n");
    put_array(text, from, DEGREES);
    put_array(text, from, PART);
    put_array(text, from, SURFACE);
    kn_text_put(text, "</CellData>\n<Points>\n");
    put_array(text, from, POINTS);
    kn_text_put(text, "</Points>\n<Cells>\n");
    put_array(text, from, CONNECTIVITY);
    put_array(text, from, OFFSETS);
    put_array(text, from, TYPES);
    kn_text_put(text, "</Cells>\n</Piece>\n");
}

static kn_status put_block(kn_ctx *worker, kn_text *text, const kn_write_text *w, const kn_write_item *items,
                           size_t n)
{
    (void)w;
    piece p = {.points = 0};
    kn_status status = KN_OK;
    for (int a = 0; a < ARRAYS; a++) p.array[a].ctx = worker;
    for (size_t i = 0; status == KN_OK && i < n; i++) {
        bool triangles = items[i].patch->mesh || items[i].trim.nloops > 0;
        status = triangles ? put_triangles(worker, &p, &items[i]) : put_pieces(worker, &p, &items[i]);
    }
    for (int a = 0; a < ARRAYS; a++)
        if (status == KN_OK && p.array[a].failed) status = KN_ENOMEM;
    if (status == KN_OK) put_piece(text, &p);
    for (int a = 0; a < ARRAYS; a++) kn_text_clear(&p.array[a]);
    return status;
}

static void put_head(kn_text *text, const kn_write_text *w)
{
    kn_text_put(text, "<?xml version=\"1.0\"?>\n<!-- knurl " KN_VERSION_STRING "; parts:");
    for (int i = 0; i < w->nlooks; i++) { // no "--" in a comment
        char name[KN_NAME_BYTES];
        memcpy(name, w->looks[i].name, sizeof name);
        for (char *c = name; *c; c++)
            if (*c == '-' || *c == ' ') *c = '_';
        kn_text_char(text, ' ');
        kn_text_utf8(text, name);
    }
    kn_text_put(text, " -->\n<VTKFile type=\"UnstructuredGrid\" version=\"2.2\" byte_order=\"LittleEndian\" "
                      "header_type=\"UInt64\">\n<UnstructuredGrid>\n");
}

// A grid without a piece is none to VTK.
static void put_tail(kn_text *text, const kn_write_text *w)
{
    piece none = {.points = 0};
    if (w->lo[0] > w->hi[0]) put_piece(text, &none);
    kn_text_put(text, "</UnstructuredGrid>\n</VTKFile>\n");
}

kn_status kn_vtu_sink(kn_ctx *ctx, kn_sink *out, const char *path)
{
    static const kn_write_format format = {
        .name = "VTK .vtu",
        .holds = KN_WRITE_CURVES | KN_WRITE_SURFACES | KN_WRITE_VOLUMES | KN_WRITE_TRIMMED | KN_WRITE_MESHES,
        .head = put_head,
        .block = put_block,
        .tail = put_tail,
    };
    return kn_write_text_sink(ctx, out, path, &format);
}
