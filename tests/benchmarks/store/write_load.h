// Writers of a running server.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/benchmarks/server/measured_server.h"

namespace cwm::benchmarks {

// The server with a store in a new directory, or with worlds in memory for an empty one; it serves.
// nullptr if it does not come up.
std::unique_ptr<MeasuredServer> StartServer(const std::string& store_directory);

// Puts `count` boxes, "box_0" and so on, into a world.
bool PutMovableBoxes(const MeasuredServer& server, const std::string& world, int count);

// One change of "box_INDEX": to x_m on the x axis.
v1::ApplyChangesRequest MoveOfBox(const std::string& world, int index, double x_m);

struct WriteRates {
  bool ok = false;
  std::int64_t revisions = 0;  // that the worlds gained, as they tell themselves
  double seconds = 0;
  std::vector<double> wall_ms = {};  // of each call
};

// Writers, each with a connection and an object of its own, move their objects for `seconds`: one
// change a call, one call at a time. They share the worlds "w0", "w1" and so on evenly.
WriteRates MeasureWriters(const MeasuredServer& server, int writers, int worlds, double seconds);

}  // namespace cwm::benchmarks
