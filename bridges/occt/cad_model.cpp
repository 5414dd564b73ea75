// SPDX-License-Identifier: Apache-2.0
// Documents of OCCT as kn_cad: faces with their trims, edges with their two faces.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include <BRep_TEdge.hxx>
#include <BRep_Tool.hxx>
#include <Geom_Surface.hxx>
#include <TopAbs_ShapeEnum.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Vertex.hxx>

#include "bridges/occt/cad_model.hpp"
#include "bridges/occt/cad_trim.hpp"
#include "bridges/occt/guard.hpp"

namespace kn_occt
{
namespace
{

const double trim_tolerance = 1e-5; // mm

// A face on its way: what is needed until the edges know their faces.
struct shape {
    Handle(Geom_Surface) surface;
    bool reversed;
    chart square;
    std::vector<use> uses; // one for each curve of the trim
};

// The curve of an edge in space.
struct line {
    bool there = false;
    double first = 0.0, last = 1.0;
    section curve;
};

struct converter {
    kn_ctx *ctx;
    kn_cad *cad;
    document *d;
    std::vector<shape> shapes;
    std::vector<kn_cad_edge> edges;
    std::vector<kn_cad_vertex> vertices;
    TopTools_IndexedMapOfShape known;   // edges of the body at hand
    TopTools_IndexedMapOfShape corners; // and its vertices
    size_t first_vertex = 0, first_edge = 0, first_face = 0;
    int dropped = 0;
    std::string why;
    ~converter() // lines that the model has not got
    {
        for (kn_cad_edge &e : edges) kn_spline_clear(ctx, &e.line);
    }
};

template <class T> T *array(kn_ctx *ctx, size_t n)
{
    void *block = kn_alloc_zero(ctx, n, sizeof(T));
    if (!block) throw failed{KN_ENOMEM};
    return static_cast<T *>(block);
}

// UTF-8 cut at a whole character, without control characters.
void set_name(char out[KN_NAME_BYTES], const std::string &name)
{
    size_t n = std::min(name.size(), static_cast<size_t>(KN_NAME_BYTES - 1));
    while (n > 0 && n < name.size() && (static_cast<unsigned char>(name[n]) & 0xc0) == 0x80) n--;
    for (size_t i = 0; i < n; i++)
        out[i] = static_cast<unsigned char>(name[i]) < ' ' || name[i] == 127 ? '?' : name[i];
    out[n] = '\0';
}

void set_surface(kn_ctx *ctx, kn_spline *out, const patch &p, bool reversed)
{
    int count[2], degree[2] = {p.degree[0], p.degree[1]};
    const double *knots[2] = {p.knots[0].data(), p.knots[1].data()};
    for (int d = 0; d < 2; d++) count[d] = static_cast<int>(p.knots[d].size()) - degree[d] - 1;
    size_t n = p.poles.size();
    if (count[0] < 1 || count[1] < 1 || static_cast<size_t>(count[0]) * static_cast<size_t>(count[1]) != n)
        throw Standard_Failure("knots and poles of a surface do not agree");
    int comps = p.rational ? 4 : 3;
    std::vector<double> coef(static_cast<size_t>(comps) * n);
    for (size_t i = 0; i < n; i++) {
        const double x[4] = {p.poles[i].x, p.poles[i].y, p.poles[i].z, p.poles[i].w};
        for (int c = 0; c < comps; c++) coef[static_cast<size_t>(c) * n + i] = x[c];
    }
    check(kn_spline_init(ctx, out, 2, comps, p.rational, degree, count, knots, coef.data()));
    check(kn_spline_check(ctx, out));
    if (reversed) check(kn_spline_reverse(ctx, out, out, 0));
}

// The longest row of control points in each direction: how many mm all of the parameter is, at most about.
void set_sizes(chart *c, const patch &p)
{
    size_t rows = p.knots[0].size() - static_cast<size_t>(p.degree[0]) - 1, cols = p.poles.size() / rows;
    auto apart = [&](size_t i, size_t k) {
        const pole &a = p.poles[i], &b = p.poles[k];
        return std::hypot(a.x / a.w - b.x / b.w, a.y / a.w - b.y / b.w, a.z / a.w - b.z / b.w);
    };
    c->size[0] = c->size[1] = 0.0;
    for (size_t j = 0; j < cols; j++) {
        double sum = 0.0;
        for (size_t i = 0; i + 1 < rows; i++) sum += apart(i * cols + j, (i + 1) * cols + j);
        c->size[0] = std::max(c->size[0], sum);
    }
    for (size_t i = 0; i < rows; i++) {
        double sum = 0.0;
        for (size_t j = 0; j + 1 < cols; j++) sum += apart(i * cols + j, i * cols + j + 1);
        c->size[1] = std::max(c->size[1], sum);
    }
}

double near_of(double size)
{
    return std::min(std::max(1e-6 / size, 2e-7), 1e-4);
}

// Coordinates near a side of the square lie on it: all of them of a curve along it, and ends.
double snap_axis(std::vector<double> *x, double size)
{
    double near = near_of(size), moved = 0.0;
    for (double side : {0.0, 1.0}) {
        bool all = true;
        for (double v : *x) all = all && std::fabs(v - side) <= near;
        for (size_t i = 0; all && i < x->size(); i++) (*x)[i] = side;
    }
    for (double *end : {&x->front(), &x->back()}) {
        double was = *end;
        if (*end <= near) *end = 0.0;
        if (*end >= 1.0 - near) *end = 1.0;
        moved = std::max(moved, std::fabs(*end - was));
    }
    return moved * size;
}

double joint_of(double a, double b)
{
    bool a_on = a == 0.0 || a == 1.0, b_on = b == 0.0 || b == 1.0;
    return a_on ? a : b_on ? b : 0.5 * (a + b);
}

// Each curve of a loop begins where the one before ends, bit for bit. Answers the widest gap, mm.
double close_loop(std::vector<outline> *curves, const std::vector<use> &uses, const chart &c)
{
    double widest = 0.0;
    for (outline &o : *curves) o.error = std::max({o.error, snap_axis(&o.x, c.size[0]), snap_axis(&o.y, c.size[1])});
    for (size_t i = 0; i < curves->size(); i++) {
        outline &a = (*curves)[i], &b = (*curves)[(i + 1) % curves->size()];
        double gap = std::hypot((a.x.back() - b.x.front()) * c.size[0], (a.y.back() - b.y.front()) * c.size[1]);
        TopoDS_Vertex v = TopExp::LastVertex(uses[i].edge, Standard_True);
        double most = std::max(0.01, v.IsNull() ? 0.0 : 4 * BRep_Tool::Tolerance(v));
        if (!(gap <= most)) throw Standard_Failure("a loop that is not closed on its surface");
        widest = std::max(widest, gap);
        a.x.back() = b.x.front() = joint_of(a.x.back(), b.x.front());
        a.y.back() = b.y.front() = joint_of(a.y.back(), b.y.front());
    }
    return widest;
}

void turn_outline(outline *o)
{
    std::reverse(o->x.begin(), o->x.end());
    std::reverse(o->y.begin(), o->y.end());
    std::reverse(o->knots.begin(), o->knots.end());
    for (double &k : o->knots) k = -k;
}

void set_curve(kn_ctx *ctx, kn_spline *out, const outline &o)
{
    int count = static_cast<int>(o.x.size());
    const double *knots = o.knots.data();
    std::vector<double> coef = o.x;
    coef.insert(coef.end(), o.y.begin(), o.y.end());
    check(kn_spline_init(ctx, out, 1, 2, false, &o.degree, &count, &knots, coef.data()));
}

// The sides of the square, for a face without loops.
std::vector<outline> sides()
{
    std::vector<outline> out(4);
    const double corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    for (size_t i = 0; i < 4; i++) {
        out[i].knots = {0, 0, 1, 1};
        out[i].x = {corner[i][0], corner[i + 1][0]};
        out[i].y = {corner[i][1], corner[i + 1][1]};
    }
    return out;
}

// The curves of one loop, in order, left of them what is inside; on a surface that is run through backwards
// they turn,
// too.
std::vector<outline> curves_of(loop *l, const chart &c, bool reversed)
{
    std::vector<outline> out;
    for (const use &u : *l) {
        out.push_back(outline_of(u, c, trim_tolerance));
        if (u.reversed) turn_outline(&out.back());
    }
    double gap = close_loop(&out, *l, c);
    for (outline &o : out) o.error = std::max(o.error, gap / 2);
    if (!reversed) return out;
    std::reverse(out.begin(), out.end());
    std::reverse(l->begin(), l->end());
    for (outline &o : out) {
        for (double &x : o.x) x = 1.0 - x;
        turn_outline(&o);
    }
    return out;
}

bool all_on_sides(const std::vector<outline> &curves)
{
    for (const outline &o : curves) {
        bool on[2] = {false, false};
        for (int d = 0; d < 2; d++) {
            const std::vector<double> &x = d == 0 ? o.x : o.y;
            on[d] = x[0] == 0.0 || x[0] == 1.0;
            for (double v : x) on[d] = on[d] && v == x[0];
        }
        if (!on[0] && !on[1]) return false;
    }
    return true;
}

// The number of an edge of the body, new or not; it gets this use.
int note_use(converter *k, const TopoDS_Edge *edge, bool point, int face, int curve)
{
    size_t before = static_cast<size_t>(k->known.Extent());
    size_t i = k->edges.size();
    if (edge) i = k->first_edge + static_cast<size_t>(k->known.Add(edge->Oriented(TopAbs_FORWARD))) - 1;
    if (!edge) { // one that no other face can have: its place in the map is taken by a shape of its own
        TopoDS_Edge none;
        none.TShape(new BRep_TEdge);
        i = k->first_edge + static_cast<size_t>(k->known.Add(none)) - 1;
    }
    if (static_cast<size_t>(k->known.Extent()) > before) {
        kn_cad_edge e = {};
        e.face[0] = face, e.curve[0] = curve;
        e.face[1] = e.curve[1] = -1;
        e.point = point;
        k->edges.push_back(e);
    } else if (k->edges[i].face[1] < 0) {
        k->edges[i].face[1] = face, k->edges[i].curve[1] = curve;
    } else {
        k->edges[i].more = true;
    }
    return static_cast<int>(i);
}

void set_trim(converter *k, kn_cad_face *out, shape *s, std::vector<loop> *loops, const chart &c)
{
    std::vector<outline> all;
    std::vector<int> ends;
    for (loop &l : *loops) {
        std::vector<outline> curves = curves_of(&l, c, s->reversed);
        all.insert(all.end(), curves.begin(), curves.end());
        s->uses.insert(s->uses.end(), l.begin(), l.end());
        ends.push_back(static_cast<int>(all.size()));
    }
    if (loops->empty()) all = sides(), ends = {4};
    out->trim.curves = array<kn_spline>(k->ctx, all.size());
    out->trim.loop_end = array<int>(k->ctx, ends.size());
    out->edge = array<int>(k->ctx, all.size());
    out->trim.nloops = static_cast<int>(ends.size());
    std::copy(ends.begin(), ends.end(), out->trim.loop_end);
    for (size_t i = 0; i < all.size(); i++) {
        out->trim_error = std::max(out->trim_error, all[i].error);
        set_curve(k->ctx, &out->trim.curves[i], all[i]);
        out->trim.ncurves++;
    }
    out->whole = ends.size() == 1 && all_on_sides(all);
    check(kn_trim_check(k->ctx, &out->trim));
}

void convert(converter *k, kn_cad_face *out, shape *s, const face &f)
{
    s->reversed = f.shape.Orientation() == TopAbs_REVERSED;
    s->surface = BRep_Tool::Surface(f.shape);
    if (s->surface.IsNull()) throw Standard_Failure("a face without a surface");
    std::vector<loop> loops = loops_of(f.shape);
    double box[4];
    box_of(box, f.shape, loops);
    patch p = patch_of(s->surface, box);
    chart c;
    for (int d = 0; d < 2; d++) c.w[d] = p.w[d], c.lo[d] = p.knots[d].front(), c.hi[d] = p.knots[d].back();
    set_sizes(&c, p);
    if (!(c.size[0] > 0.0 && c.size[1] > 0.0)) throw Standard_Failure("a surface without area");
    set_name(out->name, f.name);
    out->type = type_of(s->surface);
    out->body = f.body;
    out->shell = f.shell;
    out->colored = f.colored;
    for (int i = 0; i < 3; i++) out->color[i] = std::min(std::max(f.color[i], 0.0), 1.0);
    out->error = p.error;
    set_surface(k->ctx, &out->surface, p, s->reversed);
    set_trim(k, out, s, &loops, c);
    s->square = c;
}

void clear_face(kn_ctx *ctx, kn_cad_face *f)
{
    kn_spline_clear(ctx, &f->surface);
    kn_trim_clear(ctx, &f->trim);
    kn_free(ctx, f->edge), kn_free(ctx, f->use); // no use is known yet
    *f = kn_cad_face();
}

// One face, or the reason why it is left out.
bool try_face(converter *k, const face &f)
{
    kn_cad_face *out = &k->cad->faces[k->cad->nfaces];
    shape s;
    std::string why;
    try {
        convert(k, out, &s, f);
        k->cad->nfaces++;
        k->shapes.push_back(s);
        return true;
    } catch (const failed &failure) {
        if (failure.status == KN_ENOMEM) {
            clear_face(k->ctx, out);
            throw;
        }
        why = kn_ctx_message(k->ctx);
        kn_ctx_clear_error(k->ctx);
    } catch (const Standard_Failure &failure) {
        const char *text = failure.GetMessageString();
        why = text && *text ? text : failure.DynamicType()->Name();
    }
    clear_face(k->ctx, out); // it is not among those that count
    if (k->dropped++ == 0) k->why = "face " + std::to_string(k->shapes.size()) + ": " + why;
    return false;
}

void note_edges(converter *k, int face)
{
    kn_cad_face *f = &k->cad->faces[face];
    const std::vector<use> &uses = k->shapes[static_cast<size_t>(face)].uses;
    for (int i = 0; i < f->trim.ncurves; i++) {
        const use *u = uses.empty() ? nullptr : &uses[static_cast<size_t>(i)];
        f->edge[i] = note_use(k, u ? &u->edge : nullptr, u && u->degenerate, face, i);
    }
}

bool normal_at(gp_Vec *out, const shape &s, const use &u, double x)
{
    gp_Pnt2d at = u.curve->Value(u.first + x * (u.last - u.first));
    gp_Pnt p;
    gp_Vec du, dv;
    s.surface->D1(at.X(), at.Y(), p, du, dv);
    *out = du.Crossed(dv);
    double length = out->Magnitude(), a = du.Magnitude(), b = dv.Magnitude();
    if (std::min(a, b) <= 1e-9 * std::max(a, b)) return false; // a pole: beyond it the cross product turns
    if (!(length > 1e-12 * a * b && length > 0.0)) return false;
    *out /= s.reversed ? -length : length;
    return true;
}

void set_angle(const converter *k, kn_cad_edge *e)
{
    enum { SAMPLES = 17 };
    if (e->face[1] < 0 || e->point) return;
    const shape &a = k->shapes[static_cast<size_t>(e->face[0])], &b = k->shapes[static_cast<size_t>(e->face[1])];
    if (a.uses.empty() || b.uses.empty()) return;
    for (int i = 0; i <= SAMPLES; i++) {
        gp_Vec n, m;
        double x = static_cast<double>(i) / SAMPLES;
        if (!normal_at(&n, a, a.uses[static_cast<size_t>(e->curve[0])], x) ||
            !normal_at(&m, b, b.uses[static_cast<size_t>(e->curve[1])], x))
            continue;
        e->angle = std::max(e->angle, std::atan2(n.Crossed(m).Magnitude(), n.Dot(m)));
    }
}

// ---- edges in space ----

int vertex_of(converter *k, const TopoDS_Vertex &v)
{
    size_t before = static_cast<size_t>(k->corners.Extent());
    size_t i = k->first_vertex + static_cast<size_t>(k->corners.Add(v.Oriented(TopAbs_FORWARD))) - 1;
    if (static_cast<size_t>(k->corners.Extent()) > before) {
        gp_Pnt p = BRep_Tool::Pnt(v);
        kn_cad_vertex out;
        for (int c = 0; c < 3; c++) out.at[c] = p.Coord(c + 1);
        k->vertices.push_back(out);
    }
    return static_cast<int>(i);
}

void set_line(kn_ctx *ctx, kn_spline *out, const section &s)
{
    int count = static_cast<int>(s.poles.size()), comps = s.rational ? 4 : 3;
    size_t n = s.poles.size();
    const double *knots = s.knots.data();
    std::vector<double> coef(static_cast<size_t>(comps) * n);
    if (s.knots.size() != n + static_cast<size_t>(s.degree) + 1)
        throw Standard_Failure("knots and poles of a curve do not agree");
    for (size_t i = 0; i < n; i++) {
        const double x[4] = {s.poles[i].x, s.poles[i].y, s.poles[i].z, s.poles[i].w};
        for (int c = 0; c < comps; c++) coef[static_cast<size_t>(c) * n + i] = x[c];
    }
    check(kn_spline_init(ctx, out, 1, comps, s.rational, &s.degree, &count, &knots, coef.data()));
    check(kn_spline_check(ctx, out));
}

// Of an edge that has a curve, ends and no more than two faces.
line line_of(converter *k, kn_cad_edge *e, const TopoDS_Edge &edge)
{
    line out;
    TopoDS_Vertex ends[2];
    Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, out.first, out.last);
    TopExp::Vertices(edge, ends[0], ends[1]);
    if (e->point || curve.IsNull() || ends[0].IsNull() || ends[1].IsNull() || !(out.first < out.last)) return out;
    out.curve = section_of(curve, out.first, out.last);
    set_line(k->ctx, &e->line, out.curve);
    e->error = std::max(BRep_Tool::Tolerance(edge), out.curve.error);
    for (int i = 0; i < 2; i++) {
        const pole &p = i == 0 ? out.curve.poles.front() : out.curve.poles.back();
        e->vertex[i] = vertex_of(k, ends[i]);
        const double *v = k->vertices[static_cast<size_t>(e->vertex[i])].at;
        e->error = std::max(e->error, std::hypot(p.x / p.w - v[0], p.y / p.w - v[1], p.z / p.w - v[2]));
    }
    out.there = true;
    return out;
}

// How far the edge's curve is from the face at the same time, mm.
double apart(kn_ctx *ctx, const kn_cad_face &f, const kn_spline &plane, const kn_spline &space)
{
    enum { PLACES = 5, MOST = 256 };
    double lo[2], hi[2], worst = 0.0;
    for (int d = 0; d < 2; d++) kn_spline_domain(&f.surface, d, &lo[d], &hi[d]);
    double from = plane.knots[0][0], to = plane.knots[0][plane.count[0] + plane.degree[0]];
    int n = std::min(PLACES * kn_spline_spans(&plane, 0) + 8, static_cast<int>(MOST));
    for (int i = 0; i <= n; i++) {
        double x = i == n ? to : from + (to - from) * i / n, at[2], p[3], q[3];
        check(kn_spline_eval(ctx, at, &plane, &x));
        for (int d = 0; d < 2; d++) at[d] = std::min(std::max(lo[d] + at[d] * (hi[d] - lo[d]), lo[d]), hi[d]);
        check(kn_spline_eval(ctx, p, &f.surface, at));
        check(kn_spline_eval(ctx, q, &space, &x));
        worst = std::max(worst, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
    }
    return worst;
}

// The use of an edge by curve i of a face, at the times of the edge's curve. False: it cannot be told.
bool set_plane(converter *k, kn_cad_face *f, const shape &s, int i, const line &l)
{
    kn_cad_edge *e = &k->edges[static_cast<size_t>(f->edge[i])];
    const kn_spline &curve = f->trim.curves[i];
    const use &u = s.uses[static_cast<size_t>(i)];
    outline o = paced_outline(u, s.square, l.curve, l.first, l.last, trim_tolerance);
    bool against = u.reversed != s.reversed;
    int n = curve.count[0];
    for (double &x : o.x) x = s.reversed ? 1.0 - x : x;
    for (int d = 0; d < 2; d++) {
        std::vector<double> &x = d == 0 ? o.x : o.y;
        const double *to = curve.coef + d * n;
        if (std::all_of(to, to + n, [&](double v) { return v == to[0]; })) std::fill(x.begin(), x.end(), to[0]);
        x.front() = to[against ? n - 1 : 0], x.back() = to[against ? 0 : n - 1];
        for (double v : x)
            if (!(v >= -1.0 && v <= 2.0)) return false;
    }
    set_curve(k->ctx, &f->use[i].plane, o);
    f->use[i].against = against;
    check(kn_spline_check(k->ctx, &f->use[i].plane));
    double off = apart(k->ctx, *f, f->use[i].plane, e->line);
    e->error = std::max(e->error, off);
    return off <= std::max(0.01, 4 * BRep_Tool::Tolerance(u.edge));
}

// Curves in space of the body's edges, and where its faces have them. An edge that is far from one of its faces has none.
void set_lines(converter *k)
{
    std::vector<line> lines(k->edges.size() - k->first_edge);
    auto guarded = [&](auto work) {
        try {
            return work();
        } catch (const Standard_Failure &) {
            return false;
        } catch (const failed &failure) {
            if (failure.status == KN_ENOMEM) throw;
            kn_ctx_clear_error(k->ctx);
            return false;
        }
    };
    for (size_t i = 0; i < lines.size(); i++)
        guarded([&] {
            lines[i] = line_of(k, &k->edges[k->first_edge + i], TopoDS::Edge(k->known(static_cast<int>(i) + 1)));
            return true;
        });
    for (size_t at = k->first_face; at < static_cast<size_t>(k->cad->nfaces); at++) {
        kn_cad_face *f = &k->cad->faces[at];
        const shape &s = k->shapes[at];
        if (s.uses.empty()) continue;
        f->use = array<kn_cad_use>(k->ctx, static_cast<size_t>(f->trim.ncurves));
        for (int i = 0; i < f->trim.ncurves; i++) {
            line &l = lines[static_cast<size_t>(f->edge[i]) - k->first_edge];
            if (l.there && !guarded([&] { return set_plane(k, f, s, i, l); })) l.there = false;
        }
    }
    for (size_t at = k->first_face; at < static_cast<size_t>(k->cad->nfaces); at++) {
        kn_cad_face *f = &k->cad->faces[at];
        for (int i = 0; f->use && i < f->trim.ncurves; i++)
            if (!lines[static_cast<size_t>(f->edge[i]) - k->first_edge].there)
                kn_spline_clear(k->ctx, &f->use[i].plane), f->use[i].against = false;
    }
    for (size_t i = 0; i < lines.size(); i++)
        if (!lines[i].there) kn_spline_clear(k->ctx, &k->edges[k->first_edge + i].line);
}

// Its faces are those from first_face on.
void end_body(converter *k, int body, bool whole)
{
    for (int i = static_cast<int>(k->first_face); i < k->cad->nfaces; i++) note_edges(k, i);
    set_lines(k);
    bool closed = whole;
    for (size_t i = k->first_edge; i < k->edges.size(); i++)
        closed = closed && (k->edges[i].point || (k->edges[i].face[1] >= 0 && !k->edges[i].more));
    kn_cad_body *out = &k->cad->bodies[body];
    const kn_occt::body &from = k->d->bodies[static_cast<size_t>(body)];
    set_name(out->name, from.name);
    out->solid = closed && from.shape.ShapeType() == TopAbs_SOLID;
    out->instances = from.instances;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) out->place[4 * i + j] = from.place.Value(i + 1, j + 1);
    k->cad->nbodies++;
    for (int i = 1; i <= k->known.Extent(); i++) k->d->edges.push_back(TopoDS::Edge(k->known(i)));
    k->known.Clear(), k->corners.Clear();
    k->first_vertex = k->vertices.size();
    k->first_edge = k->edges.size();
    k->first_face = static_cast<size_t>(k->cad->nfaces);
}

} // namespace

