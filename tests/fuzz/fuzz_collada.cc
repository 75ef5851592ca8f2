#include "tests/fuzz/mesh_check.h"

void cwm::fuzz::TestBytes(std::string_view bytes) {
  CheckMeshFile(bytes, "part.dae");
  const auto up = cwm::collision::UpAxisOf(bytes, "part.dae");
  Check(up.ok() || !up.status().message().empty(), "a refusal must have a message");
}
