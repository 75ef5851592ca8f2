#include "collision/world/world_robot.h"

#include <algorithm>
#include <utility>

#include "collision/engines/exact_engine.h"
#include "collision/geometry/quick_bounds.h"
#include "collision/robot/kinematics.h"
#include "collision/spheres/bounding_spheres.h"
#include "collision/spheres/program_cache.h"
#include "collision/spheres/tight_pairs.h"

namespace cwm::collision {
namespace {

// Stops work once a stop is requested.
class StopCounter final : public WorkCounter {
 public:
  explicit StopCounter(const std::stop_token& stop) : stop_(stop) {}
  bool MustEndAfter(std::size_t) override { return stop_.stop_requested(); }
  bool MustEndNow() override { return stop_.stop_requested(); }

 private:
  const std::stop_token& stop_;
};

std::vector<double> PaddingsOfParts_m(const RobotModel& model,
                                      const std::vector<int>& link_of_part) {
  std::vector<double> paddings_m;
  for (const int link : link_of_part) {
    paddings_m.push_back(model.links[static_cast<std::size_t>(link)].padding_m);
  }
  if (std::ranges::all_of(paddings_m, [](double padding_m) { return padding_m == 0; })) return {};
  return paddings_m;
}

std::shared_ptr<const SphereModel> FitLinkSpheres(const RobotGeometry& robot, WorkCounter& work) {
  std::vector<std::vector<LinkPiece>> pieces(robot.model->links.size());
  for (std::size_t k = 0; k < robot.geometry->parts.size(); ++k) {
    const PreparedPart& part = robot.geometry->parts[k];
    pieces[static_cast<std::size_t>(robot.link_of_part[k])].push_back(
        {.X_LP = part.X_OP,
         .shape = &part.shape,
         .tree = TreeOf(*part.engines[static_cast<int>(EngineKind::kExact)])});
  }
  auto around = std::make_shared<SphereModel>();
  for (const std::vector<LinkPiece>& of_link : pieces) {
    std::optional<std::vector<LinkSphere>> spheres = FitBoundingSpheres(of_link, &work);
    if (!spheres) return nullptr;
    around->links.push_back(*std::move(spheres));
  }
  return around;
}

PreparedBounds PrepareBounds(const RobotGeometry& robot) {
  const PreparedSpheres spheres = PrepareSpheres(*robot.bounding_spheres);
  PreparedBounds bounds{.link_of_part = spheres.link_of_part,
                        .sphere_count = static_cast<std::int32_t>(spheres.link_of_part.size()),
                        .tight_pairs = FindTightPairs(*robot.model, *robot.bounding_spheres)};
  auto geometry = std::make_shared<PreparedModel>(*spheres.geometry);
  std::vector<bool> is_tight(robot.model->links.size(), false);
  for (const LinkPair& pair : bounds.tight_pairs) {
    is_tight[static_cast<std::size_t>(pair.first)] = true;
    is_tight[static_cast<std::size_t>(pair.second)] = true;
  }
  for (std::size_t k = 0; k < robot.geometry->parts.size(); ++k) {
    const int link = robot.link_of_part[k];
    if (!is_tight[static_cast<std::size_t>(link)]) continue;
    geometry->parts.push_back(robot.geometry->parts[k]);
    bounds.link_of_part.push_back(link);
  }
  geometry->has_caps = geometry->has_caps || robot.geometry->has_caps;
  bounds.geometry = std::move(geometry);
  return bounds;
}

}  // namespace

PreparedSpheres PrepareSpheres(const SphereModel& spheres) {
  PreparedSpheres prepared;
  auto shapes = std::make_shared<HybridModel>();
  for (std::size_t link = 0; link < spheres.links.size(); ++link) {
    for (const LinkSphere& sphere : spheres.links[link]) {
      shapes->shapes.push_back(
          {.X_OS = Pose(Eigen::Translation3d(sphere.center_L)), .shape = Sphere{sphere.radius_m}});
      prepared.link_of_part.push_back(static_cast<int>(link));
    }
  }
  prepared.geometry = Prepare(std::move(shapes));
  return prepared;
}

std::shared_ptr<const RobotGeometry> PrepareRobot(std::shared_ptr<const RobotModel> model,
                                                  std::optional<SphereModel> spheres_as_given,
                                                  const std::stop_token& stop) {
  auto robot = std::make_shared<RobotGeometry>();
  auto shapes = std::make_shared<HybridModel>();
  for (int link = 0; link < static_cast<int>(model->links.size()); ++link) {
    for (const CollisionGeometry& collision : model->links[link].collisions) {
      shapes->shapes.push_back({.X_OS = collision.X_LG, .shape = collision.shape});
      robot->link_of_part.push_back(link);
    }
  }
  robot->padding_of_part_m = PaddingsOfParts_m(*model, robot->link_of_part);
  StopCounter work(stop);
  robot->geometry = Prepare(std::move(shapes), &work);
  if (robot->geometry == nullptr) return nullptr;
  for (const PreparedPart& part : robot->geometry->parts) {
    part.engines.BuildHulls(&work);
    if (stop.stop_requested()) return nullptr;
  }
  robot->model = std::move(model);
  robot->programs = std::make_shared<ProgramCache>(*robot->model);
  if (spheres_as_given) robot->prepared_spheres_as_given = PrepareSpheres(*spheres_as_given);
  robot->bounding_spheres = FitLinkSpheres(*robot, work);
  if (stop.stop_requested()) return nullptr;
  if (robot->bounding_spheres) robot->prepared_bounds = PrepareBounds(*robot);
  robot->spheres_as_given = std::move(spheres_as_given);
  return robot;
}

void PlaceLinks(WorldRobot& robot) {
  robot.X_WL.resize(robot.model().links.size(), Pose::Identity());
  LinkPoses(robot.model(), robot.X_WB, robot.state, robot.X_WL);
}

WorldRobotPtr Place(WorldRobot robot) {
  PlaceLinks(robot);
  const PreparedModel& geometry = *robot.robot->geometry;
  robot.body = {};
  robot.body.name = robot.name;
  robot.body.geometry = robot.robot->geometry;
  robot.body.robot = robot.robot;
  robot.body.parts_W.reserve(geometry.parts.size());
  for (std::size_t k = 0; k < geometry.parts.size(); ++k) {
    const PreparedPart& part = geometry.parts[k];
    const Pose& X_WL = robot.X_WL[static_cast<std::size_t>(robot.robot->link_of_part[k])];
    const Pose X_WP = X_WL * part.X_OP;
    // Robots move often, so a part with many vertices gets the bounds of its rotated bounding box.
    const Aabb bounds_W = HasManyVertices(part.shape) ? BoundsOfBox(part.bounds_O, X_WL)
                                                      : TightBounds(part.shape, X_WP);
    robot.body.parts_W.push_back({.X_WP = X_WP, .bounds_W = bounds_W});
    robot.body.bounds_W.extend(bounds_W);
  }
  return std::make_shared<const WorldRobot>(std::move(robot));
}

}  // namespace cwm::collision
