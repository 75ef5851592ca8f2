#include "clients/formats/cloud_reader.h"
#include "clients/formats/ply.h"
#include "tests/fuzz/fuzz_target.h"

// Reads PCD, PLY, NPY and XYZ, which are told apart by their first bytes; a PLY also as a mesh.
void cwm::fuzz::TestBytes(std::string_view bytes) {
  const auto cloud = cwm::formats::ParseCloud(bytes, "cloud");
  if (cloud.ok()) {
    Check(cloud->size() >= 0, "a cloud must not have fewer points than none");
    for (const char* field : {"x", "y", "z"})
      Check(cloud->Find(field) != nullptr, "no coordinates");
  }
  const auto mesh = cwm::formats::ParsePlyMesh(bytes, "mesh");
  if (!mesh.ok()) return;
  for (const auto& triangle : mesh->triangles) {
    for (const std::uint32_t v : triangle) Check(v < mesh->vertices.size(), "no such vertex");
  }
}
