// Mesh files made in memory, for tests of readers.
#pragma once

#include <string>

#include "collision/geometry/triangle_mesh.h"

namespace cwm::collision::testing {

// A box in the first octant with 12 triangles, oriented outward.
TriangleMesh BoxMesh(const Vector3& size_m);

std::string BinaryStl(const TriangleMesh& mesh);
std::string TextStl(const TriangleMesh& mesh);
std::string Obj(const TriangleMesh& mesh);

struct ColladaForm {
  std::string unit_m = "1";
  std::string up_axis = "Z_UP";
  std::string matrix = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1";  // of the node of the mesh
  std::string scene_nodes = {};                            // replaces that node
  std::string library_nodes = {};
};
std::string Collada(const TriangleMesh& mesh, const ColladaForm& form = {});

// The JSON of a GLB with that mesh; `nodes` and `scene_nodes` are JSON lists.
std::string GlbJson(const TriangleMesh& mesh, const std::string& nodes = "[{\"mesh\":0}]",
                    const std::string& scene_nodes = "[0]");
std::string GlbBinary(const TriangleMesh& mesh);
std::string Glb(const std::string& json, const std::string& binary);
inline std::string Glb(const TriangleMesh& mesh) { return Glb(GlbJson(mesh), GlbBinary(mesh)); }

}  // namespace cwm::collision::testing
