// Places in a YAML document, and readers of the fields of planning scenes. Errors have the file,
// the path, the value and the rule.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/formats/scene_pose.h"

namespace cwm::formats {

// A node with its path. Asking an absent node for its type would throw, so use these functions.
struct Place {
  YAML::Node node;
  std::string path;

  Place operator[](const char* key) const;
  Place operator[](std::size_t index) const;
  bool present() const { return node.IsDefined() && !node.IsNull(); }
  bool is_map() const { return node.IsDefined() && node.IsMap(); }
  bool is_list() const { return node.IsDefined() && node.IsSequence(); }
  bool is_scalar() const { return node.IsDefined() && node.IsScalar(); }
  // Number of elements of a list; 0 for anything else.
  std::size_t size() const { return is_list() ? node.size() : 0; }
};

// Reads the fields of one file.
class FieldReader {
 public:
  // A file of `bytes` bytes has fewer bytes of scalars, even if escapes of two bytes stand for
  // three. Only aliases could expand to more, so the budget of twice the size bounds the memory.
  FieldReader(std::string file, std::size_t bytes) : file_(std::move(file)), left_(2 * bytes) {}

  absl::Status Error(const Place& place, const std::string& rule) const;
  // OK for a list, or if the field is absent.
  absl::Status CheckList(const Place& place) const;

  // The text of a number, a name or a boolean; empty for other nodes. All data kept from a file is
  // read by this function, which counts its bytes.
  absl::StatusOr<std::string> Scalar(const Place& place) const;
  absl::StatusOr<std::string> Name(const Place& place) const;
  // Empty if the field is absent.
  absl::StatusOr<std::vector<std::string>> Names(const Place& place) const;
  absl::StatusOr<bool> Bool(const Place& place) const;
  absl::StatusOr<double> Number(const Place& place) const;
  absl::StatusOr<std::vector<double>> Numbers(const Place& place, std::size_t count) const;
  // [x, y, z] or {x: .., y: .., z: ..}; tools around MoveIt write both.
  absl::StatusOr<std::vector<double>> Vector(const Place& place,
                                             const std::vector<const char*>& names) const;
  // {position, orientation} for Pose, {translation, rotation} for Transform.
  absl::StatusOr<ScenePose> Pose(const Place& place) const;
  absl::StatusOr<ScenePose> Transform(const Place& place) const;

 private:
  absl::StatusOr<ScenePose> PoseOf(const Place& position, const Place& orientation) const;

  const std::string file_;
  mutable std::size_t left_;  // remaining bytes of scalars
};

}  // namespace cwm::formats
