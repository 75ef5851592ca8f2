#include "clients/formats/yaml_place.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scene_shapes.h"

namespace cwm::formats {

Place Place::operator[](const char* key) const {
  return {is_map() ? node[key] : YAML::Node(YAML::NodeType::Undefined),
          absl::StrCat(path, ".", key)};
}

Place Place::operator[](std::size_t index) const {
  return {node[index], absl::StrCat(path, "[", index, "]")};
}

absl::Status FieldReader::Error(const Place& place, const std::string& rule) const {
  return FileError(file_, {.field = place.path.substr(place.path.find('.') + 1),
                           .value = place.is_scalar() ? place.node.Scalar() : "",
                           .rule = rule});
}

absl::Status FieldReader::CheckList(const Place& place) const {
  return place.present() && !place.is_list() ? Error(place, "must be a list") : absl::OkStatus();
}

absl::StatusOr<std::string> FieldReader::Scalar(const Place& place) const {
  if (!place.is_scalar()) return "";
  const std::string& text = place.node.Scalar();
  const std::size_t bytes = std::max<std::size_t>(1, text.size());
  if (bytes > left_) return Error(place, "must not be repeated by aliases so many times");
  left_ -= bytes;
  return text;
}

absl::StatusOr<std::string> FieldReader::Name(const Place& place) const {
  auto name = Scalar(place);
  if (name.ok() && name->empty()) return Error(place, "must be a name");
  return name;
}

absl::StatusOr<std::vector<std::string>> FieldReader::Names(const Place& place) const {
  if (absl::Status status = CheckList(place); !status.ok()) return status;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < place.size(); ++i) {
    auto name = Name(place[i]);
    if (!name.ok()) return name.status();
    names.push_back(*std::move(name));
  }
  return names;
}

absl::StatusOr<bool> FieldReader::Bool(const Place& place) const {
  const auto word = Scalar(place);
  if (!word.ok()) return word.status();
  if (*word == "0" || *word == "1") return *word == "1";
  bool value = false;
  if (place.is_scalar() && YAML::convert<bool>::decode(place.node, value)) return value;
  return Error(place, "must be true or false");
}

absl::StatusOr<double> FieldReader::Number(const Place& place) const {
  const auto word = Scalar(place);
  if (!word.ok()) return word.status();
  double value = 0;
  const auto fault = NumberFault(*word, value);
  if (fault) return Error(place, *fault);
  return value;
}

absl::StatusOr<std::vector<double>> FieldReader::Numbers(const Place& place,
                                                         std::size_t count) const {
  if (!place.is_list() || place.size() != count) {
    return Error(place,
                 absl::StrCat("must be a list of ", count, count == 1 ? " number" : " numbers"));
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = Number(place[i]);
    if (!value.ok()) return value.status();
    values.push_back(*value);
  }
  return values;
}

absl::StatusOr<std::vector<double>> FieldReader::Vector(
    const Place& place, const std::vector<const char*>& names) const {
  if (!place.is_map()) return Numbers(place, names.size());
  std::vector<double> values;
  for (const char* name : names) {
    const auto value = Number(place[name]);
    if (!value.ok()) return value.status();
    values.push_back(*value);
  }
  return values;
}

absl::StatusOr<ScenePose> FieldReader::Pose(const Place& place) const {
  return PoseOf(place["position"], place["orientation"]);
}

absl::StatusOr<ScenePose> FieldReader::Transform(const Place& place) const {
  return PoseOf(place["translation"], place["rotation"]);
}

absl::StatusOr<ScenePose> FieldReader::PoseOf(const Place& position,
                                              const Place& orientation) const {
  const auto p = Vector(position, {"x", "y", "z"});
  if (!p.ok()) return p.status();
  const auto q = Vector(orientation, {"x", "y", "z", "w"});
  if (!q.ok()) return q.status();
  ScenePose pose;
  std::copy(p->begin(), p->end(), pose.position_m.begin());
  std::copy(q->begin(), q->end(), pose.orientation_xyzw.begin());
  if (const auto fault = Normalise(pose.orientation_xyzw)) return Error(orientation, *fault);
  return pose;
}

}  // namespace cwm::formats
