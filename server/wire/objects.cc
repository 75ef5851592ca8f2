#include "server/wire/objects.h"

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/wire/poses.h"
#include "server/wire/shapes.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

// The box around all parts along the object's own axes; empty for an unbounded or empty object. A
// provisional object has no prepared parts, so its model is used.
std::optional<Placed<Box>> BoundsOf(const collision::PreparedModel& geometry) {
  Aabb bounds;
  for (const collision::PreparedPart& part : geometry.parts) bounds.extend(part.bounds_O);
  if (geometry.parts.empty() && geometry.model != nullptr) {
    bounds = TightBounds(*geometry.model, Pose::Identity());
  }
  if (bounds.isEmpty() || !bounds.sizes().allFinite()) return std::nullopt;
  return Placed<Box>{.X_FS = Pose(Eigen::Translation3d(bounds.center())),
                     .shape = {.size_m = bounds.sizes()}};
}

v1::Handle HandleToProto(const Handle& handle, GeometryStore& store) {
  v1::Handle proto;
  proto.set_shape_index(handle.shape_index);
  proto.set_point_count(handle.point_count);
  *proto.mutable_axis() = VectorToProto(handle.axis_O);
  *proto.mutable_bounds() = OrientedBoxToProto(handle.bounds);
  if (handle.surface.mesh != nullptr && !handle.surface.mesh->triangles.empty()) {
    proto.set_hash(store.RegisterMesh(handle.surface.mesh));
  }
  return proto;
}

v1::Attachment AttachmentToProto(const collision::Attachment& attachment) {
  v1::Attachment proto;
  proto.set_robot(attachment.robot);
  proto.set_link(attachment.link);
  *proto.mutable_x_link_object() = PoseToProto(attachment.X_LO);
  for (const std::string& link : attachment.touch_links) proto.add_touch_links(link);
  return proto;
}

void SetModel(const HybridModel& model, View view, GeometryStore& store, v1::Object* proto) {
  if (view == View::kBasic) return;
  for (const ShapePart& part : model.shapes) *proto->add_shapes() = ShapePartToProto(part, store);
  if (view == View::kShapes) return;
  for (const SurfacePart& part : model.surfaces)
    *proto->add_surfaces() = SurfacePartToProto(part, store);
  for (const Handle& handle : model.handles) *proto->add_handles() = HandleToProto(handle, store);
}

}  // namespace

v1::ObjectKind ObjectKindToProto(collision::ObjectKind kind) {
  switch (kind) {
    case collision::ObjectKind::kSupport:
      return v1::OBJECT_KIND_SUPPORT;
    case collision::ObjectKind::kObject:
      return v1::OBJECT_KIND_OBJECT;
    case collision::ObjectKind::kResidual:
      return v1::OBJECT_KIND_RESIDUAL;
    case collision::ObjectKind::kUnseen:
      return v1::OBJECT_KIND_UNSEEN;
    case collision::ObjectKind::kUser:
      return v1::OBJECT_KIND_USER;
    case collision::ObjectKind::kMover:
      return v1::OBJECT_KIND_MOVER;
  }
  return v1::OBJECT_KIND_UNSPECIFIED;
}

v1::Owner OwnerToProto(collision::Owner owner) {
  return owner == collision::Owner::kUser ? v1::OWNER_USER : v1::OWNER_PERCEPTION;
}

v1::ObjectState ObjectStateToProto(collision::ObjectState state) {
  switch (state) {
    case collision::ObjectState::kConfirmed:
      return v1::OBJECT_STATE_CONFIRMED;
    case collision::ObjectState::kOccluded:
      return v1::OBJECT_STATE_OCCLUDED;
    case collision::ObjectState::kLost:
      return v1::OBJECT_STATE_LOST;
  }
  return v1::OBJECT_STATE_UNSPECIFIED;
}

absl::StatusOr<collision::ObjectKind> ObjectKindFromProto(v1::ObjectKind kind,
                                                          collision::ObjectKind unspecified,
                                                          const FieldPath& path) {
  switch (kind) {
    case v1::OBJECT_KIND_UNSPECIFIED:
      return unspecified;
    case v1::OBJECT_KIND_SUPPORT:
      return collision::ObjectKind::kSupport;
    case v1::OBJECT_KIND_OBJECT:
      return collision::ObjectKind::kObject;
    case v1::OBJECT_KIND_RESIDUAL:
      return collision::ObjectKind::kResidual;
    case v1::OBJECT_KIND_UNSEEN:
      return collision::ObjectKind::kUnseen;
    case v1::OBJECT_KIND_USER:
      return collision::ObjectKind::kUser;
    case v1::OBJECT_KIND_MOVER:
      return collision::ObjectKind::kMover;
    default:
      return path.Error(
          absl::StrCat("is ", static_cast<int>(kind), ", must be a known ObjectKind"));
  }
}

