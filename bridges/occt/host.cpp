// SPDX-License-Identifier: Apache-2.0
// kn_occt_write_host: a document goes out as STEP, less the faces that a texture replaces.
#include <algorithm>
#include <sstream>

#include <Interface_FloatWriter.hxx>
#include <Interface_Static.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPConstruct.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepWriter.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelSequence.hxx>
#include <TransferBRep_ShapeMapper.hxx>
#include <Transfer_FinderProcess.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferWriter.hxx>
#include <XSControl_WorkSession.hxx>

#include "bridges/occt/cad_model.hpp"
#include "bridges/occt/document.hpp"
#include "bridges/occt/guard.hpp"
#include "bridges/occt/host.h"
#include "bridges/occt/split.hpp"
#include "bridges/occt/step_text.hpp"
extern "C" {
#include "io/text_buffer.h"
#include "io/text_scan.h"
}

namespace kn_occt
{
namespace
{

struct split {
    int edge;
    std::vector<gp_Pnt> points;
    std::vector<part> parts;
};

struct request {
    std::vector<int> faces;
    double tolerance = 0;
    std::vector<split> splits;
};

// ---- the request ----

void expect(kn_scan *scan, const char *word)
{
    if (!kn_scan_word(scan) || std::string(scan->word, scan->length) != word)
        check(kn_scan_fail(scan, KN_EPARSE, "\"%s\" was expected", word));
}

int whole_number(kn_scan *scan, const char *what, int lo, int hi)
{
    int n = 0;
    check(kn_scan_int(scan, &n, what, lo, hi));
    return n;
}

void read_split(kn_scan *scan, split *s, int edges)
{
    s->edge = whole_number(scan, "edge", 0, edges - 1);
    int n = whole_number(scan, "number of parts", 1, 1 << 24);
    check(kn_scan_room(scan, 3.0 * (3.0 * n + 1.0), "points"));
    s->points.resize(3 * static_cast<size_t>(n) + 1);
    for (gp_Pnt &p : s->points)
        for (int c = 1; c <= 3; c++) {
            double x = 0;
            check(kn_scan_real(scan, &x, "coordinate"));
            p.SetCoord(c, x);
        }
}

void read_request(kn_ctx *ctx, request *out, const char *text, size_t bytes, int faces, int edges)
{
    kn_scan scan = kn_scan_start(ctx, "request", text, bytes);
    expect(&scan, "knurl-host");
    (void)whole_number(&scan, "version", 1, 1);
    expect(&scan, "faces");
    int n = whole_number(&scan, "number of faces", 0, faces);
    for (int i = 0; i < n; i++) out->faces.push_back(whole_number(&scan, "face", 0, faces - 1));
    expect(&scan, "tolerance");
    check(kn_scan_real(&scan, &out->tolerance, "tolerance"));
    while (kn_scan_word(&scan)) {
        std::string word(scan.word, scan.length);
        if (word == "end") return;
        if (word != "edge") check(kn_scan_fail_word(&scan, "request", "neither edge nor end"));
        out->splits.emplace_back();
        read_split(&scan, &out->splits.back(), edges);
    }
    check(kn_scan_fail(&scan, KN_EPARSE, "no end"));
}

// ---- the document as STEP ----

struct written {
    STEPCAFControl_Writer writer;
    Handle(StepData_StepModel) model;
    unsigned number_of(const TopoDS_Shape &shape)
    {
        Handle(Transfer_FinderProcess) process = writer.ChangeWriter().WS()->TransferWriter()->FinderProcess();
        Handle(StepRepr_RepresentationItem)
            item = STEPConstruct::FindEntity(process, shape.Located(TopLoc_Location()));
        return item.IsNull() ? 0u : static_cast<unsigned>(model->Number(item));
    }
};

// Settings of OCCT's writer, which are global: no parametric curves, which readers find again, and of which some would
// speak of surfaces that are gone.
void set_up(kn_ctx *ctx, const char *schema)
{
    static const char *const names[][2] = {{"AP203", "AP203"}, {"AP214", "AP214IS"}, {"AP242", "AP242DIS"}};
    const char *name = nullptr;
    for (const auto &n : names)
        if (std::string(schema) == n[0]) name = n[1];
    if (name == nullptr) check(kn_fail(ctx, KN_EDOMAIN, "schema '%s': AP203, AP214 or AP242", schema));
    STEPControl_Controller::Init();
    Interface_Static::SetIVal("write.surfacecurve.mode", 0);
    Interface_Static::SetCVal("write.step.unit", "MM");
    Interface_Static::SetIVal("write.step.assembly", 2);
    Interface_Static::SetCVal("write.step.schema", name);
}

void write_document(kn_ctx *ctx, written *out, const document &d, const char *path)
{
    out->writer.SetColorMode(Standard_True);
    out->writer.SetNameMode(Standard_True);
    if (!out->writer.Transfer(d.xcaf)) check(kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT cannot write it as STEP", path));
    out->model = out->writer.ChangeWriter().Model();
    if (out->model.IsNull()) check(kn_fail(ctx, KN_EUNDECIDED, "%s: OCCT wrote nothing", path));
}

std::string text_of(const written &w)
{
    StepData_StepWriter writer(w.model);
    writer.FloatWriter().SetFormat("%.16E"); // the same double; step_text makes it short. Zeros stay: OCCT's own way
    writer.FloatWriter().SetZeroSuppress(Standard_False); // to suppress them takes them out of exponents, too
    writer.SendModel(Handle(StepData_Protocol)::DownCast(w.model->Protocol()));
    std::ostringstream stream;
    writer.Print(stream);
    return stream.str();
}

// ---- what is found in it ----

struct shell {
    unsigned number;
    bool closed;
    std::vector<unsigned> faces; // all of them
};

class finder
{
  public:
    finder(kn_ctx *c, const step_text &t) : ctx(c), text(t)
    {
    }
    std::vector<shell> shells;

    // The place in `shells` of the one that has this face.
    size_t shell_of(unsigned face)
    {
        for (unsigned user : text.users(face)) {
            std::string name = text.name(user);
            if (name != "CLOSED_SHELL" && name != "OPEN_SHELL") continue;
            refuse_turned(user);
            for (size_t i = 0; i < shells.size(); i++)
                if (shells[i].number == user) return i;
            shells.push_back({user, name == "CLOSED_SHELL", text.references(user)});
            return shells.size() - 1;
        }
        check(kn_fail(ctx, KN_EUNDECIDED, "OCCT wrote the face #%u in no shell", face));
        return 0;
    }

    // The geometric context of what uses an entity.
    unsigned context_of(unsigned n, int depth = 0) const
    {
        for (unsigned user : text.users(n)) {
            std::string name = text.name(user);
            std::vector<unsigned> refs = text.references(user);
            if (name.find("REPRESENTATION") != std::string::npos && name.find("STYLE") == std::string::npos &&
                !refs.empty() && refs.back() != n)
                return refs.back();
            unsigned found = depth < 4 ? context_of(user, depth + 1) : 0;
            if (found != 0) return found;
        }
        return 0;
    }

  private:
    void refuse_turned(unsigned number) const
    {
        for (unsigned user : text.users(number))
            if (text.name(user) == "ORIENTED_CLOSED_SHELL")
                check(kn_fail(ctx, KN_EDOMAIN, "a textured face bounds a void of its body: it cannot be replaced"));
    }
    kn_ctx *ctx;
    const step_text &text;
};

void put_number(kn_text *out, unsigned n)
{
    kn_text_char(out, ' ');
    kn_text_integer(out, n);
}

void put_parts(kn_ctx *ctx, kn_text *out, written *w, const step_text &text, const split &s,
               std::vector<unsigned> *numbers)
{
    kn_text_put(out, "edge");
    put_number(out, static_cast<unsigned>(s.edge));
    put_number(out, static_cast<unsigned>(s.parts.size()));
    for (const part &p : s.parts) {
        unsigned edge = w->number_of(p.edge);
        std::vector<unsigned> refs = text.references(edge);
        if (text.name(edge) != "EDGE_CURVE" || refs.size() < 3)
            check(kn_fail(ctx, KN_EUNDECIDED, "OCCT wrote no curve of a part of edge %d", s.edge));
        numbers->push_back(edge);
        unsigned ends[2] = {refs[0], refs[1]};
        unsigned from = w->number_of(p.vertex[p.along ? 0 : 1]);
        if (from != 0 && from != ends[0])
            check(kn_fail(ctx, KN_EUNDECIDED, "OCCT wrote a part of edge %d the other way round", s.edge));
        if (!p.along) std::swap(ends[0], ends[1]);
        kn_text_put(out, "\n ");
        put_number(out, edge), put_number(out, ends[0]), put_number(out, ends[1]);
        kn_text_put(out, p.along ? " 1" : " 0");
    }
    kn_text_newline(out);
}

void answer(kn_ctx *ctx, kn_text *out, const request &r, written *w, const std::vector<TopoDS_Shape> &faces,
            double gap)
{
    step_text text(text_of(*w));
    finder find(ctx, text);
    std::vector<unsigned> replaced, hidden;
    std::vector<size_t> home;
    for (size_t i = 0; i < faces.size(); i++) {
        replaced.push_back(w->number_of(faces[i]));
        if (replaced.back() == 0) check(kn_fail(ctx, KN_EUNDECIDED, "OCCT did not write face %d", r.faces[i]));
        home.push_back(find.shell_of(replaced.back()));
    }
    for (const shell &s : find.shells) hidden.push_back(s.number);
    unsigned context = hidden.empty() ? text.first_with("GEOMETRIC_REPRESENTATION_CONTEXT(3)")
                                      : find.context_of(hidden[0]);
    kn_text_put(out, "knurl-host 1\ncontext");
    put_number(out, context);
    kn_text_put(out, "\ngap ");
    kn_text_plain_real(out, gap, 17);
    kn_text_newline(out);
    std::sort(replaced.begin(), replaced.end());
    for (const shell &s : find.shells) {
        std::vector<unsigned> stay;
        for (unsigned f : s.faces)
            if (!std::binary_search(replaced.begin(), replaced.end(), f)) stay.push_back(f);
        kn_text_put(out, "shell");
        put_number(out, s.number), put_number(out, s.closed), put_number(out, static_cast<unsigned>(stay.size()));
        for (unsigned f : stay) put_number(out, f);
        kn_text_newline(out);
    }
    for (size_t i = 0; i < faces.size(); i++) {
        kn_text_put(out, "face");
        put_number(out, static_cast<unsigned>(r.faces[i])), put_number(out, static_cast<unsigned>(home[i]));
        kn_text_newline(out);
    }
    std::vector<unsigned> stay = hidden; // edges between two replaced faces, too
    for (const split &s : r.splits) put_parts(ctx, out, w, text, s, &stay);
    text.remove(replaced, stay);
    std::string lines = text.lines(hidden);
    kn_text_put(out, "entities");
    put_number(out, text.numbers());
    kn_text_char(out, ' ');
    kn_text_integer(out, lines.size());
    kn_text_newline(out);
    kn_text_bytes(out, lines.data(), lines.size());
    if (out->failed) throw std::bad_alloc();
}

// Faces and edges get the numbers that a kn_cad gives them.
void number(kn_ctx *ctx, document *d, const char *path)
{
    struct model {
        kn_ctx *ctx;
        kn_cad cad;
        ~model()
        {
            kn_cad_clear(ctx, &cad);
        }
    } m = {ctx, {}};
    model_of(ctx, &m.cad, d, path);
}

void host(kn_ctx *ctx, kn_text *out, const char *path, const char *asked, size_t bytes, const char *schema)
{
    document d;
    read_document(ctx, &d, path);
    number(ctx, &d, path);
    request r;
    read_request(ctx, &r, asked, bytes, static_cast<int>(d.faces.size()), static_cast<int>(d.edges.size()));
    if (TDF_LabelSequence free; free.IsEmpty()) {
        Handle(XCAFDoc_ShapeTool) tool = XCAFDoc_DocumentTool::ShapeTool(d.xcaf->Main());
        tool->GetFreeShapes(free);
        for (const body &b : d.bodies) // a BREP file has no document
            if (free.IsEmpty()) tool->AddShape(b.shape, Standard_False);
    }
    splitter cutter;
    for (split &s : r.splits) cutter.cut(d.edges[static_cast<size_t>(s.edge)], s.points, r.tolerance, s.parts);
    cutter.apply_to(d.xcaf);

    set_up(ctx, schema);
    written w;
    write_document(ctx, &w, d, path);
    for (const face &f : d.faces) { // OCCT does not write names of faces
        unsigned n = f.name.empty() ? 0 : w.number_of(cutter.apply(f.shape));
        Handle(StepRepr_RepresentationItem) item;
        if (n != 0) item = Handle(StepRepr_RepresentationItem)::DownCast(w.model->Value(static_cast<int>(n)));
        if (!item.IsNull()) item->SetName(new TCollection_HAsciiString(f.name.c_str()));
    }
    std::vector<TopoDS_Shape> faces;
    for (int f : r.faces) faces.push_back(cutter.apply(d.faces[static_cast<size_t>(f)].shape));
    answer(ctx, out, r, &w, faces, cutter.gap());
}

} // namespace
} // namespace kn_occt

kn_status kn_occt_write_host(kn_ctx *ctx, char **text, size_t *bytes, const char *path, const char *request,
                             size_t request_bytes, const char *schema)
{
    kn_text out = {};
    out.ctx = ctx;
    kn_status status = kn_occt::guarded(ctx, path, [&] {
        try {
            kn_occt::host(ctx, &out, path, request, request_bytes, schema);
        } catch (const std::runtime_error &failure) {
            return kn_fail(ctx, KN_EDOMAIN, "%s: %s", path, failure.what());
        }
        return KN_OK;
    });
    if (status == KN_OK)
        *text = out.data, *bytes = out.bytes;
    else
        kn_text_clear(&out);
    return status;
}
