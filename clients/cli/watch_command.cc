// cwm watch
#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <ostream>
#include <thread>

#include "absl/strings/str_cat.h"
#include "clients/cli/closed_pipe.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/object_table.h"
#include "clients/cli/pair_arguments.h"
#include "clients/cli/quantity.h"
#include "clients/cli/robot_table.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct WatchArguments {
  std::optional<std::int64_t> from;
  std::string world_uid;   // the uid of the world whose revision `from` is
  std::int64_t count = 0;  // of messages; 0: no limit
  bool once = false;
  bool coalesced = false;
};

void PrintObject(const pb::Object& object, std::int64_t revision, const char* what,
                 std::ostream& out) {
  out << revision << "  " << what << "  " << object.name() << "  " << ShortName(object.kind());
  if (object.kind() == pb::OBJECT_KIND_MOVER) {
    out << "  " << object.shapes_size() << (object.shapes_size() == 1 ? " box" : " boxes");
  } else {
    for (const pb::ShapePart& part : object.shapes()) out << "  " << FormatShape(part);
  }
  out << "  at " << FormatPose(object.x_world_object());
  if (object.has_attachment()) {
    out << "  attached to " << object.attachment().robot() << ":" << object.attachment().link();
  }
  out << "\n";
}

void PrintEvent(const pb::ObjectEvent& event, std::int64_t revision, std::ostream& out) {
  switch (event.event_case()) {
    case pb::ObjectEvent::kPut:
      return PrintObject(event.put(), revision, "put   ", out);
    case pb::ObjectEvent::kMove:
      out << revision << "  move    " << event.move().name() << "  to "
          << FormatPose(event.move().x_world_object());
      if (event.motion() == pb::MOTION_MOVING) out << "  moving";
      out << "\n";
      return;
    case pb::ObjectEvent::kRemove:
      out << revision << "  remove  " << event.remove() << "\n";
      return;
    case pb::ObjectEvent::EVENT_NOT_SET:
      return;
  }
}

void PrintRobot(const pb::Robot& robot, std::int64_t revision, const char* what,
                std::ostream& out) {
  out << revision << "  " << what << "  " << robot.name() << "  robot of " << robot.links_size()
      << " links  at " << FormatPose(robot.x_world_base()) << "\n";
}

void PrintEvent(const pb::RobotEvent& event, std::int64_t revision, std::ostream& out) {
  switch (event.event_case()) {
    case pb::RobotEvent::kPut:
      return PrintRobot(event.put(), revision, "put   ", out);
    case pb::RobotEvent::kState:
      out << revision << "  state   " << event.state().name() << "  "
          << FormatJoints(event.state().state()) << "  at "
          << FormatPose(event.state().x_world_base()) << "\n";
      return;
    case pb::RobotEvent::kRemove:
      out << revision << "  remove  " << event.remove() << "\n";
      return;
    case pb::RobotEvent::EVENT_NOT_SET:
      return;
  }
}

void PrintRule(const pb::PairRule& rule, std::int64_t revision, const char* what,
               std::ostream& out) {
  out << revision << "  " << what << "  " << PairMemberText(rule.pair().a()) << " and "
      << PairMemberText(rule.pair().b()) << "  " << FormatRule(rule) << "\n";
}

void PrintMessage(const pb::WatchWorldResponse& message, std::ostream& out) {
  for (const pb::Object& object : message.initial_state().objects()) {
    PrintObject(object, message.revision(), "is    ", out);
  }
  for (const pb::Robot& robot : message.initial_state().robots()) {
    PrintRobot(robot, message.revision(), "is    ", out);
  }
  for (const pb::PairRule& rule : message.initial_state().pair_rules()) {
    PrintRule(rule, message.revision(), "is    ", out);
  }
  if (message.initial_state().initial_state_done()) {
    out << message.revision() << "  that is the world, uid " << message.world_uid()
        << "; its changes follow\n";
  }
  for (const pb::ObjectEvent& event : message.events().events()) {
    PrintEvent(event, message.revision(), out);
  }
  for (const pb::RobotEvent& event : message.events().robot_events()) {
    PrintEvent(event, message.revision(), out);
  }
  for (const pb::PairRule& rule : message.events().pair_rules()) {
    PrintRule(rule, message.revision(), "rule  ", out);
  }
  // The entries of a map in the order of names.
  const auto& facts = message.bookmark().facts();
  for (const auto& [name, told] :
       std::map<std::string, pb::SensorFacts>(facts.begin(), facts.end())) {
    out << message.revision() << "  is now  " << name << "  " << FormatFacts(told) << "\n";
  }
}

