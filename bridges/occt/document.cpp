// SPDX-License-Identifier: Apache-2.0
// Files as documents of OCCT.
#include <cstdio>
#include <cstring>

#include <BRepClass3d.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <Interface_Check.hxx>
#include <Interface_InterfaceModel.hxx>
#include <Interface_Static.hxx>
#include <NCollection_DataMap.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <StepShape_FaceSurface.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDF_LabelIntegerMap.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_MapOfShape.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

#include "bridges/occt/document.hpp"
#include "bridges/occt/guard.hpp"

namespace kn_occt
{
namespace
{

struct paint {
    bool there = false;
    double rgb[3] = {0, 0, 0};
};
struct note { // what the file says of a shape inside a part
    std::string name;
    paint color;
};
typedef NCollection_DataMap<TopoDS_Shape, note, TopTools_ShapeMapHasher> notes;

struct part {
    TDF_Label label;
    TopoDS_Shape shape;
    int instances;
    gp_Trsf place;
    paint color; // of the part, or of its first instance
};

std::string name_of(const TDF_Label &label)
{
    Handle(TDataStd_Name) name;
    if (label.IsNull() || !label.FindAttribute(TDataStd_Name::GetID(), name)) return std::string();
    TCollection_AsciiString text(name->Get(), 0); // UTF-8
    return std::string(text.ToCString());
}

paint color_of(const Handle(XCAFDoc_ColorTool) & tool, const TDF_Label &label)
{
    paint p;
    Quantity_Color color;
    for (XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
        if (!p.there && tool->GetColor(label, type, color)) {
            p.there = true;
            p.rgb[0] = color.Red(), p.rgb[1] = color.Green(), p.rgb[2] = color.Blue();
        }
    return p;
}

class walk
{
  public:
    walk(const Handle(TDocStd_Document) & document)
        : shapes(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
          colors(XCAFDoc_DocumentTool::ColorTool(document->Main()))
    {
        TDF_LabelSequence free;
        shapes->GetFreeShapes(free);
        for (int i = 1; i <= free.Length(); i++) visit(free.Value(i), gp_Trsf(), paint(), 0);
    }
    std::vector<part> parts;
    Handle(XCAFDoc_ShapeTool) shapes;
    Handle(XCAFDoc_ColorTool) colors;

  private:
    void visit(const TDF_Label &label, const gp_Trsf &at, const paint &above, int depth)
    {
        enum { DEEPEST = 64, MOST_INSTANCES = 1 << 20 };
        if (depth > DEEPEST || ++visits > MOST_INSTANCES) throw Standard_Failure("an assembly too deep or too large");
        paint own = color_of(colors, label);
        if (!own.there) own = above;
        TDF_Label target;
        if (XCAFDoc_ShapeTool::GetReferredShape(label, target)) {
            visit(target, at * XCAFDoc_ShapeTool::GetLocation(label).Transformation(), own, depth + 1);
        } else if (XCAFDoc_ShapeTool::IsAssembly(label)) {
            TDF_LabelSequence members;
            XCAFDoc_ShapeTool::GetComponents(label, members);
            for (int i = 1; i <= members.Length(); i++) visit(members.Value(i), at, own, depth + 1);
        } else {
            add(label, at, own);
        }
    }

    void add(const TDF_Label &label, const gp_Trsf &at, const paint &color)
    {
        if (places.IsBound(label)) {
            parts[static_cast<size_t>(places.Find(label))].instances++;
            return;
        }
        TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(label);
        if (shape.IsNull()) return;
        places.Bind(label, static_cast<int>(parts.size()));
        parts.push_back(
            part{label, shape.Located(TopLoc_Location()), 1, at * shape.Location().Transformation(), color});
    }

    int visits = 0;
    TDF_LabelIntegerMap places; // in parts
};

// Of all shapes inside a part that the file names or colours.
void take_notes(notes *out, const walk &w, const part &p)
{
    TDF_LabelSequence labels;
    XCAFDoc_ShapeTool::GetSubShapes(p.label, labels);
    for (int i = 1; i <= labels.Length(); i++) {
        TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(labels.Value(i));
        if (shape.IsNull()) continue;
        note n;
        n.name = name_of(labels.Value(i));
        n.color = color_of(w.colors, labels.Value(i));
        out->Bind(shape, n);
    }
}

const note *note_of(const notes &all, const TopoDS_Shape &shape)
{
    return all.IsBound(shape) ? &all.Find(shape) : nullptr;
}

// The faces of one body. inherited: what it has that they do not say themselves.
void add_faces(document *out, TopTools_MapOfShape *seen, const TopoDS_Shape &shape, int shell, const notes &all,
               const notes &entities, const paint &inherited)
{
    for (TopExp_Explorer e(shape, TopAbs_FACE); e.More(); e.Next()) {
        TopoDS_Face f = TopoDS::Face(e.Current());
        if (f.Orientation() == TopAbs_INTERNAL || f.Orientation() == TopAbs_EXTERNAL || !seen->Add(f)) continue;
        face item = {f, std::string(), static_cast<int>(out->bodies.size()) - 1, shell, inherited.there, {0, 0, 0}};
        paint color = inherited;
        if (const note *n = note_of(entities, f.Located(TopLoc_Location()))) item.name = n->name;
        if (const note *n = note_of(all, f)) {
            if (!n->name.empty()) item.name = n->name;
            if (n->color.there) color = n->color;
        }
        item.colored = color.there;
        std::memcpy(item.color, color.rgb, sizeof item.color);
        out->faces.push_back(item);
    }
}

paint inherited_by(const notes &all, const TopoDS_Shape &shape, const paint &above)
{
    const note *n = note_of(all, shape);
    return n && n->color.there ? n->color : above;
}

// Of a solid with several; null: there is nothing to tell apart.
TopoDS_Shape outer_shell(const TopoDS_Shape &shape)
{
    TopExp_Explorer e(shape, TopAbs_SHELL);
    if (shape.ShapeType() != TopAbs_SOLID || !e.More()) return TopoDS_Shape();
    e.Next();
    return e.More() ? BRepClass3d::OuterShell(TopoDS::Solid(shape)) : TopoDS_Shape();
}

// Solids, then shells outside solids, then the faces outside shells as one body.
void add_bodies(document *out, const part &p, const std::string &name, const notes &all, const notes &entities)
{
    TopTools_MapOfShape seen;
    auto add = [&](const TopoDS_Shape &shape) {
        out->bodies.push_back(body{shape, name, p.instances, p.place});
        size_t before = out->faces.size();
        paint color = inherited_by(all, shape, p.color);
        TopoDS_Shape outer = outer_shell(shape);
        int shells = 0;
        for (TopExp_Explorer e(shape, TopAbs_SHELL); e.More(); e.Next())
            add_faces(out, &seen, e.Current(), outer.IsNull() || e.Current().IsSame(outer) ? 0 : ++shells, all,
                      entities, inherited_by(all, e.Current(), color));
        add_faces(out, &seen, shape, 0, all, entities, color);
        if (out->faces.size() == before) out->bodies.pop_back();
    };
    for (TopExp_Explorer e(p.shape, TopAbs_SOLID); e.More(); e.Next()) add(e.Current());
    for (TopExp_Explorer e(p.shape, TopAbs_SHELL, TopAbs_SOLID); e.More(); e.Next()) add(e.Current());
    TopoDS_Compound loose;
    BRep_Builder builder;
    builder.MakeCompound(loose);
    bool any = false;
    for (TopExp_Explorer e(p.shape, TopAbs_FACE, TopAbs_SHELL); e.More(); e.Next()) {
        builder.Add(loose, e.Current());
        any = true;
    }
    if (any) add(loose);
}

void add_parts(document *out, const notes &entities, bool together)
{
    walk w(out->xcaf);
    if (together) { // what an IGES file has outside of solids and shells is one body
        BRep_Builder builder;
        TopoDS_Compound loose;
        builder.MakeCompound(loose);
        notes all;
        for (const part &p : w.parts) {
            take_notes(&all, w, p);
            bool body = TopExp_Explorer(p.shape, TopAbs_SHELL).More();
            if (body) continue;
            for (TopExp_Explorer e(p.shape.Moved(TopLoc_Location(p.place)), TopAbs_FACE); e.More(); e.Next()) {
                note n;
                if (all.IsBound(e.Current())) n = all.Find(e.Current());
                if (n.name.empty()) n.name = name_of(p.label);
                if (!n.color.there) n.color = p.color;
                all.Bind(e.Current(), n);
                builder.Add(loose, e.Current());
            }
        }
        add_bodies(out, part{TDF_Label(), loose, 1, gp_Trsf(), paint()}, "", all, entities);
    }
    for (const part &p : w.parts) {
        if (together && !TopExp_Explorer(p.shape, TopAbs_SHELL).More()) continue;
        notes all;
        take_notes(&all, w, p);
        add_bodies(out, p, name_of(p.label), all, entities);
    }
}

// The names of face entities, which OCCT does not put into documents; and those that became no face.
void ask_entities(notes *names, document *out, const Handle(XSControl_WorkSession) & session)
{
    const Handle(Transfer_TransientProcess) &process = session->TransferReader()->TransientProcess();
    const Handle(Interface_InterfaceModel) &model = session->Model();
    for (int i = 1; i <= model->NbEntities(); i++) {
        Handle(StepShape_FaceSurface) entity = Handle(StepShape_FaceSurface)::DownCast(model->Value(i));
        if (entity.IsNull()) continue;
        TopExp_Explorer e(TransferBRep::ShapeResult(process, entity), TopAbs_FACE);
        if (!e.More() && out->unread++ == 0) out->first_unread = model->StringLabel(entity)->ToCString();
        note n;
        if (!entity->Name().IsNull()) n.name = entity->Name()->ToCString();
        for (; e.More(); e.Next()) names->Bind(e.Current().Located(TopLoc_Location()), n);
    }
}

// What OCCT noticed while it loaded the entities. It goes on, and may crash on what is missing.
void warn_of_faults(kn_ctx *ctx, const Handle(Interface_InterfaceModel) & model, const char *path)
{
    int faults = 0;
    std::string first;
    for (int i = 1; i <= model->NbEntities(); i++) {
        Handle(Interface_Check) found = model->Check(i, Standard_True);
        if (found.IsNull() || found->NbFails() == 0 || faults++ > 0) continue;
        Handle(Standard_Transient) entity = model->Value(i);
        first = std::string(model->StringLabel(entity)->ToCString()) + " (" +
                model->TypeName(entity, Standard_False) + "): " + found->CFail(1);
    }
    if (faults > 0)
        kn_log(ctx, KN_LOG_WARNING, "%s: OCCT finds faults in %d entities, the first is %s", path, faults,
               first.c_str());
}

enum format { UNKNOWN, STEP, IGES, BREP };

// The last section of IGES is one record, with a T in column 73 of its line; a file without lines ends with it.
bool has_last_record(const char *tail, bool all)
{
    const size_t n = std::strlen(tail);
    const char *line = all ? tail : std::strpbrk(tail, "\r\n");
    if (!line) return n >= 80 && tail[n - 8] == 'T';
    for (; *line; line += std::strcspn(line, "\r\n")) {
        line += std::strspn(line, "\r\n");
        if (std::strcspn(line, "\r\n") > 72 && line[72] == 'T') return true;
    }
    return false;
}

// By what is in it: the first bytes, and for IGES the S in column 73. STEP and IGES must end as they should: what is
// cut off would be read as far as it goes.
format look_at(kn_ctx *ctx, const char *path)
{
    char head[512] = "", tail[512] = "";
    std::FILE *file = std::fopen(path, "rb");
    if (!file) check(kn_fail(ctx, KN_EIO, "%s: cannot open", path));
    size_t n = std::fread(head, 1, sizeof head - 1, file), m = 0;
    std::fseek(file, 0, SEEK_END);
    long size = std::ftell(file);
    if (size >= 0 && std::fseek(file, size > 500 ? size - 500 : 0, SEEK_SET) == 0)
        m = std::fread(tail, 1, sizeof tail - 1, file);
    std::fclose(file);
    for (size_t i = 0; i < n; i++)
        if (head[i] == '\0') head[i] = ' ';
    for (size_t i = 0; i < m; i++)
        if (tail[i] == '\0') tail[i] = ' ';
    head[n] = tail[m] = '\0';
    if (std::strstr(head, "ISO-10303-21")) {
        if (!std::strstr(tail, "END-ISO-10303-21"))
            check(kn_fail(ctx, KN_EPARSE, "%s: the STEP file is cut off: END-ISO-10303-21 is missing at its end",
                          path));
        return STEP;
    }
    if (n >= 73 && head[72] == 'S' && !std::memchr(head, '\n', 72)) {
        if (!has_last_record(tail, size <= 500))
            check(kn_fail(ctx, KN_EPARSE, "%s: the IGES file is cut off: its last section (T) is missing", path));
        return IGES;
    }
    if (std::strstr(head, "CASCADE Topology") || std::strstr(head, "DBRep_DrawableShape")) return BREP;
    check(kn_fail(ctx, KN_EPARSE, "%s: neither STEP, IGES nor BREP by its first bytes", path));
    return UNKNOWN;
}

void read_step(kn_ctx *ctx, document *out, const char *path)
{
    STEPCAFControl_Reader reader;
    Interface_Static::SetCVal("xstep.cascade.unit", "MM"); // the reader made it known
    reader.SetColorMode(Standard_True);
    reader.SetNameMode(Standard_True);
    if (reader.ReadFile(path) != IFSelect_RetDone)
        check(kn_fail(ctx, KN_EPARSE, "%s: OCCT cannot read it as STEP", path));
    warn_of_faults(ctx, reader.Reader().WS()->Model(), path);
    if (!reader.Transfer(out->xcaf)) check(kn_fail(ctx, KN_EPARSE, "%s: OCCT finds no shape in it", path));
    notes names;
    ask_entities(&names, out, reader.Reader().WS());
    add_parts(out, names, false);
}

void read_iges(kn_ctx *ctx, document *out, const char *path)
{
    IGESCAFControl_Reader reader;
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    reader.SetColorMode(Standard_True);
    reader.SetNameMode(Standard_True);
    if (reader.ReadFile(path) != IFSelect_RetDone)
        check(kn_fail(ctx, KN_EPARSE, "%s: OCCT cannot read it as IGES", path));
    if (!reader.Transfer(out->xcaf)) check(kn_fail(ctx, KN_EPARSE, "%s: OCCT finds no shape in it", path));
    add_parts(out, notes(), true);
}

void read_brep(kn_ctx *ctx, document *out, const char *path)
{
    BRep_Builder builder;
    TopoDS_Shape shape;
    if (!BRepTools::Read(shape, path, builder) || shape.IsNull())
        check(kn_fail(ctx, KN_EPARSE, "%s: OCCT cannot read it as BREP", path));
    add_bodies(out, part{TDF_Label(), shape, 1, gp_Trsf(), paint()}, "", notes(), notes());
}

} // namespace

void read_document(kn_ctx *ctx, document *out, const char *path)
{
    format kind = look_at(ctx, path);
    XCAFDoc_ShapeTool::SetAutoNaming(Standard_False); // no names that are not in the file
    out->xcaf = new TDocStd_Document("BinXCAF");
    XCAFDoc_DocumentTool::Set(out->xcaf->Main());
    if (kind == STEP) read_step(ctx, out, path);
    if (kind == IGES) read_iges(ctx, out, path);
    if (kind == BREP) read_brep(ctx, out, path);
    if (out->faces.empty()) check(kn_fail(ctx, KN_EPARSE, "%s: no face in it that OCCT can read", path));
}

} // namespace kn_occt
