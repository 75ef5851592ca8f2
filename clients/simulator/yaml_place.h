// A place in a YAML document that knows how to complain: what strict readers are made of.
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

// All errors are INVALID_ARGUMENT "FILE:LINE: FIELD is VALUE, RULE"; the line is that of the place,
// or of the nearest one around it that is there.
class YamlPlace {
 public:
  // The root of a document.
  YamlPlace(const YAML::Node& node, std::string file);

  absl::Status Error(std::string_view rule) const;

  bool present() const { return node_.IsDefined() && !node_.IsNull(); }
  // Whether the map has the key, be it with nothing behind it.
  bool Has(std::string_view key) const;
  bool is_map() const { return node_.IsDefined() && node_.IsMap(); }
  bool is_list() const { return node_.IsDefined() && node_.IsSequence(); }
  std::size_t size() const { return is_list() ? node_.size() : 0; }
  const std::string& file() const { return file_; }

  // Not present where the map has no such key or this is no map.
  YamlPlace operator[](std::string_view key) const;
  YamlPlace operator[](std::size_t index) const;  // of a list

  // An error unless this is a map whose keys are all among the allowed, none of them twice.
  absl::Status CheckKeys(std::initializer_list<std::string_view> allowed) const;

  absl::StatusOr<std::string> ReadText() const;  // not empty
  absl::StatusOr<bool> ReadFlag() const;         // true or false
  absl::StatusOr<double> ReadNumber() const;     // finite
  absl::StatusOr<int> ReadInteger(int least, int most) const;
  absl::StatusOr<std::vector<double>> ReadNumbers(std::size_t count) const;

 private:
  YamlPlace(const YAML::Node& node, std::string file, std::string path, int line);

  YAML::Node node_;
  std::string file_;
  std::string path_;
  int line_ = 0;  // from 1
};

}  // namespace cwm::simulator