// Ends a call once nobody reads its output. A world may stay unchanged for hours, and otherwise
// only a failed write would show it.
class ClosedPipeWatcher {
 public:
  ClosedPipeWatcher(const std::ostream& out, grpc::ClientContext& context)
      : thread_([this, &out, &context](const std::stop_token& stop) {
          while (!stop.stop_requested() && !closed_) {
            if (!IsPipeClosed(out, kPollPeriod)) continue;
            closed_ = true;
            context.TryCancel();
          }
        }) {}
  bool closed() const { return closed_; }

 private:
  static constexpr std::chrono::milliseconds kPollPeriod{50};  // may outlive the call by this
  std::atomic<bool> closed_{false};
  std::jthread thread_;  // last: it uses the other members
};

absl::Status Watch(Session& session, const WatchArguments& arguments) {
  if (arguments.from.value_or(0) > 0 && arguments.world_uid.empty()) {
    return UsageError(absl::StrCat(
        "--world-uid is absent, must be given with --from ", *arguments.from,
        ": after a restart another world may have that revision; `cwm watch` and `cwm status` "
        "print it"));
  }
  pb::WatchWorldRequest request;
  request.set_world(session.world);
  request.set_mode(arguments.coalesced ? pb::WATCH_MODE_COALESCED : pb::WATCH_MODE_LOSSLESS);
  if (arguments.from) request.set_from_revision(*arguments.from);
  request.set_world_uid(arguments.world_uid);
  grpc::ClientContext context;
  session.connection().Prepare(context);
  const auto reader = session.connection().worlds().WatchWorld(&context, request);
  const ClosedPipeWatcher pipe(session.streams.out, context);
  pb::WatchWorldResponse message;
  std::int64_t messages = 0;
  bool ended_here = false;
  while (!ended_here && session.streams.out && reader->Read(&message)) {
    if (session.form == OutputForm::kTable) {
      PrintMessage(message, session.streams.out);
    } else {
      session.PrintLine(message);
    }
    session.streams.out.flush();
    ended_here = ++messages == arguments.count ||
                 (arguments.once && message.initial_state().initial_state_done());
  }
  if (ended_here || !session.streams.out) {
    context.TryCancel();
    reader->Finish();
    return absl::OkStatus();
  }
  const grpc::Status end = reader->Finish();
  return pipe.closed() ? absl::OkStatus() : client::StatusFromGrpc(end);
}

}  // namespace

void AddWatchCommand(CommandLine& line) {
  const auto arguments = std::make_shared<WatchArguments>();
  CLI::App& command = AddCommand(
      line,
      {"watch",
       "the world as it is, then every change in the order of revisions",
       {"cwm watch", "cwm watch --from 7 --world-uid UID -o ndjson", "cwm watch --once -o ndjson"},
       "One line a change; -o json and -o ndjson print one message a line. With --from "
       "N only what came\n"
       "after revision N of the world that has the --world-uid: exit code 4 where it was "
       "replaced. Ends\n"
       "with the server, at --deadline, --count or --once."},
      [arguments](Session& session) { return Watch(session, *arguments); });
  command.add_option("--from", arguments->from, "resume after this revision")
      ->type_name("REVISION");
  command
      .add_option("--world-uid", arguments->world_uid,
                  "the world that must be there still; needed with --from, save --from 0")
      ->type_name("UID");
  command.add_option("--count", arguments->count, "end after this many messages")->type_name("N");
  command.add_flag("--once", arguments->once, "end when the world has been printed");
  command.add_flag("--coalesced", arguments->coalesced,
                   "only the newest state of each object, for slow readers");
}

}  // namespace cwm::cli
