#include "server/rpc/export_call.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/load_robot.h"
#include "server/export/drawn_world.h"
#include "server/export/moveit_scene.h"
#include "server/export/simulator_model.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/status_conversion.h"
#include "server/wire/objects.h"
#include "server/wire/queries.h"

namespace cwm::server {
namespace {

// chosen: as many as fit into one message with room to spare; a scene has some tens.
constexpr std::size_t kMaxWarnings = 1'000;

// derived: a closed mesh with so many triangles has about 55 MB as text; `cwm import` reads files
// of up to 64 MiB.
constexpr std::int64_t kMaxTriangles = 1'000'000;

std::int64_t MaxTriangles(const Runtime& runtime) {
  return std::min(kMaxTriangles, runtime.application.limits.max_mesh_triangles);
}

absl::Status CheckCancelled(const CallContext& call) {
  if (call.stop.stop_requested()) return CallCancelled();
  if (Clock::now() < call.deadline) return absl::OkStatus();
  return MakeError(absl::StatusCode::kDeadlineExceeded,
                   "the deadline was reached before the text was made",
                   {.reason = "TIME_BUDGET_SPENT"});
}

// An estimate: while a file is made, it takes about as much memory as the objects in it.
std::int64_t FileBytesOf(const collision::WorldSnapshot& snapshot) {
  std::int64_t bytes = 0;
  for (const collision::WorldObjectPtr& object : snapshot.objects()) {
    bytes += ApproximateBytes(*object);
  }
  return bytes;
}

absl::Status CheckFormat(v1::ExportFormat format) {
  if (v1::ExportFormat_IsValid(format)) return absl::OkStatus();
  return FieldPath::OfRequest("format").Error(
      absl::StrCat("is ", static_cast<int>(format), ", must be a known ExportFormat"));
}

// The robot with that name; without a name the only robot, or nullptr if there is none.
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
                                 const grpc::ByteBuffer* request)
    : ChunkedRead(context, runtime, runtime.batches),
      quota_share_(QuotaShare::TryTake(runtime.streams, runtime.ClientOf(*context))) {
  if (const absl::Status parsed = ReadRequest(request, &request_); !parsed.ok()) {
    Start(parsed);
  } else if (!quota_share_) {
    Start(Overloaded("too many streams are open", "TOO_MANY_STREAMS"));
  } else {
    Start(FindRevisionToAwait(runtime, request_.world(), request_.world_uid(),
                              request_.at_revision()));
  }
}

absl::Status ExportWorldCall::Prepare(const CallContext& call) {
  if (absl::Status known = CheckFormat(request_.format()); !known.ok()) return known;
  const FieldPath root;
  const auto rule = RevisionRuleFromProto(request_.at_revision(), root.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  const auto at = FindWorldAt(runtime_, request_.world(), request_.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  // Pins the revision, so that a file made again is the same.
  request_.set_world_uid(at->world->uid());
  request_.mutable_at_revision()->set_exact(at->snapshot->revision().value);
  const CancellationCheck check_cancelled = [&call] { return CheckCancelled(call); };
  const bool is_yaml = request_.format() == v1::EXPORT_FORMAT_MOVEIT_YAML;
  if (is_yaml && !request_.robot().empty()) {
    if (auto status = CheckName(request_.robot(), root.Field("robot")); !status.ok()) return status;
  }
  const std::string key =
      absl::StrCat(at->world->uid(), " ", at->snapshot->revision().value, " ",
                   static_cast<int>(request_.format()), " ", is_yaml ? request_.robot() : "");
  file_ = runtime_.exports.Find(key);
  if (file_ == nullptr) {
    auto charge = runtime_.application.memory->Charge(MemoryBudget::Client(call.client),
                                                      FileBytesOf(*at->snapshot));
    if (!charge.ok()) return charge.status();
    const absl::Status formatted = Format(*at->snapshot, at->world->name(), check_cancelled);
    if (!formatted.ok()) return formatted;
    auto file = std::make_shared<ExportedWorld>();
    file->bytes = std::move(text_);
    file->warnings = std::move(warnings_);
    file->files = std::move(named_);
    charge->ForceResize(static_cast<std::int64_t>(file->bytes.size()));
    file->charge = *std::move(charge);
    file_ = runtime_.exports.Keep(key, std::move(file));
  }
  bytes_ = {file_, &file_->bytes};
  message_.clear_files();
  for (const ExportedWorld::Part& part : file_->files) {
    v1::ExportedFile& listed = *message_.add_files();
    listed.set_name(part.name);
    listed.set_byte_count(part.byte_count);
  }
  message_.set_world_uid(at->world->uid());
  message_.set_revision(at->snapshot->revision().value);
  message_.set_total_bytes(static_cast<std::int64_t>(bytes_->size()));
  return absl::OkStatus();
}

void ExportWorldCall::ReleaseBytes() {
  bytes_.reset();
  file_.reset();
}

absl::Status ExportWorldCall::Format(const collision::WorldSnapshot& snapshot,
                                     const std::string& world,
                                     const CancellationCheck& check_cancelled) {
  const v1::ExportFormat format = request_.format();
  if (format == v1::EXPORT_FORMAT_GLB || format == v1::EXPORT_FORMAT_PLY) {
    return FormatDrawing(snapshot, world, check_cancelled);
  }
  auto scene = MakePlanningScene(snapshot, MaxTriangles(runtime_), check_cancelled);
  if (!scene.ok()) return scene.status();
  scene->name = world;
  if (format != v1::EXPORT_FORMAT_URDF && format != v1::EXPORT_FORMAT_SDF) {
    return FormatScene(snapshot, *std::move(scene), check_cancelled);
  }
  if (!snapshot.robots().empty()) {
    scene->warnings.emplace_back("robots: left out, they have descriptions of their own");
  }
  return FormatModel(*std::move(scene), check_cancelled);
}

absl::Status ExportWorldCall::FormatScene(const collision::WorldSnapshot& snapshot,
                                          PlanningScene scene,
                                          const CancellationCheck& check_cancelled) {
  const bool is_yaml = request_.format() == v1::EXPORT_FORMAT_MOVEIT_YAML;
  if (is_yaml) {
    const auto robot = RobotOf(snapshot, request_.robot());
    if (!robot.ok()) return robot.status();
    const absl::Status added = AddRobotAndRules(snapshot, robot->get(), scene, check_cancelled);
    if (!added.ok()) return added;
  } else {
    RemoveAttached(scene);
    if (!snapshot.robots().empty() || !snapshot.pair_rules().empty()) {
      scene.warnings.emplace_back(
          "robots and rules of pairs: left out, the format has objects alone");
    }
  }
  auto bytes =
      is_yaml ? FormatSceneYaml(scene, check_cancelled) : FormatSceneText(scene, check_cancelled);
  if (!bytes.ok()) return bytes.status();
  text_ = *std::move(bytes);
  warnings_ = std::move(scene.warnings);
  return absl::OkStatus();
}

absl::Status ExportWorldCall::FormatDrawing(const collision::WorldSnapshot& snapshot,
                                            const std::string& world,
                                            const CancellationCheck& check_cancelled) {
  auto drawn = DrawWorld(snapshot, MaxTriangles(runtime_), check_cancelled);
  if (!drawn.ok()) return drawn.status();
  drawn->name = world;
  const bool is_glb = request_.format() == v1::EXPORT_FORMAT_GLB;
  auto bytes = is_glb ? FormatGlb(*drawn, check_cancelled) : FormatPly(*drawn, check_cancelled);
  if (!bytes.ok()) return bytes.status();
  text_ = *std::move(bytes);
  warnings_ = std::move(drawn->warnings);
  return absl::OkStatus();
}

absl::Status ExportWorldCall::FormatModel(PlanningScene scene,
                                          const CancellationCheck& check_cancelled) {
  const bool is_urdf = request_.format() == v1::EXPORT_FORMAT_URDF;
  const std::int64_t max_triangles = MaxTriangles(runtime_);
  auto model = is_urdf ? FormatUrdf(std::move(scene), max_triangles, check_cancelled)
                       : FormatSdf(std::move(scene), max_triangles, check_cancelled);
  if (!model.ok()) return model.status();
  std::string bytes;
  for (const NamedFile& file : model->files) {
    bytes += file.bytes;
    if (model->files.size() == 1) break;
    named_.push_back({file.name, static_cast<std::int64_t>(file.bytes.size())});
  }
  text_ = std::move(bytes);
  warnings_ = std::move(model->warnings);
  return absl::OkStatus();
}

void ExportWorldCall::Complete(v1::ExportWorldResponse& message) {
  if (message.offset() > 0) message.clear_files();
  if (!message.done()) return;
  for (std::size_t i = 0; i < std::min(file_->warnings.size(), kMaxWarnings); ++i) {
    message.add_warnings(file_->warnings[i]);
  }
  if (file_->warnings.size() > kMaxWarnings) {
    message.add_warnings(absl::StrCat("and ", file_->warnings.size() - kMaxWarnings, " more"));
  }
}

}  // namespace cwm::server
