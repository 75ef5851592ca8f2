#include "clients/formats/yaml_node.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scene_shapes.h"

namespace cwm::formats {

YamlNode YamlNode::operator[](const char* key) const {
  return {is_map() ? yaml[key] : YAML::Node(YAML::NodeType::Undefined),
          absl::StrCat(path, ".", key)};
}

YamlNode YamlNode::operator[](std::size_t index) const {
  return {yaml[index], absl::StrCat(path, "[", index, "]")};
}

absl::Status FieldReader::Error(const YamlNode& node, const std::string& rule) const {
  return FileError(file_, {.field = node.path.substr(node.path.find('.') + 1),
                           .value = node.is_scalar() ? node.yaml.Scalar() : "",
                           .rule = rule});
}

absl::Status FieldReader::CheckList(const YamlNode& node) const {
  return node.present() && !node.is_list() ? Error(node, "must be a list") : absl::OkStatus();
}

absl::StatusOr<std::string> FieldReader::Scalar(const YamlNode& node) const {
  if (!node.is_scalar()) return "";
  const std::string& text = node.yaml.Scalar();
  const std::size_t bytes = std::max<std::size_t>(1, text.size());
  if (bytes > left_) return Error(node, "must not be repeated by aliases so many times");
  left_ -= bytes;
  return text;
}

absl::StatusOr<std::string> FieldReader::Name(const YamlNode& node) const {
  auto name = Scalar(node);
  if (name.ok() && name->empty()) return Error(node, "must be a name");
  return name;
}

absl::StatusOr<std::vector<std::string>> FieldReader::Names(const YamlNode& node) const {
  if (absl::Status status = CheckList(node); !status.ok()) return status;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < node.size(); ++i) {
    auto name = Name(node[i]);
    if (!name.ok()) return name.status();
    names.push_back(*std::move(name));
  }
  return names;
}

absl::StatusOr<bool> FieldReader::Bool(const YamlNode& node) const {
  const auto word = Scalar(node);
  if (!word.ok()) return word.status();
  if (*word == "0" || *word == "1") return *word == "1";
  bool value = false;
  if (node.is_scalar() && YAML::convert<bool>::decode(node.yaml, value)) return value;
  return Error(node, "must be true or false");
}

absl::StatusOr<double> FieldReader::Number(const YamlNode& node) const {
  const auto word = Scalar(node);
  if (!word.ok()) return word.status();
  double value = 0;
  const auto fault = ParseSceneNumber(*word, value);
  if (fault) return Error(node, *fault);
  return value;
}

absl::StatusOr<std::vector<double>> FieldReader::Numbers(const YamlNode& node,
                                                         std::size_t count) const {
  if (!node.is_list() || node.size() != count) {
    return Error(node,
                 absl::StrCat("must be a list of ", count, count == 1 ? " number" : " numbers"));
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = Number(node[i]);
    if (!value.ok()) return value.status();
    values.push_back(*value);
  }
  return values;
}

absl::StatusOr<std::vector<double>> FieldReader::Vector(
    const YamlNode& node, const std::vector<const char*>& names) const {
  if (!node.is_map()) return Numbers(node, names.size());
  std::vector<double> values;
  for (const char* name : names) {
    const auto value = Number(node[name]);
    if (!value.ok()) return value.status();
    values.push_back(*value);
  }
  return values;
}

absl::StatusOr<ScenePose> FieldReader::Pose(const YamlNode& node) const {
  return PoseOf(node["position"], node["orientation"]);
}

absl::StatusOr<ScenePose> FieldReader::Transform(const YamlNode& node) const {
  return PoseOf(node["translation"], node["rotation"]);
}

absl::StatusOr<ScenePose> FieldReader::PoseOf(const YamlNode& position,
                                              const YamlNode& orientation) const {
  const auto p = Vector(position, {"x", "y", "z"});
  if (!p.ok()) return p.status();
  const auto q = Vector(orientation, {"x", "y", "z", "w"});
  if (!q.ok()) return q.status();
  ScenePose pose;
  std::copy(p->begin(), p->end(), pose.position_m.begin());
  std::copy(q->begin(), q->end(), pose.orientation_xyzw.begin());
  if (const auto fault = NormalizeQuaternion(pose.orientation_xyzw))
    return Error(orientation, *fault);
  return pose;
}

}  // namespace cwm::formats
