#include "collision/mesh_files/collada_geometry.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "collision/mesh_files/line_reader.h"
#include "collision/xml/parse_number.h"

namespace cwm::collision {
namespace {

constexpr std::uint32_t kMaxInputs = 64;  // chosen: the format defines some twenty kinds

std::optional<std::uint32_t> ParseIndex(std::string_view word) {
  std::uint32_t index = 0;
  if (!absl::SimpleAtoi({word.data(), word.size()}, &index)) return std::nullopt;
  return index;
}

std::optional<double> ParseFinite(std::string_view word) {
  const std::optional<double> number = ParseNumber(word);
  return number.has_value() && std::isfinite(*number) ? number : std::nullopt;
}

template <class T>
absl::StatusOr<std::vector<T>> ReadList(const XmlElement& element,
                                        std::optional<T> (*parse)(std::string_view),
                                        const char* rule) {
  const absl::StatusOr<std::string_view> content = element.Content();
  if (!content.ok()) return content.status();
  std::vector<T> list;
  LineReader lines(*content);
  while (lines.Next()) {
    for (std::size_t i = 0; i < lines.words(); ++i) {
      const std::optional<T> item = parse(lines.word(i));
      if (!item.has_value()) {
        return element.Fault(absl::StrCat("holds ", Quoted(lines.word(i)), ", ", rule));
      }
      list.push_back(*item);
    }
  }
  return list;
}

absl::StatusOr<std::vector<std::uint32_t>> ReadIndices(const XmlElement& element) {
  return ReadList<std::uint32_t>(element, ParseIndex, "must hold indices");
}

// The value of an attribute that is a count; `otherwise` if it is absent.
absl::StatusOr<std::uint32_t> CountOf(const XmlElement& element, const char* attribute,
                                      std::uint32_t otherwise) {
  if (!element.Has(attribute)) return otherwise;
  const std::optional<std::uint32_t> count = ParseIndex(*element.Text(attribute));
  if (!count.has_value()) return element.FaultOf(attribute, "must be a count");
  return *count;
}

class GeometryReader {
 public:
  GeometryReader(std::size_t max_triangles, PolygonTriangulator& triangulator)
      : max_triangles_(max_triangles), triangulator_(triangulator) {}

  absl::StatusOr<ColladaGeometry> Read(const XmlElement& geometry) {
    const absl::StatusOr<XmlElement> mesh = geometry.ExactlyOne("mesh");
    if (!mesh.ok()) return mesh.status();
    for (const XmlElement& child : mesh->Children()) {
      if (child.Has("id")) by_id_.emplace("#" + *child.Text("id"), child);
    }
    for (const XmlElement& child : mesh->Children()) {
      absl::Status status;
      if (child.tag() == "triangles" || child.tag() == "polylist" || child.tag() == "polygons") {
        status = AddPolygons(child);
      } else if (child.tag() == "tristrips" || child.tag() == "trifans") {
        status = child.Fault("is not understood, must be triangles, a polylist or polygons");
      }
      if (!status.ok()) return status;
    }
    return std::move(read_);
  }

 private:
  struct Inputs {
    std::uint32_t stride = 0;         // number of indices per corner
    std::uint32_t vertex_offset = 0;  // position of the vertex index among them
    const std::vector<Vector3>* positions = nullptr;
  };

  absl::StatusOr<XmlElement> Find(const XmlElement& element, const char* tag) const {
    const absl::StatusOr<std::string> url = element.Text("source");
    if (!url.ok()) return url.status();
    const auto found = by_id_.find(*url);
    if (found != by_id_.end() && found->second.tag() == tag) return found->second;
    return element.FaultOf("source", absl::StrCat("must be a <", tag, "> of the mesh"));
  }

  absl::StatusOr<Inputs> ReadInputs(const XmlElement& primitive) {
    Inputs inputs;
    std::optional<XmlElement> vertex;
    for (const XmlElement& input : primitive.Children("input")) {
      const absl::StatusOr<std::uint32_t> offset = CountOf(input, "offset", 0);
      if (!offset.ok()) return offset.status();
      if (*offset >= kMaxInputs) return input.FaultOf("offset", "must be below 64");
      inputs.stride = std::max(inputs.stride, *offset + 1);
      if (!input.Has("semantic") || *input.Text("semantic") != "VERTEX") continue;
      inputs.vertex_offset = *offset;
      vertex = input;
    }
    if (!vertex.has_value()) return primitive.Fault("must have an input VERTEX");
    const absl::StatusOr<XmlElement> vertices = Find(*vertex, "vertices");
    if (!vertices.ok()) return vertices.status();
    for (const XmlElement& input : vertices->Children("input")) {
      if (!input.Has("semantic") || *input.Text("semantic") != "POSITION") continue;
      const absl::StatusOr<XmlElement> source = Find(input, "source");
      if (!source.ok()) return source.status();
      // A source is read once, however many primitives use it.
      std::optional<std::vector<Vector3>>& positions = positions_[*input.Text("source")];
      if (!positions.has_value()) {
        absl::StatusOr<std::vector<Vector3>> read = ReadPositions(*source);
        if (!read.ok()) return read.status();
        positions = *std::move(read);
      }
      inputs.positions = &*positions;
      return inputs;
    }
    return vertices->Fault("must have an input POSITION");
  }

