// Reads the collision geometry of a URDF.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "absl/status/statusor.h"
#include "collision/robot/prepared_budget.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/robot_limits.h"
#include "collision/robot/urdf.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {

// The pose in an element's <origin>; the identity without one.
absl::StatusOr<Pose> ReadOrigin(const XmlElement& element);

// Reads a name. Refuses an unexpanded xacro expression, which would otherwise be taken for a name.
absl::StatusOr<std::string> ExpandedName(const XmlElement& element, const char* attribute);

// Reads <collision> elements. Meshes with the same name and scale are shared. The triangles of all
// meshes are counted, and the memory is taken from the budget before it is allocated. The source,
// the limits and the budget must outlive the reader.
class CollisionReader {
 public:
  CollisionReader(const MeshSource& source, const RobotLimits& limits, PreparedBudget& budget)
      : source_(source), limits_(limits), budget_(budget) {}

  // Reads the next <collision> of a link, which already has `before` of them, and multiplies its
  // shape by `scale` about its own origin.
  absl::StatusOr<CollisionGeometry> Read(const XmlElement& collision, std::size_t before,
                                         double scale = 1);

 private:
  using Scale = std::array<double, 3>;

  absl::StatusOr<Shape> ReadShape(const XmlElement& geometry, double scale);
  absl::StatusOr<Shape> ReadMesh(const XmlElement& mesh, double scale);
  absl::StatusOr<std::shared_ptr<const TriangleMesh>> FileOf(const XmlElement& mesh,
                                                             const std::string& uri);
  absl::Status CountTriangles(const XmlElement& mesh, std::size_t count);

  const MeshSource& source_;
  const RobotLimits& limits_;
  PreparedBudget& budget_;
  std::size_t triangles_ = 0;
  std::map<std::string, std::shared_ptr<const TriangleMesh>> files_;
  std::map<std::pair<std::string, Scale>, Mesh> meshes_;
};

}  // namespace cwm::collision
