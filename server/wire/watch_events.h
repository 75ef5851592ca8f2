// Converts the steps of a watch to messages.
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

// Members [*next, ...) of the initial state (objects, then robots, then pair rules), as many as fit
// into about a mebibyte; advances *next. The message with the last member sets initial_state_done.
v1::WatchWorldResponse InitialStatePiece(const collision::WorldSnapshot& snapshot,
                                         const WatchContext& context, std::size_t* next);

// Deltas [*next, ...) of the step, likewise; all but the last message of a step set `more`. A delta
// is a move if only the pose differs; a robot's delta is a state if its model is the same.
v1::WatchWorldResponse EventsPiece(const WatchStep& step, const WatchContext& context,
                                   std::size_t* next);

// A bookmark with the observations after number `*observed`, as many as one message can hold;
// advances *observed.
v1::WatchWorldResponse BookmarkMessage(collision::Revision revision, const World& world,
                                       std::uint64_t* observed);

}  // namespace cwm::server
