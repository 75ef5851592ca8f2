#include "tests/benchmarks/benchmark_arms.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>

#include "collision/geometry/mesh_parts.h"
#include "collision/geometry/tessellate.h"
#include "collision/geometry/triangle_mesh.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

// Splits all triangles in four until there are so many; a closed mesh stays closed.
TriangleMesh Refined(TriangleMesh mesh, std::size_t triangles) {
  while (mesh.triangles.size() < triangles) {
    TriangleMesh finer{.vertices = mesh.vertices, .triangles = {}};
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] =
          middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(finer.vertices.size()));
      if (is_new) finer.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
      return at->second;
    };
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.triangles.insert(finer.triangles.end(),
                             {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh = std::move(finer);
  }
  return mesh;
}

Shape FineMesh(const Shape& shape, std::size_t triangles) {
  return MakeMesh(Refined(Tessellate(shape), triangles));
}

// A link of a shape that lies along `to`, from the joint's origin.
CollisionGeometry Along(Shape shape, const Vector3& to) {
  CollisionGeometry geometry{.name = "", .X_LG = Pose::Identity(), .shape = std::move(shape)};
  geometry.X_LG.linear() = BasisFromZ(to.normalized());
  geometry.X_LG.translation() = 0.5 * to;
  return geometry;
}

// Builds chains of joints.
class ArmBuilder {
 public:
  explicit ArmBuilder(const std::string& name) {
    robot_.name = name;
    robot_.links.push_back({.name = "base", .collisions = {}});
  }

  struct Part {
    Vector3 origin;  // of the joint in the parent's frame
    Vector3 axis;
    Vector3 to;  // the link reaches from its joint to here
    double radius_m;
    std::size_t triangles;
    double limit_rad = 2.9;
  };

  // Adds a chain and returns the name of its last link.
  std::string AddChain(const std::string& prefix, const std::vector<Part>& parts) {
    std::string parent = "base";
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Part& part = parts[k];
      const std::string name = prefix + std::to_string(k + 1);
      Link link{.name = name, .collisions = {}};
      const Shape shape = Cylinder{part.radius_m, std::max(0.02, part.to.norm())};
      link.collisions.push_back(Along(FineMesh(shape, part.triangles), part.to));
      robot_.links.push_back(std::move(link));
      Joint joint{.name = prefix + "joint" + std::to_string(k + 1),
                  .kind = JointKind::kRevolute,
                  .parent = parent,
                  .child = name,
                  .X_PJ = Pose(Eigen::Translation3d(part.origin)),
                  .axis_J = part.axis,
                  .limits = {.lower = -part.limit_rad,
                             .upper = part.limit_rad,
                             .max_velocity = 1.0,
                             .max_effort = 1.0},
                  .mimic = {}};
      robot_.joints.push_back(std::move(joint));
      parent = name;
    }
    return parent;
  }

  std::shared_ptr<const RobotModel> Take() { return *MakeRobotModel(std::move(robot_), nullptr); }

 private:
  RobotDescription robot_;
};

const Vector3 kX = Vector3::UnitX(), kY = Vector3::UnitY(), kZ = Vector3::UnitZ();

}  // namespace

BenchmarkArm SixJointArm() {
  ArmBuilder builder("six");
  constexpr std::size_t kMany = 20'000;
  const std::string tool =
      builder.AddChain("link", {{0.16 * kZ, kZ, 0.12 * kY, 0.07, kMany},
                                {0.13 * kY, kY, 0.42 * kZ, 0.055, kMany},
                                {Vector3(0, -0.11, 0.42), kY, 0.36 * kZ, 0.05, kMany},
                                {0.39 * kZ, kY, 0.10 * kY, 0.045, kMany},
                                {0.11 * kY, kZ, 0.09 * kZ, 0.04, kMany},
                                {0.095 * kZ, kY, 0.10 * kY, 0.04, kMany}});
  return {builder.Take(), {tool}};
}

BenchmarkArm FourteenJointArms() {
  ArmBuilder builder("fourteen");
  const auto chain = [](double side) {
    const Vector3 shoulder(0, 0.2 * side, 0.4);
    return std::vector<ArmBuilder::Part>{
        {shoulder, kZ, 0.08 * side * kY, 0.06, 200}, {0.1 * side * kY, kY, 0.2 * kX, 0.055, 200},
        {0.22 * kX, kX, 0.13 * kX, 0.05, 200},       {0.15 * kX, kY, 0.2 * kX, 0.05, 200},
        {0.22 * kX, kX, 0.12 * kX, 0.045, 200},      {0.14 * kX, kY, 0.08 * kX, 0.04, 200},
        {0.1 * kX, kX, 0.12 * kX, 0.035, 200}};
  };
  const std::string left = builder.AddChain("left", chain(1));
  const std::string right = builder.AddChain("right", chain(-1));
  return {builder.Take(), {left, right}};
}

std::shared_ptr<const RobotModel> WithFinerMeshes(const RobotModel& robot, std::size_t triangles) {
  auto finer = std::make_shared<RobotModel>(robot);
  for (ModelLink& link : finer->links) {
    for (CollisionGeometry& geometry : link.collisions) {
      const auto* mesh = std::get_if<Mesh>(&geometry.shape);
      if (mesh != nullptr) geometry.shape = MakeMesh(Refined(*mesh->mesh, triangles));
    }
  }
  return finer;
}

}  // namespace cwm::benchmarks
