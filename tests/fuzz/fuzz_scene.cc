#include "clients/formats/motion_request.h"
#include "clients/formats/scene_file.h"
#include "tests/fuzz/fuzz_target.h"

// Reads a planning scene in either format, and a motion request, which is YAML too.
void cwm::fuzz::TestBytes(std::string_view bytes) {
  const auto scene = cwm::formats::ParseScene(bytes, "scene");
  Check(scene.ok() || !scene.status().message().empty(), "a refusal must have a message");
  const auto request = cwm::formats::ParseMotionRequest(bytes, "request");
  Check(request.ok() || !request.status().message().empty(), "a refusal must have a message");
}
