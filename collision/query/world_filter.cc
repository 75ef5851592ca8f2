#include "collision/query/world_filter.h"

namespace cwm::collision {

WorldFilter::WorldFilter(const WorldSnapshot& world, const QueryOptions& options,
                         const std::string& self)
    : representation_(options.representation),
      skips_unseen_(options.unseen == UnseenSpace::kIgnore) {
  const auto skip = [&](const std::string& name) {
    const WorldObjectPtr* object = world.objects().Find(name);
    if (object != nullptr) skipped_.push_back(object->get());
  };
  if (!self.empty()) skip(self);
  for (const std::string& name : options.ignore) skip(name);
}

}  // namespace cwm::collision
