// The subject of a query (a shape, an object of the world or a robot) and its poses or states, from
// the command line or as JSON lines on stdin.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/robot_arguments.h"
#include "clients/cli/session.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

// Shapes as text: "0.1,0.2,0.3". At most one is set.
struct ShapeArguments {
  std::string box, sphere, cylinder, cone, capsule;
};

void AddShapeOptions(CLI::App& command, ShapeArguments& shape);
bool HasShape(const ShapeArguments& shape);
// A usage error if none or several shapes are set, or if the numbers do not fit.
absl::StatusOr<cwm::v1::PlacedShape> ParseShape(const ShapeArguments& shape);

struct BodyArguments {
  ShapeArguments shape;
  std::string object;           // instead of a shape
  std::vector<std::string> at;  // poses of either; "-": JSON lines on stdin; one of a robot
  RobotArguments robot;         // instead of a shape or an object
};

void AddBodyOptions(CLI::App& command, BodyArguments& body);
// True if any of these options is set.
bool HasBody(const BodyArguments& body);

// A body and its rows.
struct Body {
  cwm::v1::Subject subject;          // without rows
  std::size_t width = 0;             // numbers per row; 0 without rows
  std::vector<double> numbers = {};  // row after row
  std::vector<int> row_counts = {};  // rows of each line, or of the command line
  std::size_t row_count() const { return width == 0 ? 0 : numbers.size() / width; }
};

// In order. Neither shape nor object nor robot: each line on stdin is
//   {"sphere": r, "at": [x, y, z]}            or "box": [x, y, z], "cylinder": [r, l],
//   {"object": "cup", "at": [[..], [..]]}        "cone": [rb, rt, l], "capsule": [r, l]
//   {"robot": "panda", "group": "panda_arm", "joints": [..]}
// where "at" is a pose or several, and "joints" a state or several; and with a shape alone, or
// `--at -`, each line is {"at": ..} or the numbers of a pose as an array.
// Likewise with `--joints -`.
// Malformed lines are INVALID_ARGUMENT naming the line.
absl::StatusOr<std::vector<Body>> ReadBodies(const BodyArguments& body, Session& session);

// The subject with rows [begin, end) of the body.
cwm::v1::Subject SubjectOf(const Body& body, std::size_t begin, std::size_t end);

// The server's limit of a batch (GetServerInfo.limits.max_batch_rows).
inline constexpr std::size_t kMaxRows = 65536;

// The subject of one request.
struct Batch {
  cwm::v1::Subject subject;
  std::size_t row_count = 0;  // without rows an object or a robot is queried at its present place:
                              // 1
};

// Reads the bodies and splits them into batches of at most kMaxRows rows, in order.
absl::StatusOr<std::vector<Batch>> ReadBatches(const BodyArguments& body, Session& session);

}  // namespace cwm::cli
