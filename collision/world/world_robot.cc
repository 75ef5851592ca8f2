#include "collision/world/world_robot.h"

#include <utility>

namespace cwm::collision {

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
                                                  std::optional<SphereModel> spheres_as_given) {
  auto robot = std::make_shared<RobotGeometry>();
  auto shapes = std::make_shared<HybridModel>();
  for (int link = 0; link < static_cast<int>(model->links.size()); ++link) {
    for (const CollisionGeometry& collision : model->links[link].collisions) {
      shapes->shapes.push_back({.X_OS = collision.X_LG, .shape = collision.shape});
      robot->link_of_part.push_back(link);
    }
  }
  robot->geometry = Prepare(std::move(shapes));
  robot->model = std::move(model);
  if (spheres_as_given) robot->prepared_spheres_as_given = PrepareSpheres(*spheres_as_given);
  robot->spheres_as_given = std::move(spheres_as_given);
  return robot;
}

}  // namespace cwm::collision
