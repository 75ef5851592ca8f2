#include "tests/fuzz/mesh_check.h"

void cwm::fuzz::TestBytes(std::string_view bytes) { CheckMeshFile(bytes, "part.obj"); }
