// What asks a question: a shape, an object of the world or points, and where, from the command line
// or as JSON lines on stdin.
#pragma once

#include <CLI/CLI.hpp>
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
  std::vector<std::string> at;  // places; "-": JSON lines on stdin
};

void AddBodyOptions(CLI::App& command, BodyArguments& body);

// The subjects of one or more requests, in order, each of at most kMaxRows rows. Neither shape nor
// object: each line on stdin is
//   {"sphere": r, "at": [x, y, z]}            or "box": [x, y, z], "cylinder": [r, l],
//   {"object": "cup", "at": [[..], [..]]}        "cone": [rb, rt, l], "capsule": [r, l]
// where "at" is a pose or several; and with a shape alone, or `--at -`, each line is {"at": ..} or
// the numbers of a pose as an array. Malformed lines are INVALID_ARGUMENT naming the line.
absl::StatusOr<std::vector<cwm::v1::Subject>> ReadSubjects(const BodyArguments& body,
                                                           Session& session);

// The server's limit of a batch (GetServerInfo.limits.max_batch_rows).
inline constexpr std::size_t kMaxRows = 65536;

// How many rows a subject asks for; an object without poses asks for its stored one.
std::size_t RowCount(const cwm::v1::Subject& subject);

}  // namespace cwm::cli
