#include "server/rpc/export_call.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/core/error.h"
#include "server/core/load_robot.h"
#include "server/export/moveit_scene.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/objects.h"
#include "server/wire/questions.h"

namespace cwm::server {
namespace {

// As many as fit into one message with room to spare; a scene has some tens.
constexpr std::size_t kMostWarnings = 1'000;

// As text a closed mesh of so many has some 55 MB: `cwm import` reads files of up to 64 MiB.
constexpr std::int64_t kMostTriangles = 1'000'000;

absl::Status GoOnWith(const CallContext& call) {
  if (call.stop.stop_requested()) return CallCancelled();
  if (Clock::now() < call.deadline) return absl::OkStatus();
  return MakeError(absl::StatusCode::kDeadlineExceeded,
                   "the deadline was reached before the text was made",
                   {.reason = "TIME_BUDGET_SPENT"});
}

absl::StatusOr<bool> IsYaml(v1::ExportFormat format) {
  switch (format) {
    case v1::EXPORT_FORMAT_UNSPECIFIED:
    case v1::EXPORT_FORMAT_MOVEIT_SCENE:
      return false;
    case v1::EXPORT_FORMAT_MOVEIT_YAML:
      return true;
    default:
      return FieldPath().Field("format").Error(
          absl::StrCat("is ", static_cast<int>(format), ", must be a known ExportFormat"));
  }
}

// The robot of that name; without one the only robot, or nullptr where there is none.
absl::StatusOr<collision::WorldRobotPtr> RobotOf(const collision::WorldSnapshot& snapshot,
                                                 const std::string& name) {
  const FieldPath root;
  const FieldPath path = root.Field("robot");
  if (!name.empty()) {
    if (auto status = CheckName(name, path); !status.ok()) return status;
    auto robot = snapshot.FindRobot(name);
    if (robot == nullptr) return UnknownRobot(name);
    return robot;
  }
  const auto& robots = snapshot.robots();
  if (robots.empty()) return collision::WorldRobotPtr();
  if (robots.size() == 1) return robots[0];
  std::vector<std::string> names;
  for (const auto& robot : robots) names.push_back(robot->name);
  return path.Error(absl::StrCat("is empty, must be one of ", absl::StrJoin(names, ", ")));
}

}  // namespace

ExportWorldCall::ExportWorldCall(grpc::CallbackServerContext* context, Runtime& runtime,
                                 const v1::ExportWorldRequest& request)
    : ChunkedRead(context, runtime), request_(request) {
  if (!counted_) {
    Start(Overloaded("too many streams are open", "TOO_MANY_STREAMS"));
  } else {
    Start(WhatToAwait(runtime, request_.world(), request_.world_uid(), request_.at_revision()));
  }
}

void ExportWorldCall::OnDone() {
  if (counted_) runtime_.streams.GiveBack();
  ChunkedRead::OnDone();
}

absl::Status ExportWorldCall::Prepare(const CallContext& call) {
  const auto is_yaml = IsYaml(request_.format());
  if (!is_yaml.ok()) return is_yaml.status();
  const FieldPath root;
  const auto rule = FromProto(request_.at_revision(), root.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  const auto at = FindWorldAt(runtime_, request_.world(), request_.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  const collision::WorldSnapshot& snapshot = *at->snapshot;
  const GoOn go_on = [&call] { return GoOnWith(call); };
  const std::int64_t most_triangles =
      std::min(kMostTriangles, runtime_.application.limits.max_mesh_triangles);
  auto scene = SceneOf(snapshot, most_triangles, go_on);
  if (!scene.ok()) return scene.status();
  scene->name = at->world->name();
  if (*is_yaml) {
    const auto robot = RobotOf(snapshot, request_.robot());
    if (!robot.ok()) return robot.status();
    const absl::Status added = AddRobotAndRules(snapshot, robot->get(), *scene, go_on);
    if (!added.ok()) return added;
  } else {
    LeaveOutAttached(*scene);
  }
  if (!*is_yaml && (!snapshot.robots().empty() || !snapshot.pair_rules().empty())) {
    scene->warnings.emplace_back(
        "robots and rules of pairs: left out, the format has objects alone");
  }
  auto bytes = *is_yaml ? FormatSceneYaml(*scene, go_on) : FormatSceneText(*scene, go_on);
  if (!bytes.ok()) return bytes.status();
  bytes_ = std::make_shared<const std::string>(*std::move(bytes));
  warnings_ = std::move(scene->warnings);
  message_.set_world_uid(at->world->uid());
  message_.set_revision(snapshot.revision().value);
  message_.set_total_bytes(static_cast<std::int64_t>(bytes_->size()));
  return absl::OkStatus();
}

void ExportWorldCall::Complete(v1::ExportWorldResponse& message) {
  if (!message.done()) return;
  for (std::size_t i = 0; i < std::min(warnings_.size(), kMostWarnings); ++i) {
    message.add_warnings(warnings_[i]);
  }
  if (warnings_.size() > kMostWarnings) {
    message.add_warnings(absl::StrCat("and ", warnings_.size() - kMostWarnings, " more"));
  }
}

}  // namespace cwm::server
