#include "collision/query/world_filter.h"

namespace cwm::collision {
namespace {

const Obstacle* FindObstacle(const WorldSnapshot& world, const std::string& name) {
  if (const WorldObjectPtr* object = world.objects().Find(name)) return object->get();
  const WorldRobotPtr robot = world.FindRobot(name);
  return robot != nullptr ? &robot->body : nullptr;  // kept alive by the world
}

// True for a link of the body, or an object attached to it: such a name restricts the body. The
// name of the body itself restricts the obstacles: the body is then tested against itself alone.
bool RestrictsBody(const NamedThing& named, const QueryBody& body) {
  return body.IsNamed(named.name) && (named.name != body.self || !named.link.empty());
}

}  // namespace

WorldFilter::WorldFilter(const WorldSnapshot& world, const QueryOptions& options)
    : WorldFilter(world, options, QueryBody()) {}

WorldFilter::WorldFilter(const WorldSnapshot& world, const QueryOptions& options,
                         const QueryBody& body)
    : representation_(options.representation),
      skips_unseen_(options.unseen == UnseenSpace::kIgnore) {
  for (const std::string& name : options.ignore) Skip(world, name);
  if (!body.self.empty()) Skip(world, body.self);
  for (const AttachedObject& attached : body.attached) Skip(world, attached.object->name);
  std::sort(skipped_.begin(), skipped_.end(), std::less<>());
  for (const NamedThing& named : options.only) {
    if (!RestrictsBody(named, body)) Restrict(world, named);
  }
}

void WorldFilter::Skip(const WorldSnapshot& world, const std::string& name) {
  if (const Obstacle* obstacle = FindObstacle(world, name)) skipped_.push_back(obstacle);
}

void WorldFilter::Restrict(const WorldSnapshot& world, const NamedThing& to) {
  is_restricted_ = true;
  const Obstacle* const obstacle = FindObstacle(world, to.name);
  if (obstacle == nullptr) return;
  const auto at =
      std::ranges::lower_bound(named_, obstacle, std::less<>(), &NamedObstacle::obstacle);
  const bool is_new = at == named_.end() || at->obstacle != obstacle;
  NamedObstacle& named = is_new ? *named_.insert(at, {obstacle, {}}) : *at;
  if (to.link.empty() || obstacle->robot == nullptr) return named.links.clear();
  if (!is_new && named.links.empty()) return;  // all links are named already
  const RobotModel& model = *obstacle->robot->model;
  named.links.resize(model.links.size(), false);
  if (const auto link = model.FindLink(to.link))
    named.links[static_cast<std::size_t>(*link)] = true;
}

const WorldFilter::NamedObstacle* WorldFilter::FindNamed(const Obstacle& obstacle) const {
  const auto at =
      std::ranges::lower_bound(named_, &obstacle, std::less<>(), &NamedObstacle::obstacle);
  return at != named_.end() && at->obstacle == &obstacle ? &*at : nullptr;
}

bool WorldFilter::SkipsLink(const Obstacle& obstacle, int link) const {
  const NamedObstacle* const named = FindNamed(obstacle);
  return named != nullptr && !named->links.empty() && !named->links[static_cast<std::size_t>(link)];
}

}  // namespace cwm::collision
