#include "collision/robot/sphere_model.h"

#include <string>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

absl::StatusOr<std::vector<LinkSphere>> SpheresOf(const Link& link) {
  std::vector<LinkSphere> spheres;
  for (std::size_t i = 0; i < link.collisions.size(); ++i) {
    const CollisionGeometry& geometry = link.collisions[i];
    const Sphere* sphere = std::get_if<Sphere>(&geometry.shape);
    if (sphere == nullptr) {
      return FaultAt(absl::StrCat("sphere model: link ", Quoted(link.name), ": collision[", i,
                                  "] is a ", std::string(NameOf(KindOf(geometry.shape)))),
                     "must be a sphere");
    }
    spheres.push_back({.center_L = geometry.X_LG.translation(), .radius_m = sphere->radius_m});
  }
  return spheres;
}

}  // namespace

absl::StatusOr<SphereModel> SphereModelFromUrdf(const RobotDescription& spherized,
                                                const RobotModel& model) {
  SphereModel spheres;
  spheres.links.resize(model.links.size());
  for (const Link& link : spherized.links) {
    const std::optional<int> index = model.FindLink(link.name);
    if (!index.has_value()) {
      return FaultAt(absl::StrCat("sphere model: link ", Quoted(link.name)),
                     absl::StrCat("must be a link of the robot ", Quoted(model.name)));
    }
    absl::StatusOr<std::vector<LinkSphere>> of_link = SpheresOf(link);
    if (!of_link.ok()) return of_link.status();
    spheres.links[*index] = *std::move(of_link);
  }
  return spheres;
}

}  // namespace cwm::collision
