#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include <yaml-cpp/yaml.h>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"
#include "clients/formats/scene_file.h"

namespace cwm::formats {
namespace {

// Scenes written with two or three decimals are off by up to half a percent; more is a mistake.
constexpr double kQuaternionTolerance = 0.01;

// A place in the document: the node and how one got there. Asking an absent node for its type would
// throw, so the questions are asked here.
struct Place {
  YAML::Node node;
  std::string path;

  Place operator[](const char* key) const {
    return {is_map() ? node[key] : YAML::Node(YAML::NodeType::Undefined), path + "." + key};
  }
  Place operator[](std::size_t index) const {
    return {node[index], absl::StrCat(path, "[", index, "]")};
  }
  bool present() const { return node.IsDefined() && !node.IsNull(); }
  bool is_map() const { return node.IsDefined() && node.IsMap(); }
  bool is_list() const { return node.IsDefined() && node.IsSequence(); }
  bool is_scalar() const { return node.IsDefined() && node.IsScalar(); }
  std::size_t size() const { return is_list() ? node.size() : 0; }
};

class SceneParser {
 public:
  explicit SceneParser(const std::string& file) : file_(file) {}

  absl::StatusOr<SceneFile> Parse(const YAML::Node& root) {
    const Place objects = Place{root, "scene"}["world"]["collision_objects"];
    if (!objects.present()) return Error(objects, "is missing");
    if (!objects.is_list()) return Error(objects, "must be a list");
    for (std::size_t i = 0; i < objects.size(); ++i) {
      if (absl::Status status = ReadObject(objects[i]); !status.ok()) return status;
    }
    return std::move(scene_);
  }

 private:
  absl::Status Error(const Place& place, const std::string& rule) const {
    return FileError(file_, {.field = place.path.substr(place.path.find('.') + 1),
                             .value = place.is_scalar() ? place.node.Scalar() : "",
                             .rule = rule});
  }

  absl::Status ReadObject(const Place& place) {
    SceneObject object;
    const Place id = place["id"];
    if (!id.is_scalar() || id.node.Scalar().empty()) {
      return Error(id, "must be a name");
    }
    object.id = id.node.Scalar();
    if (!ids_.insert(object.id).second) return Error(id, "must not appear twice");
    if (place["pose"].present()) {
      if (absl::Status status = ReadPose(place["pose"], object.pose); !status.ok()) return status;
    }
    for (const char* left_out : {"meshes", "planes"}) {
      if (place[left_out].size() > 0) {
        scene_.warnings.push_back(absl::StrCat(object.id, ": ", place[left_out].size(), " ",
                                               left_out, " left out, only primitives are read"));
      }
    }
    if (absl::Status status = ReadPrimitives(place, object); !status.ok()) return status;
    if (object.primitives.empty()) {
      scene_.warnings.push_back(absl::StrCat(object.id, ": left out, it has no primitives"));
    } else {
      scene_.objects.push_back(std::move(object));
    }
    return absl::OkStatus();
  }

  absl::Status ReadPrimitives(const Place& place, SceneObject& object) const {
    const Place shapes = place["primitives"];
    const Place poses = place["primitive_poses"];
    for (const Place& list : {shapes, poses}) {
      if (list.present() && !list.is_list()) return Error(list, "must be a list");
    }
    if (shapes.size() != poses.size()) {
      return Error(poses, absl::StrCat("must hold a pose for each of ", shapes.size(),
                                       " primitives, holds ", poses.size()));
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      ScenePrimitive primitive;
      if (absl::Status status = ReadShape(shapes[i], primitive); !status.ok()) return status;
      if (absl::Status status = ReadPose(poses[i], primitive.pose); !status.ok()) return status;
      object.primitives.push_back(primitive);
    }
    return absl::OkStatus();
  }

