// cwm attach, cwm detach
#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cli/change_arguments.h"
#include "clients/cli/commands.h"
#include "clients/cli/number_list.h"
#include "clients/cli/unknown_names.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct AttachArguments {
  std::string name, robot, link, pose;
  std::vector<std::string> touch_links;
  ChangeArguments change;
};

struct DetachArguments {
  std::vector<std::string> names;
  ChangeArguments change;
};

absl::Status Attach(Session& session, const AttachArguments& arguments) {
  pb::Change change;
  pb::AttachObject& attach = *change.mutable_attach();
  attach.set_name(arguments.name);
  attach.set_robot(arguments.robot);
  attach.set_link(arguments.link);
  if (!arguments.pose.empty()) {
    const auto pose = ParsePose(arguments.pose, "--pose");
    if (!pose.ok()) return pose.status();
    *attach.mutable_x_link_object() = PoseToProto(*pose);
  }
  for (const std::string& link : arguments.touch_links) attach.add_touch_links(link);
  absl::Status done = Apply(
      session, arguments.change, {change},
      absl::StrCat("attached ", arguments.name, " to ", arguments.robot, ":", arguments.link));
  if (absl::IsInvalidArgument(done)) {
    std::vector<std::string> links = arguments.touch_links;
    links.insert(links.begin(), arguments.link);
    WarnAboutUnknownLinks(session, arguments.robot, links);
  }
  return done;
}

absl::Status Detach(Session& session, const DetachArguments& arguments) {
  std::vector<pb::Change> changes;
  for (const std::string& name : arguments.names) {
    changes.emplace_back().mutable_detach()->set_name(name);
  }
  const std::size_t count = arguments.names.size();
  return Apply(session, arguments.change, changes,
               count == 1 ? absl::StrCat("detached ", arguments.names[0])
                          : absl::StrCat("detached ", count, " objects"));
}

}  // namespace

void AddAttachCommands(CommandLine& line) {
  const auto attach = std::make_shared<AttachArguments>();
  CLI::App& attaching = AddCommand(
      line,
      {"attach",
       "an object to a link of a robot, as a gripper does",
       {"cwm attach mug --robot panda --link panda_hand --touch-links "
        "panda_leftfinger,panda_rightfinger",
        "cwm attach mug --robot panda --link panda_hand --pose 0,0,0.12"},
       "It moves with the link, and is asked with the robot: against the world and against the "
       "robot's links\n"
       "other than this one and those that may touch it. A put, a move or cwm detach lets "
       "it stand free again."},
      [attach](Session& session) { return Attach(session, *attach); });
  attaching.add_option("NAME", attach->name, "of the object")->required();
  attaching.add_option("--robot", attach->robot, "of the world")->type_name("NAME")->required();
  attaching.add_option("--link", attach->link, "of the robot")->type_name("LINK")->required();
  attaching.add_option("--pose", attach->pose, "in the link's frame (m); default: where it is now")
      ->type_name("X,Y,Z[,QX,QY,QZ,QW]");
  attaching.add_option("--touch-links", attach->touch_links, "other links that may touch it")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("LINK,...");
  AddChangeOptions(attaching, attach->change);

  const auto detach = std::make_shared<DetachArguments>();
  CLI::App& detaching =
      AddCommand(line,
                 {"detach",
                  "objects from their robots: they stand where they are, all or none",
                  {"cwm detach mug"}},
                 [detach](Session& session) { return Detach(session, *detach); });
  detaching.add_option("NAME", detach->names, "of the objects")->required();
  AddChangeOptions(detaching, detach->change);
}

}  // namespace cwm::cli
