// Places in a YAML document, and what planning scenes have there. Errors name
// the file, the path, the value and the rule.
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/formats/scene_pose.h"

namespace cwm::formats {

// The node and how one got there. Asking an absent node for its type would throw, so the questions
// are asked here.
struct Place {
  YAML::Node node;
  std::string path;

  Place operator[](const char* key) const;
  Place operator[](std::size_t index) const;
  bool present() const { return node.IsDefined() && !node.IsNull(); }
  bool is_map() const { return node.IsDefined() && node.IsMap(); }
  bool is_list() const { return node.IsDefined() && node.IsSequence(); }
  bool is_scalar() const { return node.IsDefined() && node.IsScalar(); }
  // Elements of a list; 0 for anything else.
  std::size_t size() const { return is_list() ? node.size() : 0; }
};

// Reads fields of one file.
class FieldReader {
 public:
  // A file of so many bytes has fewer in what it says, even where an escape of two bytes stands for
  // three; only aliases could repeat that beyond all memory.
  FieldReader(std::string file, std::size_t bytes) : file_(std::move(file)), left_(2 * bytes) {}

  absl::Status Error(const Place& place, const std::string& rule) const;
  // A list, or nothing at all.
  absl::Status CheckList(const Place& place) const;

  // The text of a number, a name, a truth value; empty for what has none. Whatever is kept of a
  // file is read by it: it is what counts.
  absl::StatusOr<std::string> Scalar(const Place& place) const;
  absl::StatusOr<std::string> Name(const Place& place) const;
  // Empty where there is none.
  absl::StatusOr<std::vector<std::string>> Names(const Place& place) const;
  absl::StatusOr<bool> Bool(const Place& place) const;
  absl::StatusOr<double> Number(const Place& place) const;
  absl::StatusOr<std::vector<double>> Numbers(const Place& place, std::size_t count) const;
  // [x, y, z] or {x: .., y: .., z: ..}: both are written by tools around MoveIt.
  absl::StatusOr<std::vector<double>> Vector(const Place& place,
                                             const std::vector<const char*>& names) const;
  // {position, orientation} of a pose, {translation, rotation} of a transform.
  absl::StatusOr<ScenePose> Pose(const Place& place) const;
  absl::StatusOr<ScenePose> Transform(const Place& place) const;

 private:
  absl::StatusOr<ScenePose> PoseOf(const Place& position, const Place& orientation) const;

  const std::string file_;
  mutable std::size_t left_;  // bytes of scalars
};

}  // namespace cwm::formats
