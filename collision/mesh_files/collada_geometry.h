// The <geometry> of a Collada file.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/pose.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {

// Triangles in the frame and unit of the file. Polygons are triangulated here, once for all nodes
// that use them.
using ColladaGeometry = std::vector<std::array<Vector3, 3>>;

// Reads the text of an element as a list of finite numbers.
absl::StatusOr<std::vector<double>> ReadNumbers(const XmlElement& element);

// Refuses a geometry of more than `max_triangles`. The triangulator counts the work of all
// geometries of the file.
absl::StatusOr<ColladaGeometry> ReadColladaGeometry(const XmlElement& geometry,
                                                    std::size_t max_triangles,
                                                    PolygonTriangulator& triangulator);

}  // namespace cwm::collision
