// The collision geometry of a URDF.
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

// The pose of an element by its <origin>; identity without one.
absl::StatusOr<Pose> ReadOrigin(const XmlElement& element);

// Refuses a name that is left for xacro to make, and would be taken for one.
absl::StatusOr<std::string> ExpandedName(const XmlElement& element, const char* attribute);

// Reads <collision> elements. Meshes of the same name and scale are shared; what they all hold
// together is counted, and taken from the budget before it is made. The source, the limits and the
// budget must outlive it.
class CollisionReader {
 public:
  CollisionReader(const MeshSource& source, const RobotLimits& limits, PreparedBudget& budget)
      : source_(source), limits_(limits), budget_(budget) {}

  // The next one of a link, which has so many.
  absl::StatusOr<CollisionGeometry> Read(const XmlElement& collision, std::size_t before);

 private:
  using Scale = std::array<double, 3>;

  absl::StatusOr<Shape> ReadShape(const XmlElement& geometry);
  absl::StatusOr<Shape> ReadMesh(const XmlElement& mesh);
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
