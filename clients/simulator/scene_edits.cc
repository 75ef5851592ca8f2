#include "clients/simulator/scene_edits.h"

#include <algorithm>
#include <cmath>

#include "absl/status/statusor.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"

namespace cwm::simulator {
namespace {

using perception::SimulatedObject;
using perception::SimulatedScene;

absl::StatusOr<std::vector<SimulatedObject>::iterator> Find(const std::string& name,
                                                            SimulatedScene& scene) {
  const auto found =
      std::find_if(scene.objects.begin(), scene.objects.end(),
                   [&](const SimulatedObject& object) { return object.name == name; });
  if (found != scene.objects.end()) return found;
  std::string names;
  for (const SimulatedObject& object : scene.objects) {
    absl::StrAppend(&names, names.empty() ? "" : ", ", object.name);
  }
  return absl::NotFoundError(absl::StrCat("object ", name, " is unknown; the scene has ", names));
}

absl::Status Move(const std::string& text, SimulatedScene& scene) {
  const std::vector<std::string> sides = absl::StrSplit(text, absl::MaxSplits('=', 1));
  const std::vector<std::string> words =
      sides.size() == 2 ? absl::StrSplit(sides[1], ',') : std::vector<std::string>();
  Vector3 by_m = Vector3::Zero();
  bool good = words.size() == 3;
  for (int axis = 0; good && axis < 3; ++axis) {
    good = absl::SimpleAtod(words[static_cast<std::size_t>(axis)], &by_m[axis]) &&
           std::isfinite(by_m[axis]);
  }
  if (!good) {
    return absl::InvalidArgumentError(
        absl::StrCat("--move: \"", text, "\" must be NAME=dx,dy,dz (m)"));
  }
  const auto object = Find(sides[0], scene);
  if (!object.ok()) return object.status();
  (*object)->X_WO.pretranslate(by_m);
  return absl::OkStatus();
}

}  // namespace

absl::Status ApplyEdits(const SceneEdits& edits, SimulatedScene& scene) {
  for (const std::string& move : edits.moves) {
    if (absl::Status status = Move(move, scene); !status.ok()) return status;
  }
  for (const std::string& name : edits.without) {
    const auto object = Find(name, scene);
    if (!object.ok()) return object.status();
    scene.objects.erase(*object);
  }
  return absl::OkStatus();
}

}  // namespace cwm::simulator
