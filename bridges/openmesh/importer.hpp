// SPDX-License-Identifier: Apache-2.0
// Inside bridges/openmesh: what OpenMesh's readers tell besides positions and faces.
#ifndef BRIDGES_OPENMESH_IMPORTER_HPP
#define BRIDGES_OPENMESH_IMPORTER_HPP

#include <string>
#include <vector>

#include <OpenMesh/Core/IO/importer/BaseImporter.hh>

namespace kn_openmesh
{

// Takes no notice of edges, normals, colours, textures and states.
class deaf_importer : public OpenMesh::IO::BaseImporter
{
  public:
    size_t n_edges() const override
    {
        return 0;
    }
    OpenMesh::HalfedgeHandle add_edge(OpenMesh::VertexHandle, OpenMesh::VertexHandle) override
    {
        return OpenMesh::HalfedgeHandle();
    }
    OpenMesh::FaceHandle add_face(OpenMesh::HalfedgeHandle) override
    {
        return OpenMesh::FaceHandle();
    }
    void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle,
                            const std::vector<OpenMesh::Vec2f> &) override
    {
    }
    void add_face_texcoords(OpenMesh::FaceHandle, OpenMesh::VertexHandle,
                            const std::vector<OpenMesh::Vec3f> &) override
    {
    }
    void set_face_texindex(OpenMesh::FaceHandle, int) override
    {
    }
    void set_halfedge(OpenMesh::VertexHandle, OpenMesh::HalfedgeHandle) override
    {
    }
    void set_normal(OpenMesh::VertexHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_normal(OpenMesh::VertexHandle, const OpenMesh::Vec3d &) override
    {
    }
    void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec3uc &) override
    {
    }
    void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec4uc &) override
    {
    }
    void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_color(OpenMesh::VertexHandle, const OpenMesh::Vec4f &) override
    {
    }
    void set_texcoord(OpenMesh::VertexHandle, const OpenMesh::Vec2f &) override
    {
    }
    void set_texcoord(OpenMesh::HalfedgeHandle, const OpenMesh::Vec2f &) override
    {
    }
    void set_texcoord(OpenMesh::VertexHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_texcoord(OpenMesh::HalfedgeHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_status(OpenMesh::VertexHandle, const OpenMesh::Attributes::StatusInfo &) override
    {
    }
    void set_status(OpenMesh::HalfedgeHandle, const OpenMesh::Attributes::StatusInfo &) override
    {
    }
    void set_status(OpenMesh::EdgeHandle, const OpenMesh::Attributes::StatusInfo &) override
    {
    }
    void set_status(OpenMesh::FaceHandle, const OpenMesh::Attributes::StatusInfo &) override
    {
    }
    void set_next(OpenMesh::HalfedgeHandle, OpenMesh::HalfedgeHandle) override
    {
    }
    void set_face(OpenMesh::HalfedgeHandle, OpenMesh::FaceHandle) override
    {
    }
    void request_face_texcoords2D() override
    {
    }
    void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec3uc &) override
    {
    }
    void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec4uc &) override
    {
    }
    void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_color(OpenMesh::EdgeHandle, const OpenMesh::Vec4f &) override
    {
    }
    void set_normal(OpenMesh::FaceHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_normal(OpenMesh::FaceHandle, const OpenMesh::Vec3d &) override
    {
    }
    void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec3uc &) override
    {
    }
    void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec4uc &) override
    {
    }
    void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec3f &) override
    {
    }
    void set_color(OpenMesh::FaceHandle, const OpenMesh::Vec4f &) override
    {
    }
    void add_texture_information(int, std::string) override
    {
    }
};

} // namespace kn_openmesh

#endif
