// Steps of a watch as messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"
#include "server/core/watch.h"
#include "server/core/world.h"
#include "server/wire/objects.h"

namespace cwm::server {

struct WatchContext {
  const World& world;
  View view = View::kShapes;
  GeometryStore& store;
};

// Members [*next, ...) of the initial state, objects before robots before
// rules of pairs, as many as fit into about a
// mebibyte; moves *next on. The message that reaches the last one says initial_state_done.
v1::WatchWorldResponse InitialStatePiece(const collision::WorldSnapshot& snapshot,
                                         const WatchContext& context, std::size_t* next);

// Deltas [*next, ...) of the step, likewise; all but the last message of a step say `more`. A delta
// is a move when nothing but the pose differs, that of a robot a state when its model is the same.
v1::WatchWorldResponse EventsPiece(const WatchStep& step, const WatchContext& context,
                                   std::size_t* next);

// With the observations after number `*observed`, as many as one message holds; moves it on.
v1::WatchWorldResponse BookmarkMessage(collision::Revision revision, const World& world,
                                       std::uint64_t* observed);

}  // namespace cwm::server
