#include "collision/geometry/triangle_mesh.h"
#include "collision/geometry/validation.h"
#include "proto/transfer/mesh_bytes.h"
#include "tests/fuzz/fuzz_target.h"

// Reads a blob as the server does: its columns, then whether they form a valid mesh.
void cwm::fuzz::TestBytes(std::string_view bytes) {
  const auto mesh = ReadMeshColumns<TriangleMesh>(bytes);
  if (!mesh.ok()) return;
  Check(EncodeMesh(*mesh) == bytes, "a mesh must travel back as it came");
  if (FindViolation(*mesh).has_value()) return;
  IsWatertight(*mesh);
  ConnectedComponents(*mesh);
}
