// Reads the changes that clients request; declared in objects.h.
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/pair_rules.h"
#include "server/wire/poses.h"
#include "server/wire/robots.h"
#include "server/wire/shapes.h"

namespace cwm::server {
namespace {

// Steps of a WorkBudget that a change takes besides its geometry: a few microseconds.
constexpr std::size_t kStepsPerChange = 64;

// The sources from which changes are made.
struct ChangeSource {
  const Limits& limits;
  const GeometryStore& store;
  WorkBudget* budget;
};

absl::StatusOr<std::shared_ptr<const HybridModel>> ModelFromProto(const v1::Object& object,
                                                                  const ChangeSource& source,
                                                                  const FieldPath& path) {
  const int parts = object.shapes_size() + object.surfaces_size();
  if (parts == 0) return path.Field("shapes").Error("is empty, must hold a shape or surfaces one");
  if (parts > source.limits.max_parts) {
    return path.Field("shapes").Error(absl::StrCat(
        "and surfaces hold ", parts, " parts, must hold at most ", source.limits.max_parts));
  }
  auto model = std::make_shared<HybridModel>();
  model->shapes.reserve(static_cast<std::size_t>(object.shapes_size()));
  model->surfaces.reserve(static_cast<std::size_t>(object.surfaces_size()));
  for (int i = 0; i < object.shapes_size(); ++i) {
    auto part =
        ShapePartFromProto(object.shapes(i), source.store, path.Item("shapes", i), source.budget);
    if (!part.ok()) return part.status();
    model->shapes.push_back(*std::move(part));
  }
  for (int i = 0; i < object.surfaces_size(); ++i) {
    auto part = SurfacePartFromProto(object.surfaces(i), source.store, path.Item("surfaces", i),
                                     source.budget);
    if (!part.ok()) return part.status();
    model->surfaces.push_back(*std::move(part));
  }
  return model;
}

absl::StatusOr<collision::PutObject> PutObjectFromProto(const v1::Object& object,
                                                        const ChangeSource& source,
                                                        const FieldPath& path) {
  const Limits& limits = source.limits;
  collision::PutObject put;
  const auto bytes = static_cast<std::int64_t>(object.ByteSizeLong());
  if (bytes > limits.max_object_bytes) {
    return path.Error(absl::StrCat("has ", bytes, " bytes, must have at most ",
                                   limits.max_object_bytes,
                                   ": larger geometry travels by WriteGeometry"));
  }
  if (auto status = CheckName(object.name(), path.Field("name")); !status.ok()) return status;
  put.name = object.name();
  auto kind = ObjectKindFromProto(object.kind(), collision::ObjectKind::kUser, path.Field("kind"));
  if (!kind.ok()) return kind.status();
  put.kind = *kind;
  if (object.has_x_world_object()) {
    auto X_WO = PoseFromProto(object.x_world_object(), path.Field("x_world_object"));
    if (!X_WO.ok()) return X_WO.status();
    put.X_WO = *X_WO;
  }
  if (auto status = CheckLength(object.margin_m(), path.Field("margin_m")); !status.ok()) {
    return status;
  }
  put.margin_m = object.margin_m();
  if (!object.supported_by().empty()) {
    const FieldPath field = path.Field("supported_by");
    if (auto status = CheckName(object.supported_by(), field); !status.ok()) return status;
    put.supported_by = object.supported_by();
  }
  auto model = ModelFromProto(object, source, path);
  if (!model.ok()) return model.status();
  put.geometry = collision::Prepare(*std::move(model), source.budget);
  if (put.geometry == nullptr) return source.budget->status();
  return put;
}

absl::StatusOr<collision::MoveObject> MoveObjectFromProto(const v1::MoveObject& move,
                                                          const FieldPath& path) {
  if (auto status = CheckName(move.name(), path.Field("name")); !status.ok()) return status;
  const FieldPath pose_path = path.Field("x_world_object");
  if (!move.has_x_world_object()) return pose_path.Error("is absent, must be given");
  auto X_WO = PoseFromProto(move.x_world_object(), pose_path);
  if (!X_WO.ok()) return X_WO.status();
  return collision::MoveObject{.name = move.name(), .X_WO = *X_WO};
}

absl::StatusOr<collision::AttachObject> AttachObjectFromProto(const v1::AttachObject& attach,
                                                              const FieldPath& path) {
  if (auto status = CheckName(attach.name(), path.Field("name")); !status.ok()) return status;
  if (auto status = CheckName(attach.robot(), path.Field("robot")); !status.ok()) return status;
  collision::AttachObject result;
  result.name = attach.name();
  result.robot = attach.robot();
  result.link = attach.link();
  if (attach.has_x_link_object()) {
    auto X_LO = PoseFromProto(attach.x_link_object(), path.Field("x_link_object"));
    if (!X_LO.ok()) return X_LO.status();
    result.X_LO = *X_LO;
  }
  result.touch_links.assign(attach.touch_links().begin(), attach.touch_links().end());
  return result;
}

absl::StatusOr<collision::Change> ChangeFromProto(const v1::Change& change,
                                                  const ChangeSource& source,
                                                  const FieldPath& path) {
  collision::Change result;
  switch (change.what_case()) {
    case v1::Change::kPut: {
      const FieldPath put_path = path.Field("put");
      auto put = PutObjectFromProto(change.put().object(), source, put_path.Field("object"));
      if (!put.ok()) return put.status();
      result.what = *std::move(put);
      break;
    }
    case v1::Change::kMove: {
      auto move = MoveObjectFromProto(change.move(), path.Field("move"));
      if (!move.ok()) return move.status();
      result.what = *std::move(move);
      break;
    }
    case v1::Change::kRemove: {
      const FieldPath remove_path = path.Field("remove");
      auto status = CheckName(change.remove().name(), remove_path.Field("name"));
      if (!status.ok()) return status;
      result.what = collision::RemoveObject{change.remove().name()};
      break;
    }
    case v1::Change::kRobotState: {
      auto set = SetRobotStateFromProto(change.robot_state(), path.Field("robot_state"));
      if (!set.ok()) return set.status();
      result.what = *std::move(set);
      break;
    }
    case v1::Change::kAllow: {
      auto allow = AllowCollisionFromProto(change.allow(), path.Field("allow"));
      if (!allow.ok()) return allow.status();
      result.what = *std::move(allow);
      break;
    }
    case v1::Change::kMargin: {
      auto set = SetPairMarginFromProto(change.margin(), path.Field("margin"));
      if (!set.ok()) return set.status();
      result.what = *std::move(set);
      break;
    }
    case v1::Change::kAttach: {
      auto attach = AttachObjectFromProto(change.attach(), path.Field("attach"));
      if (!attach.ok()) return attach.status();
      result.what = *std::move(attach);
      break;
    }
    case v1::Change::kDetach: {
      const FieldPath detach_path = path.Field("detach");
      auto status = CheckName(change.detach().name(), detach_path.Field("name"));
      if (!status.ok()) return status;
      result.what = collision::DetachObject{change.detach().name()};
      break;
    }
    case v1::Change::WHAT_NOT_SET:
      return path.Field("what").Error(
          "is absent, must be one of put, move, remove, robot_state, allow, margin, attach, "
          "detach");
  }
  if (change.has_expected_object_revision()) {
    result.expected_object_revision = collision::Revision{change.expected_object_revision()};
  }
  return result;
}

}  // namespace

absl::StatusOr<std::vector<collision::Change>> ChangesFromProto(
    const google::protobuf::RepeatedPtrField<v1::Change>& changes, const Limits& limits,
    const GeometryStore& store, const FieldPath& path, std::string_view list, WorkBudget* budget) {
  const ChangeSource source{limits, store, budget};
  if (changes.empty()) return path.Field(list).Error("is empty, must hold a change");
  if (changes.size() > limits.max_changes) {
    return path.Field(list).Error(
        absl::StrCat("holds ", changes.size(), ", must hold at most ", limits.max_changes));
  }
  std::vector<collision::Change> result;
  result.reserve(changes.size());
  for (int i = 0; i < changes.size(); ++i) {
    if (MustEnd(budget, kStepsPerChange)) return budget->status();
    auto change = ChangeFromProto(changes[i], source, path.Item(list, i));
    if (!change.ok()) return change.status();
    result.push_back(*std::move(change));
  }
  return result;
}

}  // namespace cwm::server
