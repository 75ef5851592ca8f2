#include "clients/cli/body_arguments.h"

#include <algorithm>
#include <cstring>

#include "clients/cli/body_lines.h"
#include "clients/cli/command.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/pose_argument.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

const std::vector<std::string> kStdin = {"-"};

absl::StatusOr<std::vector<Body>> ReadRigidBody(const BodyArguments& arguments, Session& session) {
  const Streams& streams = session.streams;
  const bool has_shape = HasShape(arguments.shape);
  Body body;
  if (has_shape) {
    if (!arguments.object.empty()) return UsageError("--object: not together with a shape");
    const auto shape = ParseShape(arguments.shape);
    if (!shape.ok()) return shape.status();
    *body.subject.mutable_shapes()->add_shapes() = *shape;
  } else {
    body.subject.mutable_object()->set_name(arguments.object);
  }
  if (has_shape && arguments.at.empty() && streams.in_is_terminal) {
    return UsageError("--at is missing: where the shape is, or JSON lines on stdin");
  }
  if (arguments.at == kStdin || (has_shape && arguments.at.empty())) {
    return ReadBodyLines(&body, streams.in);
  }
  for (const std::string& at : arguments.at) {
    const auto row = ParsePoseArgument(session, at, "--at");
    if (!row.ok()) return row.status();
    body.width = row->size();
    body.numbers.insert(body.numbers.end(), row->begin(), row->end());
  }
  body.row_counts = {static_cast<int>(body.row_count())};
  return std::vector<Body>{body};
}

absl::StatusOr<std::vector<Body>> ReadRobot(const BodyArguments& arguments, Session& session) {
  if (HasShape(arguments.shape) || !arguments.object.empty()) {
    return UsageError("--robot: not together with a shape or --object");
  }
  if (arguments.at.size() > 1 || arguments.at == kStdin) {
    return UsageError("--at: of a robot one pose, that of its root link; its states are --joints");
  }
  RobotArguments robot = arguments.robot;
  if (!arguments.at.empty()) robot.at = arguments.at.front();
  const auto subject = ParseRobotSubject(session, robot, "--at");
  if (!subject.ok()) return subject.status();
  Body body;
  *body.subject.mutable_robot() = *subject;
  if (arguments.robot.joints == kStdin) return ReadBodyLines(&body, session.streams.in);
  for (const std::string& joints : arguments.robot.joints) {
    const auto row = ParseJoints(session, joints, *subject);
    if (!row.ok()) return row.status();
    if (auto status = AppendRow(*row, "--joints", body); !status.ok()) return status;
  }
  body.row_counts = {static_cast<int>(body.row_count())};
  return std::vector<Body>{body};
}

}  // namespace

void AddBodyOptions(CLI::App& command, BodyArguments& body) {
  AddShapeOptions(command, body.shape);
  command.add_option("--object", body.object, "an object of the world, itself left out")
      ->type_name("NAME");
  CLI::Option* const at =
      command
          .add_option(
              "--at", body.at,
              "where it is, metres; may be repeated; of a robot its root link, once; \"-\": "
              "JSON lines on stdin")
          ->allow_extra_args(false)
          ->type_name(kPoseArgumentForm);
  AddRobotOptions(command, body.robot);
  AddFormerName(command, "--x-world-base", body.robot.at, at);
}

bool HasBody(const BodyArguments& body) {
  return HasShape(body.shape) || !body.object.empty() || !body.at.empty() ||
         !body.robot.name.empty() || !body.robot.at.empty() || HasRobotOptions(body.robot);
}

absl::StatusOr<std::vector<Body>> ReadBodies(const BodyArguments& body, Session& session) {
  if (!body.robot.name.empty()) return ReadRobot(body, session);
  if (HasRobotOptions(body.robot) || !body.robot.at.empty())
    return UsageError("--robot is missing: whose joints they are");
  if (HasShape(body.shape) || !body.object.empty()) return ReadRigidBody(body, session);
  if (session.streams.in_is_terminal || !body.at.empty()) {
    return UsageError(
        "a shape (--box, --sphere, ...), --object NAME, --robot NAME, or JSON lines on stdin");
  }
  return ReadBodyLines(nullptr, session.streams.in);
}

pb::Subject SubjectOf(const Body& body, std::size_t begin, std::size_t end) {
  pb::Subject subject = body.subject;
  if (begin == end) return subject;
  std::string data((end - begin) * body.width * sizeof(double), '\0');
  std::memcpy(data.data(), body.numbers.data() + begin * body.width, data.size());
  const auto set = [&](auto* rows) {
    rows->set_scalar(pb::SCALAR_F64);
    rows->set_data(std::move(data));
  };
  if (subject.has_shapes()) {
    set(subject.mutable_shapes()->mutable_x_world_body());
  } else if (subject.has_object()) {
    set(subject.mutable_object()->mutable_x_world_object());
  } else {
    pb::JointRows& rows = *subject.mutable_robot()->mutable_rows();
    set(&rows);
    rows.set_width(static_cast<std::int32_t>(body.width));
  }
  return subject;
}

absl::StatusOr<std::vector<Batch>> ReadBatches(const BodyArguments& arguments, Session& session) {
  const auto bodies = ReadBodies(arguments, session);
  if (!bodies.ok()) return bodies.status();
  std::vector<Batch> batches;
  for (const Body& body : *bodies) {
    std::size_t begin = 0;
    do {
      const std::size_t end = std::min(begin + kMaxRows, body.row_count());
      batches.push_back({SubjectOf(body, begin, end), std::max<std::size_t>(1, end - begin)});
      begin = end;
    } while (begin < body.row_count());
  }
  return batches;
}

}  // namespace cwm::cli
