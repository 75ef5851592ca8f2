#include "collision/query/restrict_body.h"

#include <algorithm>
#include <vector>

namespace cwm::collision {
namespace {

// By frame, attached objects included: true if it is named.
std::vector<bool> NamedFrames(const QueryBody& body, std::span<const NamedThing> only) {
  std::vector<bool> named(static_cast<std::size_t>(body.TotalFrames()), false);
  for (const NamedThing& thing : only) {
    const bool is_own_link = body.robot != nullptr && thing.name == body.self && !body.self.empty();
    const auto link = is_own_link ? body.robot->FindLink(thing.link) : std::nullopt;
    if (link.has_value()) named[static_cast<std::size_t>(*link)] = true;
    for (std::size_t k = 0; k < body.attached.size(); ++k) {
      const bool is_named =
          body.attached[k].object->name == thing.name || link == body.attached[k].link;
      if (is_named) named[static_cast<std::size_t>(body.frame_count) + k] = true;
    }
  }
  return named;
}

}  // namespace

QueryBody RestrictBody(QueryBody body, std::span<const NamedThing> only) {
  if (only.empty()) return body;
  const std::vector<bool> named = NamedFrames(body, only);
  if (std::ranges::find(named, true) != named.end()) {
    const auto is_named = [&](std::int32_t part) {
      return named[static_cast<std::size_t>(body.FrameOf(part))];
    };
    std::erase_if(body.self_pairs, [&](const PartPair& pair) {
      return !is_named(pair.first) && !is_named(pair.second);
    });
    body.self_only_frames.resize(named.size());
    for (std::size_t k = 0; k < named.size(); ++k) body.self_only_frames[k] = !named[k];
    return body;
  }
  const bool names_itself = std::ranges::any_of(
      only, [&](const NamedThing& thing) { return thing.name == body.self && thing.link.empty(); });
  if (!names_itself) body.self_pairs.clear();
  return body;
}

}  // namespace cwm::collision
