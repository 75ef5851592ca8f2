#include "collision/query/world_filter.h"

namespace cwm::collision {

WorldFilter::WorldFilter(const WorldSnapshot& world, const QueryOptions& options)
    : representation_(options.representation),
      skips_unseen_(options.unseen == UnseenSpace::kIgnore) {
  for (const std::string& name : options.ignore) Skip(world, name);
  std::sort(skipped_.begin(), skipped_.end(), std::less<>());
}

WorldFilter::WorldFilter(const WorldSnapshot& world, const QueryOptions& options,
                         const QueryBody& body)
    : WorldFilter(world, options) {
  if (!body.self.empty()) Skip(world, body.self);
  for (const AttachedObject& attached : body.attached) Skip(world, attached.object->name);
  std::sort(skipped_.begin(), skipped_.end(), std::less<>());
}

void WorldFilter::Skip(const WorldSnapshot& world, const std::string& name) {
  if (const WorldObjectPtr* object = world.objects().Find(name)) {
    skipped_.push_back(object->get());
  } else if (const WorldRobotPtr robot = world.FindRobot(name)) {
    skipped_.push_back(&robot->body);  // kept alive by the world
  }
}

}  // namespace cwm::collision