  absl::Status ReadShape(const Place& place, ScenePrimitive& primitive) const {
    using Dimensions = std::vector<double>;
    struct Kind {
      std::size_t count;
      std::function<decltype(primitive.shape)(const Dimensions&)> make;
    };
    static const std::map<std::string, Kind> kKinds = {
        {"box",
         {3,
          [](const Dimensions& d) {
            return SceneBox{{d[0], d[1], d[2]}};
          }}},
        {"sphere", {1, [](const Dimensions& d) { return SceneSphere{d[0]}; }}},
        {"cylinder",
         {2,
          [](const Dimensions& d) {
            return SceneCylinder{d[0], d[1]};
          }}},
        {"cone", {2, [](const Dimensions& d) {
                    return SceneCone{d[0], d[1]};
                  }}}};
    const Place type = place["type"];
    const auto kind = type.is_scalar() ? kKinds.find(type.node.Scalar()) : kKinds.end();
    if (kind == kKinds.end()) return Error(type, "must be box, sphere, cylinder or cone");
    const auto dimensions = ReadNumbers(place["dimensions"], kind->second.count);
    if (!dimensions.ok()) return dimensions.status();
    for (std::size_t i = 0; i < dimensions->size(); ++i) {
      if ((*dimensions)[i] <= 0) return Error(place["dimensions"][i], "must be positive");
    }
    primitive.shape = kind->second.make(*dimensions);
    return absl::OkStatus();
  }

  absl::Status ReadPose(const Place& place, ScenePose& pose) const {
    const auto position = ReadVector(place["position"], {"x", "y", "z"});
    if (!position.ok()) return position.status();
    const auto orientation = ReadVector(place["orientation"], {"x", "y", "z", "w"});
    if (!orientation.ok()) return orientation.status();
    std::copy(position->begin(), position->end(), pose.position_m.begin());
    double squared = 0;
    for (const double q : *orientation) squared += q * q;
    const double norm = std::sqrt(squared);
    if (!(std::abs(norm - 1) <= kQuaternionTolerance)) {
      return Error(place["orientation"],
                   absl::StrCat("has length ", FormatNumber(norm), ", must be within 1 % of 1"));
    }
    for (std::size_t i = 0; i < 4; ++i) pose.orientation_xyzw[i] = (*orientation)[i] / norm;
    return absl::OkStatus();
  }

  // [x, y, z] or {x: .., y: .., z: ..}: both are written by tools around MoveIt.
  absl::StatusOr<std::vector<double>> ReadVector(const Place& place,
                                                 const std::vector<const char*>& names) const {
    if (!place.is_map()) return ReadNumbers(place, names.size());
    std::vector<double> values;
    for (const char* name : names) {
      const auto value = ReadNumber(place[name]);
      if (!value.ok()) return value.status();
      values.push_back(*value);
    }
    return values;
  }

  absl::StatusOr<std::vector<double>> ReadNumbers(const Place& place, std::size_t count) const {
    if (!place.is_list() || place.size() != count) {
      return Error(place,
                   absl::StrCat("must be a list of ", count, count == 1 ? " number" : " numbers"));
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = ReadNumber(place[i]);
      if (!value.ok()) return value.status();
      values.push_back(*value);
    }
    return values;
  }

  absl::StatusOr<double> ReadNumber(const Place& place) const {
    char bytes[sizeof(double)];
    const bool number = place.is_scalar() && ParseScalar(place.node.Scalar(), Scalar::kF64, bytes);
    if (!number || !std::isfinite(ToDouble(bytes, Scalar::kF64))) {
      return Error(place, "must be a finite number");
    }
    return ToDouble(bytes, Scalar::kF64);
  }

  const std::string& file_;
  SceneFile scene_;
  std::set<std::string> ids_;
};

}  // namespace

absl::StatusOr<SceneFile> ParseScene(std::string_view yaml, const std::string& file) {
  try {  // yaml-cpp reports by exceptions; they end here
    return SceneParser(file).Parse(YAML::Load(std::string(yaml)));
  } catch (const YAML::Exception& error) {
    return FileError(file, {"YAML", "", error.what()});
  }
}

}  // namespace cwm::formats
