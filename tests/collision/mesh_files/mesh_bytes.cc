#include "tests/collision/mesh_files/mesh_bytes.h"

#include <array>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace cwm::collision::testing {
namespace {

template <class T>
void Append(T value, std::string& bytes) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

void AppendPoint(const Vector3& p, std::string& bytes) {
  for (const double c : p) Append(static_cast<float>(c), bytes);
}

std::string Words(const Vector3& p) {
  return absl::StrCat(absl::SixDigits(p.x()), " ", absl::SixDigits(p.y()), " ",
                      absl::SixDigits(p.z()));
}

}  // namespace

TriangleMesh BoxMesh(const Vector3& size_m) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(size_m.cwiseProduct(Vector3(i & 1, (i >> 1) & 1, (i >> 2) & 1)));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

std::string BinaryStl(const TriangleMesh& mesh) {
  std::string bytes(80, 'x');
  Append(static_cast<std::uint32_t>(mesh.triangles.size()), bytes);
  for (const auto& triangle : mesh.triangles) {
    AppendPoint(Vector3::Zero(), bytes);  // a normal of zero, as many tools write it
    for (const std::uint32_t v : triangle) AppendPoint(mesh.vertices[v], bytes);
    Append(std::uint16_t{0}, bytes);
  }
  return bytes;
}

std::string TextStl(const TriangleMesh& mesh) {
  std::string text = "solid part\n";
  for (const auto& triangle : mesh.triangles) {
    absl::StrAppend(&text, " facet normal 0 0 0\n  outer loop\n");
    for (const std::uint32_t v : triangle) {
      absl::StrAppend(&text, "   vertex ", Words(mesh.vertices[v]), "\n");
    }
    absl::StrAppend(&text, "  endloop\n endfacet\n");
  }
  return text + "endsolid part\n";
}

std::string Obj(const TriangleMesh& mesh) {
  std::string text = "mtllib part.mtl\no part\n";
  for (const Vector3& p : mesh.vertices) absl::StrAppend(&text, "v ", Words(p), "\n");
  for (const auto& t : mesh.triangles) {
    absl::StrAppend(&text, "f ", t[0] + 1, " ", t[1] + 1, " ", t[2] + 1, "\n");
  }
  return text;
}

std::string Collada(const TriangleMesh& mesh, const ColladaForm& form) {
  std::string positions, indices;
  for (const Vector3& p : mesh.vertices) absl::StrAppend(&positions, Words(p), " ");
  for (const auto& t : mesh.triangles) {
    absl::StrAppend(&indices, t[0], " ", t[1], " ", t[2], " ");
  }
  const std::string nodes =
      !form.scene_nodes.empty()
          ? form.scene_nodes
          : absl::StrCat("<node id=\"n\"><matrix>", form.matrix,
                         "</matrix><instance_geometry url=\"#part\"/></node>");
  return absl::StrCat(
      R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="u" meter=")",
      form.unit_m, R"("/><up_axis>)", form.up_axis, R"(</up_axis></asset>
<library_geometries><geometry id="part"><mesh>
<source id="p"><float_array id="pa" count=")",
      3 * mesh.vertices.size(), R"(">)", positions, R"(</float_array><technique_common>
<accessor source="#pa" count=")",
      mesh.vertices.size(),
      R"(" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count=")",
      mesh.triangles.size(), R"("><input semantic="VERTEX" source="#v" offset="0"/><p>)", indices,
      R"(</p></triangles></mesh></geometry></library_geometries>
<library_nodes>)",
      form.library_nodes, R"(</library_nodes>
<library_visual_scenes><visual_scene id="s">)",
      nodes, R"(</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
}

std::string GlbJson(const TriangleMesh& mesh, const std::string& nodes,
                    const std::string& scene_nodes) {
  const std::size_t points = 12 * mesh.vertices.size(), indices = 12 * mesh.triangles.size();
  return absl::StrCat(R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":)", scene_nodes,
                      R"(}],"nodes":)", nodes,
                      R"(,"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)",
                      R"("buffers":[{"byteLength":)", points + indices, R"(}],"bufferViews":[)",
                      R"({"buffer":0,"byteOffset":0,"byteLength":)", points, R"(},)",
                      R"({"buffer":0,"byteOffset":)", points, R"(,"byteLength":)", indices,
                      R"(}],"accessors":[)", R"({"bufferView":0,"componentType":5126,"count":)",
                      mesh.vertices.size(), R"(,"type":"VEC3","min":[0,0,0],"max":[9,9,9]},)",
                      R"({"bufferView":1,"componentType":5125,"count":)", 3 * mesh.triangles.size(),
                      R"(,"type":"SCALAR"}]})");
}

std::string GlbBinary(const TriangleMesh& mesh) {
  std::string binary;
  for (const Vector3& p : mesh.vertices) AppendPoint(p, binary);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) Append(v, binary);
  }
  return binary;
}

std::string Glb(const std::string& json, const std::string& binary) {
  std::string padded = json;
  padded.append((4 - padded.size() % 4) % 4, ' ');
  std::string bytes = "glTF";
  Append(std::uint32_t{2}, bytes);
  Append(static_cast<std::uint32_t>(28 + padded.size() + binary.size()), bytes);
  Append(static_cast<std::uint32_t>(padded.size()), bytes);
  Append(std::uint32_t{0x4E4F534A}, bytes);
  bytes += padded;
  Append(static_cast<std::uint32_t>(binary.size()), bytes);
  Append(std::uint32_t{0x004E4942}, bytes);
  return bytes + binary;
}

}  // namespace cwm::collision::testing
