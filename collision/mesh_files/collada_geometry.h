// The <geometry> of a Collada file.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/pose.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {

// Polygons in the frame and unit of the file: sizes[i] corners each, one after another.
struct ColladaGeometry {
  std::vector<Vector3> corners;
  std::vector<std::uint32_t> sizes;
};

// A list of finite numbers, as the text of an element.
absl::StatusOr<std::vector<double>> ReadNumbers(const XmlElement& element);

absl::StatusOr<ColladaGeometry> ReadColladaGeometry(const XmlElement& geometry);

}  // namespace cwm::collision