void model_of(kn_ctx *ctx, kn_cad *out, document *d, const char *path)
{
    converter k = {};
    k.ctx = ctx, k.cad = out, k.d = d;
    out->faces = array<kn_cad_face>(ctx, d->faces.size());
    out->bodies = array<kn_cad_body>(ctx, d->bodies.size());
    std::vector<face> kept;
    for (size_t b = 0, f = 0; b < d->bodies.size(); b++) {
        int before = k.dropped;
        for (; f < d->faces.size() && d->faces[f].body == static_cast<int>(b); f++)
            if (try_face(&k, d->faces[f])) kept.push_back(d->faces[f]);
        end_body(&k, static_cast<int>(b), k.dropped == before);
        check(kn_progress(ctx, "read", static_cast<double>(b + 1) / static_cast<double>(d->bodies.size())));
    }
    out->edges = array<kn_cad_edge>(ctx, k.edges.size());
    out->nedges = static_cast<int>(k.edges.size());
    std::copy(k.edges.begin(), k.edges.end(), out->edges);
    k.edges.clear();
    out->vertices = array<kn_cad_vertex>(ctx, k.vertices.size());
    out->nvertices = static_cast<int>(k.vertices.size());
    std::copy(k.vertices.begin(), k.vertices.end(), out->vertices);
    for (int i = 0; i < out->nedges; i++) set_angle(&k, &out->edges[i]);
    size_t all = d->faces.size() + static_cast<size_t>(d->unread);
    d->faces.swap(kept);
    if (out->nfaces == 0)
        check(kn_fail(ctx, KN_EPARSE, "%s: no face of %zu can be read: %s", path, all, k.why.c_str()));
    if (d->unread > 0)
        kn_log(ctx, KN_LOG_WARNING, "%s: %d of %zu faces are left out: OCCT makes nothing of them, the first is %s",
               path, d->unread, all, d->first_unread.c_str());
    if (k.dropped > 0)
        kn_log(ctx, KN_LOG_WARNING, "%s: %d of %zu faces are left out: %s", path, k.dropped, all, k.why.c_str());
}

} // namespace kn_occt
