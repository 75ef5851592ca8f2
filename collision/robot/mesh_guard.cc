#include "collision/robot/mesh_guard.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "collision/robot/mesh_text.h"
#include "collision/robot/parse_number.h"
#include "collision/robot/scene_graph.h"
#include "collision/robot/xml_element.h"

namespace cwm::collision {
namespace {

// The nodes of a Collada document and what they use, by their names.
class ColladaNodes {
 public:
  absl::Status Check(const XmlElement& root) {
    Visit(root, Add());
    for (const auto& [node, url] : uses_) {
      const auto target = by_name_.find(url.starts_with('#') ? std::string(url, 1) : url);
      // assimp looks for ids and for names; a name that several nodes have may mean any of them.
      if (target == by_name_.end()) continue;
      for (const int used : target->second) children_[node].push_back(used);
    }
    return CheckSceneGraph(children_);
  }

 private:
  int Add() {
    children_.emplace_back();
    return static_cast<int>(children_.size()) - 1;
  }

  // Documents nest at most 100 deep (XmlDocument), and so does this.
  void Visit(const XmlElement& element, int node) {
    for (const XmlElement& child : element.Children()) {
      if (child.tag() == "node") {
        const int below = Add();
        children_[node].push_back(below);
        for (const char* attribute : {"id", "sid", "name"}) {
          if (child.Has(attribute)) by_name_[*child.Text(attribute)].push_back(below);
        }
        Visit(child, below);
      } else if (child.tag() == "instance_node" && child.Has("url")) {
        uses_.emplace_back(node, *child.Text("url"));
      } else if (child.tag() == "library_nodes" || child.tag() == "library_visual_scenes" ||
                 child.tag() == "visual_scene") {
        Visit(child, node);
      }
    }
  }

  std::vector<std::vector<int>> children_;
  std::vector<std::pair<int, std::string>> uses_;
  std::map<std::string, std::vector<int>> by_name_;
};

bool IsOneOf(std::string_view tag, std::initializer_list<std::string_view> tags) {
  return std::find(tags.begin(), tags.end(), tag) != tags.end();
}

enum class NumberKind { kIndex, kReal };

bool IsNumber(std::string_view word, NumberKind kind) {
  std::uint32_t index = 0;
  if (kind == NumberKind::kIndex) return absl::SimpleAtoi({word.data(), word.size()}, &index);
  const std::optional<double> real = ParseNumber(word);
  return real.has_value() && std::isfinite(*real);
}

// assimp never leaves a list of indices with a letter in it, and takes memory all the while.
absl::Status CheckNumbers(const XmlElement& element, NumberKind kind) {
  const absl::StatusOr<std::string_view> content = element.Content();
  if (!content.ok()) return content.status();
  if (content->find('\\') != std::string_view::npos) {  // MeshText would join lines there
    return element.Fault("must not hold a backslash");
  }
  MeshText lines(*content);
  while (lines.Next()) {
    for (std::size_t i = 0; i < lines.words(); ++i) {
      if (IsNumber(lines.word(i), kind)) continue;
      return element.Fault(absl::StrCat("holds ", Quoted(lines.word(i)), ", must hold ",
                                        kind == NumberKind::kIndex ? "indices" : "finite numbers"));
    }
  }
  return absl::OkStatus();
}

// What is counted takes a byte at least, and so does each place between things that are.
absl::Status CheckCounts(const XmlElement& element, std::size_t bytes) {
  constexpr std::uint32_t kMostInputs = 64;  // of one primitive: the format knows some twenty kinds
  for (const char* attribute : {"count", "stride", "offset", "set"}) {
    if (!element.Has(attribute)) continue;
    std::uint32_t value = 0;
    const bool is_count = absl::SimpleAtoi(*element.Text(attribute), &value);
    if (!is_count || value > bytes || (element.tag() == "input" && value >= kMostInputs)) {
      return element.FaultOf(attribute, "must be a count that the file has room for");
    }
  }
  return absl::OkStatus();
}

// Documents nest at most 100 deep (XmlDocument), and so does this.
absl::Status CheckContent(const XmlElement& element, std::size_t bytes) {
  if (absl::Status status = CheckCounts(element, bytes); !status.ok()) return status;
  if (IsOneOf(element.tag(), {"p", "h", "v", "vcount"})) {
    return CheckNumbers(element, NumberKind::kIndex);
  }
  if (IsOneOf(element.tag(), {"float_array", "matrix", "translate", "rotate", "scale", "lookat",
                              "skew", "bind_shape_matrix"})) {
    return CheckNumbers(element, NumberKind::kReal);
  }
  for (const XmlElement& child : element.Children()) {
    if (absl::Status status = CheckContent(child, bytes); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status GuardCollada(std::string_view bytes, const RobotLimits& limits) {
  const absl::StatusOr<XmlDocument> document =
      XmlDocument::Parse(bytes, "Collada", limits.max_collada_bytes);
  if (!document.ok()) return document.status();
  if (document->root().tag() != "COLLADA") {
    return absl::InvalidArgumentError("must have the root element COLLADA");
  }
  if (absl::Status status = CheckContent(document->root(), bytes.size()); !status.ok()) {
    return status;
  }
  return ColladaNodes().Check(document->root());
}

}  // namespace cwm::collision
