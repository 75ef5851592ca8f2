#include "clients/simulator/yaml_node.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"

namespace cwm::simulator {
namespace {

YAML::Node UndefinedNode() { return YAML::Node(YAML::NodeType::Undefined); }

std::string JoinKeys(std::initializer_list<std::string_view> names) {
  std::string list;
  for (const std::string_view name : names) {
    if (!list.empty()) list += ", ";
    list += name;
  }
  return list;
}

int LineOf(const YAML::Node& node, int around) {
  if (!node.IsDefined() || node.Mark().is_null()) return around;
  return node.Mark().line + 1;
}

}  // namespace

YamlNode::YamlNode(const YAML::Node& node, std::string file)
    : YamlNode(node, std::move(file), "", LineOf(node, 1)) {}

YamlNode::YamlNode(const YAML::Node& node, std::string file, std::string path, int line)
    : node_(node), file_(std::move(file)), path_(std::move(path)), line_(line) {}

absl::Status YamlNode::Error(std::string_view rule) const {
  const bool is_scalar = node_.IsDefined() && node_.IsScalar();
  return formats::FileError(absl::StrCat(file_, ":", line_),
                            {.field = path_.empty() ? "the document" : path_,
                             .value = is_scalar ? node_.Scalar() : "",
                             .rule = std::string(rule)});
}

bool YamlNode::Has(std::string_view key) const {
  return is_map() && node_[std::string(key)].IsDefined();
}

YamlNode YamlNode::operator[](std::string_view key) const {
  const std::string name(key);
  const YAML::Node found = is_map() ? node_[name] : UndefinedNode();
  const int line = LineOf(found, line_);
  return {found, file_, path_.empty() ? name : absl::StrCat(path_, ".", name), line};
}

YamlNode YamlNode::operator[](std::size_t index) const {
  const YAML::Node found = node_[index];
  const int line = LineOf(found, line_);
  return {found, file_, absl::StrCat(path_, "[", index, "]"), line};
}

absl::Status YamlNode::CheckKeys(std::initializer_list<std::string_view> allowed) const {
  const std::string names = allowed.size() == 0 ? "none" : JoinKeys(allowed);
  if (!is_map()) return Error(absl::StrCat("must be a map; known keys are ", names));
  std::set<std::string> seen;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? formats::Printable(entry.first.Scalar()) : "?";
    const YamlNode node(UndefinedNode(), file_, path_.empty() ? key : absl::StrCat(path_, ".", key),
                        LineOf(entry.first, line_));
    const bool known = std::find(allowed.begin(), allowed.end(), key) != allowed.end();
    if (!known) return node.Error(absl::StrCat("is no known key; known are ", names));
    if (!seen.insert(key).second) return node.Error("stands here twice");
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> YamlNode::ReadText() const {
  if (!present()) return Error("is missing");
  if (!node_.IsScalar() || node_.Scalar().empty()) return Error("must be a text");
  return node_.Scalar();
}

absl::StatusOr<bool> YamlNode::ReadFlag() const {
  if (node_.IsDefined() && node_.IsScalar()) {
    if (node_.Scalar() == "true") return true;
    if (node_.Scalar() == "false") return false;
  }
  return Error("must be true or false");
}

absl::StatusOr<double> YamlNode::ReadNumber() const {
  if (!present()) return Error("is missing");
  char bytes[sizeof(double)];
  const bool is_number = node_.IsScalar() &&
                         formats::ParseScalar(node_.Scalar(), formats::Scalar::kF64, bytes) &&
                         std::isfinite(formats::ToDouble(bytes, formats::Scalar::kF64));
  if (!is_number) return Error("must be a finite number");
  return formats::ToDouble(bytes, formats::Scalar::kF64);
}

absl::StatusOr<int> YamlNode::ReadInteger(int min, int max) const {
  int value = 0;
  const bool good = node_.IsDefined() && node_.IsScalar() &&
                    absl::SimpleAtoi(node_.Scalar(), &value) && value >= min && value <= max;
  if (!good) {
    return Error(absl::StrCat(present() ? "" : "is missing, ", "must be a whole number from ", min,
                              " to ", max));
  }
  return value;
}

absl::StatusOr<std::vector<double>> YamlNode::ReadNumbers(std::size_t count) const {
  if (!present()) return Error("is missing");
  if (!is_list() || size() != count) {
    return Error(absl::StrCat("must be a list of ", count, " numbers"));
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = (*this)[i].ReadNumber();
    if (!value.ok()) return value.status();
    values.push_back(*value);
  }
  return values;
}

}  // namespace cwm::simulator
