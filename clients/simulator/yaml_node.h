// A node of a YAML document with readers that report precise errors.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::simulator {

// All errors are INVALID_ARGUMENT "FILE:LINE: FIELD is VALUE, RULE"; the line is that of the node,
// or of the nearest enclosing node that exists.
class YamlNode {
 public:
  // The root of a document.
  YamlNode(const YAML::Node& node, std::string file);

  absl::Status Error(std::string_view rule) const;

  bool present() const { return node_.IsDefined() && !node_.IsNull(); }
  // True if the map has the key, even without a value.
  bool Has(std::string_view key) const;
  bool is_map() const { return node_.IsDefined() && node_.IsMap(); }
  bool is_list() const { return node_.IsDefined() && node_.IsSequence(); }
  std::size_t size() const { return is_list() ? node_.size() : 0; }
  const std::string& file() const { return file_; }

  // Not present if this is not a map or has no such key.
  YamlNode operator[](std::string_view key) const;
  YamlNode operator[](std::size_t index) const;  // element of a list

  // An error unless this is a map whose keys are all in `allowed`, each at most once.
  absl::Status CheckKeys(std::initializer_list<std::string_view> allowed) const;

  absl::StatusOr<std::string> ReadText() const;  // not empty
  absl::StatusOr<bool> ReadFlag() const;         // true or false
  absl::StatusOr<double> ReadNumber() const;     // finite
  absl::StatusOr<int> ReadInteger(int min, int max) const;
  absl::StatusOr<std::vector<double>> ReadNumbers(std::size_t count) const;

 private:
  YamlNode(const YAML::Node& node, std::string file, std::string path, int line);

  YAML::Node node_;
  std::string file_;
  std::string path_;
  int line_ = 0;  // counted from 1
};

}  // namespace cwm::simulator
