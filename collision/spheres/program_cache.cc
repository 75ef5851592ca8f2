#include "collision/spheres/program_cache.h"

#include <algorithm>
#include <utility>

namespace cwm::collision {
namespace {

bool IsSame(const FixedFrame& a, const FixedFrame& b) {
  return a.link == b.link && a.X_LF.matrix() == b.X_LF.matrix();
}
template <class T>
bool IsSame(const T& a, const T& b) {
  return a == b;
}

template <class T>
bool AreSame(const std::vector<T>& kept, std::span<const T> wanted) {
  return std::equal(kept.begin(), kept.end(), wanted.begin(), wanted.end(),
                    [](const T& a, const T& b) { return IsSame(a, b); });
}

}  // namespace

std::shared_ptr<const SphereProgram> ProgramCache::FindCached(const JointGroup& group,
                                                              const std::vector<double>& base,
                                                              const SphereSet& set) {
  const auto found = std::find_if(cached_.begin(), cached_.end(), [&](const Entry& entry) {
    return entry.base == base && entry.variables == group.variables &&
           AreSame(entry.spheres, set.spheres) && AreSame(entry.fixed_frames, set.fixed_frames) &&
           AreSame(entry.sphere_pairs, set.pairs.spheres) &&
           AreSame(entry.link_pairs, set.pairs.links);
  });
  if (found == cached_.end()) return nullptr;
  std::rotate(cached_.begin(), found, found + 1);
  return cached_.front().program;
}

std::shared_ptr<const SphereProgram> ProgramCache::Find(const JointGroup& group,
                                                        std::span<const double> base,
                                                        const SphereSet& set) {
  std::vector<double> fixed(base.begin(), base.end());
  for (const int variable : group.variables) fixed[static_cast<std::size_t>(variable)] = 0;
  {
    const std::lock_guard lock(mutex_);
    if (auto kept = FindCached(group, fixed, set)) return kept;
  }
  std::optional<SphereProgram> compiled = CompileSpheres(model_, group, fixed, set);
  if (!compiled) return nullptr;
  auto program = std::make_shared<const SphereProgram>(*std::move(compiled));
  Entry entry{.variables = group.variables,
              .base = std::move(fixed),
              .spheres = {set.spheres.begin(), set.spheres.end()},
              .fixed_frames = {set.fixed_frames.begin(), set.fixed_frames.end()},
              .sphere_pairs = {set.pairs.spheres.begin(), set.pairs.spheres.end()},
              .link_pairs = {set.pairs.links.begin(), set.pairs.links.end()},
              .program = program};
  const std::lock_guard lock(mutex_);
  if (auto kept = FindCached(group, entry.base, set)) return kept;  // by another thread
  if (cached_.size() == kMaxCachedPrograms) cached_.pop_back();
  cached_.insert(cached_.begin(), std::move(entry));
  return program;
}

}  // namespace cwm::collision
