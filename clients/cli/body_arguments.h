// What asks a question: a shape, an object of the world or points, and where, from the command line
// or as JSON lines on stdin.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

// Shapes as text: "0.1,0.2,0.3". At most one is set.
struct ShapeArguments {
  std::string box, sphere, cylinder, cone, capsule;
};

void AddShapeOptions(CLI::App& command, ShapeArguments& shape);
bool HasShape(const ShapeArguments& shape);
// A usage error when none or several are set, or the numbers do not fit.
absl::StatusOr<cwm::v1::PlacedShape> ToShape(const ShapeArguments& shape);

struct BodyArguments {
  ShapeArguments shape;
  std::string object;           // instead of a shape
  std::vector<std::string> at;  // poses; "-": JSON lines on stdin
};

void AddBodyOptions(CLI::App& command, BodyArguments& body);

// The subjects of one or more requests, in order, each of at most kMaxRows rows (what the server
// answers as messages). Neither shape nor object: each line on stdin is
//   {"box": [x, y, z], "at": [x, y, z]}      or "sphere": r, "cylinder": [r, l], "cone": [rb, rt,
//   l],
//   {"object": "cup", "at": [[..], [..]]}       "capsule": [r, l], "object": name; "at": a pose or
//   several
// and with a shape and `--at -` each line is {"at": ..} or the numbers of a pose as an array.
// Malformed lines are INVALID_ARGUMENT naming the line.
absl::StatusOr<std::vector<cwm::v1::Subject>> ReadSubjects(const BodyArguments& body,
                                                           const Streams& streams);

inline constexpr std::size_t kMaxRows = 1024;

// How many rows a subject asks for; an object without poses asks for its stored one.
std::size_t RowCount(const cwm::v1::Subject& subject);

}  // namespace cwm::cli
