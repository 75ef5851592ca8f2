// Nodes of a YAML document with their paths, and readers of the fields of planning scenes. Errors
// have the file, the path, the value and the rule.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/formats/scene_pose.h"

namespace cwm::formats {

// A node with its path. Asking an absent node for its type would throw, so use these functions.
struct YamlNode {
  YAML::Node yaml;
  std::string path;

  YamlNode operator[](const char* key) const;
  YamlNode operator[](std::size_t index) const;
  bool present() const { return yaml.IsDefined() && !yaml.IsNull(); }
  bool is_map() const { return yaml.IsDefined() && yaml.IsMap(); }
  bool is_list() const { return yaml.IsDefined() && yaml.IsSequence(); }
  bool is_scalar() const { return yaml.IsDefined() && yaml.IsScalar(); }
  // Number of elements of a list; 0 for anything else.
  std::size_t size() const { return is_list() ? yaml.size() : 0; }
};

// Reads the fields of one file.
class FieldReader {
 public:
  // A file of `bytes` bytes has fewer bytes of scalars, even if escapes of two bytes stand for
  // three. Only aliases could expand to more, so the budget of twice the size bounds the memory.
  FieldReader(std::string file, std::size_t bytes) : file_(std::move(file)), left_(2 * bytes) {}

  absl::Status Error(const YamlNode& node, const std::string& rule) const;
  // OK for a list, or if the field is absent.
  absl::Status CheckList(const YamlNode& node) const;

  // The text of a number, a name or a boolean; empty for other nodes. All data kept from a file is
  // read by this function, which counts its bytes.
  absl::StatusOr<std::string> Scalar(const YamlNode& node) const;
  absl::StatusOr<std::string> Name(const YamlNode& node) const;
  // Empty if the field is absent.
  absl::StatusOr<std::vector<std::string>> Names(const YamlNode& node) const;
  absl::StatusOr<bool> Bool(const YamlNode& node) const;
  absl::StatusOr<double> Number(const YamlNode& node) const;
  absl::StatusOr<std::vector<double>> Numbers(const YamlNode& node, std::size_t count) const;
  // [x, y, z] or {x: .., y: .., z: ..}; tools around MoveIt write both.
  absl::StatusOr<std::vector<double>> Vector(const YamlNode& node,
                                             const std::vector<const char*>& names) const;
  // {position, orientation} for Pose, {translation, rotation} for Transform.
  absl::StatusOr<ScenePose> Pose(const YamlNode& node) const;
  absl::StatusOr<ScenePose> Transform(const YamlNode& node) const;

 private:
  absl::StatusOr<ScenePose> PoseOf(const YamlNode& position, const YamlNode& orientation) const;

  const std::string file_;
  mutable std::size_t left_;  // remaining bytes of scalars
};

}  // namespace cwm::formats
