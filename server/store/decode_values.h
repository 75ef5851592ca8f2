// Reads messages of a store as values. Nothing is trusted: what clients may not send is refused, as
// DataLoss with the field and the rule (decode_fault.h), and no bytes can crash a reader.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/store/v1/record.pb.h"
#include "server/core/journal.h"

namespace cwm::server {

// Both clocks at one moment. They convert times of the store.
struct ClockPair {
  Clock::time_point steady = Clock::now();
  collision::WallTime wall = std::chrono::system_clock::now();
};
// The past moment on the steady clock; at most now, if the wall clock was set back.
Clock::time_point SteadyTimeOf(std::int64_t when_ns, const ClockPair& now);
collision::WallTime WallTimeOf(std::int64_t when_ns);

absl::StatusOr<Pose> DecodePose(const store::v1::Pose& pose);

// The content of a mesh, inline or a blob. The errors of Store::GetBlob; DataLoss for bytes that
// are no mesh.
using MeshContents =
    std::function<absl::StatusOr<std::shared_ptr<const TriangleMesh>>(const store::v1::Mesh& mesh)>;
// Checks the size of the bytes, not what they say.
absl::StatusOr<std::shared_ptr<const TriangleMesh>> DecodeContent(std::string_view mesh_f64);
absl::StatusOr<std::shared_ptr<const HybridModel>> DecodeModel(const store::v1::Model& model,
                                                               const MeshContents& contents);

// The object without its geometry, not placed.
absl::StatusOr<collision::WorldObject> DecodeObject(const store::v1::Object& object);
// The robot without its geometry, not placed.
absl::StatusOr<collision::WorldRobot> DecodeRobot(const store::v1::Robot& robot);
// An allowance whose end is past is due at once.
absl::StatusOr<collision::PairRule> DecodeRule(const store::v1::PairRule& rule,
                                               const ClockPair& now);
absl::StatusOr<NamedSensorPose> DecodeSensorPose(const store::v1::SensorPose& pose);
Sighting DecodeSighting(const store::v1::Sighting& sighting);
WrittenRequest DecodeRequest(const store::v1::Request& request);

}  // namespace cwm::server