  static absl::StatusOr<std::vector<Vector3>> ReadPositions(const XmlElement& source) {
    const absl::StatusOr<XmlElement> array = source.ExactlyOne("float_array");
    if (!array.ok()) return array.status();
    const absl::StatusOr<std::vector<double>> numbers = ReadNumbers(*array);
    if (!numbers.ok()) return numbers.status();
    const absl::StatusOr<XmlElement> technique = source.ExactlyOne("technique_common");
    if (!technique.ok()) return technique.status();
    const absl::StatusOr<XmlElement> accessor = technique->ExactlyOne("accessor");
    if (!accessor.ok()) return accessor.status();
    const absl::StatusOr<std::uint32_t> count = CountOf(*accessor, "count", 0);
    if (!count.ok()) return count.status();
    const absl::StatusOr<std::uint32_t> stride = CountOf(*accessor, "stride", 1);
    if (!stride.ok()) return stride.status();
    const absl::StatusOr<std::uint32_t> offset = CountOf(*accessor, "offset", 0);
    if (!offset.ok()) return offset.status();
    if (*stride < 3) return accessor->FaultOf("stride", "must be at least 3");
    if (*offset + std::uint64_t{*count} * *stride > numbers->size()) {
      return accessor->FaultOf("count", absl::StrCat("must fit the ", numbers->size(), " numbers"));
    }
    std::vector<Vector3> positions;
    for (std::uint32_t i = 0; i < *count; ++i) {
      positions.emplace_back(numbers->data() + *offset + std::size_t{i} * *stride);
    }
    return positions;
  }

  absl::Status AddPolygons(const XmlElement& primitive) {
    const absl::StatusOr<Inputs> inputs = ReadInputs(primitive);
    if (!inputs.ok()) return inputs.status();
    const bool is_list = primitive.tag() == "polylist";
    absl::StatusOr<std::vector<std::uint32_t>> sizes = std::vector<std::uint32_t>();
    if (is_list) {
      const absl::StatusOr<XmlElement> vcount = primitive.ExactlyOne("vcount");
      if (!vcount.ok()) return vcount.status();
      sizes = ReadIndices(*vcount);
      if (!sizes.ok()) return sizes.status();
    }
    for (const XmlElement& p : primitive.Children("p")) {
      const absl::StatusOr<std::vector<std::uint32_t>> indices = ReadIndices(p);
      if (!indices.ok()) return indices.status();
      const auto corners = static_cast<std::uint32_t>(indices->size() / inputs->stride);
      if (primitive.tag() == "triangles") sizes->assign(corners / 3, 3);
      if (primitive.tag() == "polygons") sizes->assign(1, corners);
      if (absl::Status status = Add(p, *inputs, *indices, *sizes); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status Add(const XmlElement& p, const Inputs& inputs,
                   const std::vector<std::uint32_t>& indices,
                   const std::vector<std::uint32_t>& sizes) {
    std::uint64_t corners = 0;
    for (const std::uint32_t size : sizes) corners += size;
    if (corners * inputs.stride != indices.size()) {
      return p.Fault(
          absl::StrCat("holds ", indices.size(), " indices, must hold ", corners * inputs.stride));
    }
    const std::vector<Vector3>& positions = *inputs.positions;
    std::size_t at = inputs.vertex_offset;
    std::vector<Vector3> polygon;
    for (const std::uint32_t size : sizes) {
      polygon.clear();
      for (std::uint32_t i = 0; i < size; ++i, at += inputs.stride) {
        if (indices[at] >= positions.size()) {
          return p.Fault(
              absl::StrCat("holds vertex ", indices[at], ", must be one of ", positions.size()));
        }
        polygon.push_back(positions[indices[at]]);
      }
      if (absl::Status status = AddPolygon(p, polygon); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status AddPolygon(const XmlElement& p, const std::vector<Vector3>& polygon) {
    const absl::StatusOr<std::vector<PolygonTriangulator::Triangle>> triangles =
        triangulator_.Triangulate(polygon);
    if (absl::IsInvalidArgument(triangles.status())) {
      return p.Fault(std::string(triangles.status().message()));
    }
    if (!triangles.ok()) return triangles.status();
    if (triangles->size() > max_triangles_ - read_.size()) return TooManyTriangles(max_triangles_);
    for (const auto& [a, b, c] : *triangles) read_.push_back({polygon[a], polygon[b], polygon[c]});
    return absl::OkStatus();
  }

  std::size_t max_triangles_;
  PolygonTriangulator& triangulator_;
  std::map<std::string, std::optional<std::vector<Vector3>>> positions_;  // by URL of the source
  std::map<std::string, XmlElement> by_id_;                               // keys begin with "#"
  ColladaGeometry read_;
};

}  // namespace

absl::StatusOr<std::vector<double>> ReadNumbers(const XmlElement& element) {
  return ReadList<double>(element, ParseFinite, "must hold finite numbers");
}

absl::StatusOr<ColladaGeometry> ReadColladaGeometry(const XmlElement& geometry,
                                                    std::size_t max_triangles,
                                                    PolygonTriangulator& triangulator) {
  return GeometryReader(max_triangles, triangulator).Read(geometry);
}

}  // namespace cwm::collision
