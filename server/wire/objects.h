// Converts world objects for replies and events, and reads the changes that clients request.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/world/world_object.h"
#include "collision/world/world_snapshot.h"
#include "cwm/v1/world.pb.h"
#include "server/core/geometry_store.h"
#include "server/core/limits.h"
#include "server/core/world.h"
#include "server/wire/field_path.h"

namespace cwm::server {

v1::ObjectKind ObjectKindToProto(collision::ObjectKind kind);
v1::Owner OwnerToProto(collision::Owner owner);
v1::ObjectState ObjectStateToProto(collision::ObjectState state);
// `unspecified` is the meaning of the zero value.
absl::StatusOr<collision::ObjectKind> ObjectKindFromProto(v1::ObjectKind kind,
                                                          collision::ObjectKind unspecified,
                                                          const FieldPath& path);

// The facts of running sensors about an object.
v1::SensorFacts SensorFactsToProto(const SensorFacts& facts);

enum class View { kBasic, kShapes, kFull };
absl::StatusOr<View> ViewFromProto(v1::ObjectView view, View unspecified, const FieldPath& path);

// Observations belong to the world, not to the object. Bounds are in the object's frame.
v1::Object ObjectToProto(const collision::WorldObject& object, View view,
                         const Observation& observation, GeometryStore& store);

// Reads all changes and prepares their geometry for every engine (heavy, so no lock may be held).
// At least one, at most limits.max_changes. `list` is the field below `path` that holds them. The
// status of the budget if it ended.
absl::StatusOr<std::vector<collision::Change>> ChangesFromProto(
    const google::protobuf::RepeatedPtrField<v1::Change>& changes, const Limits& limits,
    const GeometryStore& store, const FieldPath& path, std::string_view list = "changes",
    WorkBudget* budget = nullptr);

// Checks the rule for names of objects, see collision::IsValidName.
absl::Status CheckName(const std::string& name, const FieldPath& path);

}  // namespace cwm::server
