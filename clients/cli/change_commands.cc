// cwm move, cwm remove
#include <algorithm>
#include <memory>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/pose_argument.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct MoveArguments {
  std::string name, at, by;
  ChangeArguments change;
};

struct RemoveArguments {
  std::vector<std::string> names;
  ChangeArguments change;
};

// The change that moves the object by a vector; it fails if somebody else moves it meanwhile.
absl::StatusOr<pb::Change> MoveBy(Session& session, const MoveArguments& arguments) {
  const auto by = ParseVector(arguments.by, "--by");
  if (!by.ok()) return by.status();
  const client::Connection& connection = session.connection();
  pb::GetObjectRequest request;
  request.set_world(session.world);
  request.set_name(arguments.name);
  request.set_view(pb::OBJECT_VIEW_BASIC);
  const auto found =
      connection.Call(&pb::WorldService::Stub::GetObject, connection.worlds(), request);
  if (!found.ok()) return found.status();
  const pb::Object& object = found->object();
  pb::Change change;
  pb::Pose& pose = *change.mutable_move()->mutable_x_world_object();
  pose = object.x_world_object();
  pose.set_tx_m(pose.tx_m() + by->x());
  pose.set_ty_m(pose.ty_m() + by->y());
  pose.set_tz_m(pose.tz_m() + by->z());
  change.set_expected_object_revision(std::max(object.pose_revision(), object.geometry_revision()));
  return change;
}

absl::StatusOr<pb::Change> MoveTo(Session& session, const MoveArguments& arguments) {
  const auto pose = ParsePoseArgument(session, arguments.at, "--at");
  if (!pose.ok()) return pose.status();
  pb::Change change;
  *change.mutable_move()->mutable_x_world_object() = PoseToProto(*pose);
  return change;
}

absl::Status Move(Session& session, const MoveArguments& arguments) {
  if (arguments.at.empty() == arguments.by.empty()) return UsageError("one of --at and --by");
  auto change = arguments.by.empty() ? MoveTo(session, arguments) : MoveBy(session, arguments);
  if (!change.ok()) return change.status();
  change->mutable_move()->set_name(arguments.name);
  return Apply(session, arguments.change, {*change}, absl::StrCat("moved ", arguments.name));
}

absl::Status Remove(Session& session, const RemoveArguments& arguments) {
  std::vector<pb::Change> changes;
  for (const std::string& name : arguments.names) {
    changes.emplace_back().mutable_remove()->set_name(name);
  }
  const std::size_t count = arguments.names.size();
  return Apply(session, arguments.change, changes,
               count == 1 ? absl::StrCat("removed ", arguments.names[0])
                          : absl::StrCat("removed ", count, " objects"));
}

}  // namespace

void AddChangeOptions(CLI::App& command, ChangeArguments& change) {
  command
      .add_option("--expected-revision", change.expected_revision,
                  "only if the world is still at this revision")
      ->type_name("N");
  command.add_option("--request-id", change.request_id, "a retry under it is done once")
      ->type_name("ID");
}

absl::Status Apply(Session& session, const ChangeArguments& arguments,
                   const std::vector<pb::Change>& changes, const std::string& done) {
  pb::ApplyChangesRequest request;
  request.set_world(session.world);
  request.mutable_changes()->Assign(changes.begin(), changes.end());
  if (arguments.expected_revision) request.set_expected_revision(*arguments.expected_revision);
  request.set_request_id(arguments.request_id);
  const client::Connection& connection = session.connection();
  const auto response =
      connection.Call(&pb::WorldService::Stub::ApplyChanges, connection.worlds(), request);
  if (!response.ok()) return response.status();
  session.Print(*response, [&] {
    session.streams.out << done << ", revision " << response->revision() << "\n";
  });
  return absl::OkStatus();
}

void AddChangeCommands(CommandLine& line) {
  const auto move = std::make_shared<MoveArguments>();
  CLI::App& moving = AddCommand(
      line,
      {"move",
       "an object to another pose",
       {"cwm move crate --at 0.5,0.1,0.02,0,0,0.7071068,0.7071068", "cwm move crate --by 0.1,0,0"}},
      [move](Session& session) { return Move(session, *move); });
  moving.add_option("NAME", move->name, "of the object")->required();
  CLI::Option* const at = moving.add_option("--at", move->at, "its new pose in the world (m)")
                              ->type_name(kPoseArgumentForm);
  AddFormerName(moving, "--to", move->at, at);
  moving.add_option("--by", move->by, "how far, along the world's axes (m)")->type_name("DX,DY,DZ");
  AddChangeOptions(moving, move->change);

  const auto remove = std::make_shared<RemoveArguments>();
  CLI::App& removing = AddCommand(
      line, {"remove", "objects, all or none", {"cwm remove crate", "cwm remove can1 can2"}},
      [remove](Session& session) { return Remove(session, *remove); });
  removing.add_option("NAME", remove->names, "of the objects")->required();
  AddChangeOptions(removing, remove->change);
}

}  // namespace cwm::cli
