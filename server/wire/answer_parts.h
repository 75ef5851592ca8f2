// What the replies of several queries have in common.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "server/wire/answers.h"
#include "server/wire/poses.h"

namespace cwm::server {

inline constexpr std::int32_t kNoObject = -1;

// True for the index of an object; false for no object and for the body itself.
inline bool IsObjectIndex(std::int32_t index) { return index >= 0; }

inline v1::Trust EnumToProto(collision::Accuracy trust) {
  switch (trust) {
    case collision::Accuracy::kExact:
      return v1::TRUST_EXACT;
    case collision::Accuracy::kBounded:
      return v1::TRUST_BOUNDED;
    case collision::Accuracy::kSurfaceOnly:
      return v1::TRUST_SURFACE_ONLY;
    case collision::Accuracy::kDegraded:
      return v1::TRUST_DEGRADED;
  }
  return v1::TRUST_UNSPECIFIED;
}

inline v1::Vector3 VectorAt(const std::vector<double>& values, std::size_t i) {
  return VectorToProto(Vector3(values[3 * i], values[3 * i + 1], values[3 * i + 2]));
}

// Fills the `objects` of a reply, and translates indices of the snapshot to indices of it.
template <class Response>
std::vector<std::int32_t> SetObjectRefs(const std::vector<std::int32_t>& snapshot_indices,
                                        const AnswerContext& context, Response* response) {
  const collision::WorldSnapshot& snapshot = context.snapshot;
  const std::size_t objects = snapshot.objects().size();
  std::vector<std::int32_t> reply_index(objects + snapshot.robots().size(), kNoObject);
  for (const std::int32_t index : snapshot_indices) {
    if (IsObjectIndex(index)) reply_index[index] = 0;
  }
  std::vector<std::size_t> mentioned;
  for (std::size_t i = 0; i < reply_index.size(); ++i) {
    if (reply_index[i] != kNoObject) mentioned.push_back(i);
  }
  std::inplace_merge(mentioned.begin(),
                     std::lower_bound(mentioned.begin(), mentioned.end(), objects), mentioned.end(),
                     [&](std::size_t a, std::size_t b) {
                       return snapshot.ObstacleAt(a).name < snapshot.ObstacleAt(b).name;
                     });
  for (const std::size_t i : mentioned) {
    reply_index[i] = response->objects_size();
    v1::ObjectRef* ref = response->add_objects();
    const auto set = [&](const auto& thing) {
      ref->set_name(thing.name);
      const bool is_of_overlay = thing.create_revision > context.revision;
      if (!is_of_overlay) ref->set_uid(thing.Uid());
    };
    if (i < objects) {
      set(*snapshot.objects()[i]);
    } else {
      const collision::WorldRobot& robot = *snapshot.robots()[i - objects];
      set(robot);
      for (const int link : robot.robot->link_of_part) {
        ref->add_part_links(robot.model().links[static_cast<std::size_t>(link)].name);
      }
    }
  }
  std::vector<std::int32_t> translated(snapshot_indices.size());
  for (std::size_t i = 0; i < translated.size(); ++i) {
    const std::int32_t index = snapshot_indices[i];
    translated[i] = IsObjectIndex(index) ? reply_index[index] : index;
  }
  return translated;
}

// True if the distance has an error bound: DEGRADED answers have no known bound, EXACT ones need
// none.
inline bool HasBound(collision::Accuracy trust) {
  return trust == collision::Accuracy::kBounded || trust == collision::Accuracy::kSurfaceOnly;
}

// The bounds as replies have them: 0 for EXACT answers, NaN for DEGRADED ones.
template <class Columns>
std::vector<double> PairBounds_m(const Columns& answers) {
  std::vector<double> bound_m(answers.bound_m.size(), 0);
  for (std::size_t i = 0; i < bound_m.size(); ++i) {
    const collision::Accuracy trust = answers.accuracy[i];
    if (HasBound(trust)) bound_m[i] = answers.bound_m[i];
    if (trust == collision::Accuracy::kDegraded)
      bound_m[i] = std::numeric_limits<double>::quiet_NaN();
  }
  return bound_m;
}

}  // namespace cwm::server
