#include "collision/query/world_filter.h"

#include <algorithm>

namespace cwm::collision {

WorldFilter::WorldFilter(const WorldSnapshot& world, const QueryOptions& options,
                         const std::string& self)
    : representation_(options.representation) {
  const auto& objects = world.objects();
  const auto skip = [&](const std::string& name) {
    const auto at = std::lower_bound(
        objects.begin(), objects.end(), name,
        [](const WorldObjectPtr& object, const std::string& n) { return object->name < n; });
    if (at == objects.end() || (*at)->name != name) return;
    if (skipped_.empty()) skipped_.resize(objects.size(), 0);
    skipped_[at - objects.begin()] = 1;
  };
  if (!self.empty()) skip(self);
  for (const std::string& name : options.ignore) skip(name);
}

}  // namespace cwm::collision