absl::StatusOr<View> ViewFromProto(v1::ObjectView view, View unspecified, const FieldPath& path) {
  switch (view) {
    case v1::OBJECT_VIEW_UNSPECIFIED:
      return unspecified;
    case v1::OBJECT_VIEW_BASIC:
      return View::kBasic;
    case v1::OBJECT_VIEW_SHAPES:
      return View::kShapes;
    case v1::OBJECT_VIEW_FULL:
      return View::kFull;
    default:
      return path.Error(
          absl::StrCat("is ", static_cast<int>(view), ", must be a known ObjectView"));
  }
}

v1::SensorFacts SensorFactsToProto(const SensorFacts& facts) {
  v1::SensorFacts proto;
  switch (facts.motion) {
    case SensorFacts::Motion::kAtRest:
      proto.set_motion(v1::MOTION_AT_REST);
      break;
    case SensorFacts::Motion::kMoving:
      proto.set_motion(v1::MOTION_MOVING);
      break;
    case SensorFacts::Motion::kSettling:
      proto.set_motion(v1::MOTION_SETTLING);
      break;
  }
  switch (facts.visibility) {
    case SensorFacts::Visibility::kVisible:
      proto.set_visibility(v1::VISIBILITY_VISIBLE);
      break;
    case SensorFacts::Visibility::kOccluded:
      proto.set_visibility(v1::VISIBILITY_OCCLUDED);
      break;
    case SensorFacts::Visibility::kStale:
      proto.set_visibility(v1::VISIBILITY_STALE);
      break;
    case SensorFacts::Visibility::kLost:
      proto.set_visibility(v1::VISIBILITY_LOST);
      break;
  }
  proto.set_identity_certain(facts.identity_certain);
  proto.set_carried_by(facts.carried_by);
  return proto;
}

v1::Object ObjectToProto(const collision::WorldObject& object, View view,
                         const Observation& observation, GeometryStore& store) {
  v1::Object proto;
  proto.set_name(object.name);
  proto.set_uid(object.Uid());
  proto.set_kind(ObjectKindToProto(object.kind));
  proto.set_owner(OwnerToProto(object.owner));
  proto.set_state(ObjectStateToProto(object.state));
  *proto.mutable_x_world_object() = PoseToProto(object.X_WO);
  proto.set_supported_by(object.supported_by);
  if (const collision::Attachment* by = object.attachment.get()) {
    proto.set_attached_to(absl::StrCat(by->robot, "/", by->link));
    *proto.mutable_attachment() = AttachmentToProto(*by);
  }
  proto.set_margin_m(object.margin_m);
  proto.set_create_revision(object.create_revision.value);
  proto.set_geometry_revision(object.geometry_revision.value);
  proto.set_pose_revision(object.pose_revision.value);
  if (observation.last.has_value())
    *proto.mutable_last_observed() = TimePointToProto(*observation.last);
  if (observation.reachable.has_value()) proto.set_reachable(*observation.reachable);
  if (observation.facts.has_value()) {
    const v1::SensorFacts facts = SensorFactsToProto(*observation.facts);
    proto.set_motion(facts.motion());
    proto.set_visibility(facts.visibility());
    proto.set_identity_certain(facts.identity_certain());
    proto.set_carried_by(facts.carried_by());
  }
  if (object.geometry != nullptr) {
    proto.set_point_count(object.model().point_count);
    if (const auto bounds = BoundsOf(*object.geometry))
      *proto.mutable_bounds() = OrientedBoxToProto(*bounds);
    SetModel(object.model(), view, store, &proto);
  }
  return proto;
}

absl::Status CheckName(const std::string& name, const FieldPath& path) {
  if (collision::IsValidName(name)) return absl::OkStatus();
  constexpr std::size_t kShownBytes = 40;
  return path.Error(absl::StrCat("is \"", absl::CHexEscape(name.substr(0, kShownBytes)),
                                 "\", must be 1 to 128 letters, digits and _-./"));
}

}  // namespace cwm::server
