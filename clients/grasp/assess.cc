#include "clients/grasp/assess.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "clients/cpp/row_bytes.h"

namespace cwm::grasp {
namespace {

namespace pb = cwm::v1;
using client::PoseRow;
using client::RayRow;
using Eigen::Isometry3d;
using Eigen::Vector3d;

// chosen: attempts per call with a row or two each; far below the server's limit of rows (65 536),
// and answered quickly.
constexpr std::size_t kAttemptsPerBatch = 4096;

// Places on a pad, as shares of its half width and half length: the middle first, then outwards.
constexpr std::array<std::array<double, 2>, 15> kPadPoints = {{{0, 0},
                                                               {0, 0.4},
                                                               {0, -0.4},
                                                               {0.8, 0},
                                                               {-0.8, 0},
                                                               {0, 0.8},
                                                               {0, -0.8},
                                                               {0.8, 0.4},
                                                               {0.8, -0.4},
                                                               {-0.8, 0.4},
                                                               {-0.8, -0.4},
                                                               {0.8, 0.8},
                                                               {0.8, -0.8},
                                                               {-0.8, 0.8},
                                                               {-0.8, -0.8}}};
constexpr std::size_t kRaysPerAttempt = 2 * kPadPoints.size();
// chosen: attempts per call with all rays of each.
constexpr std::size_t kRayAttemptsPerBatch = 8 * kAttemptsPerBatch / kRaysPerAttempt;

template <class T>
T At(const std::string& column, std::size_t index) {
  T value{};
  std::memcpy(&value, column.data() + index * sizeof(T), sizeof(T));
  return value;
}

PoseRow RowOf(const Isometry3d& X) {
  const Eigen::Quaterniond q(X.linear());
  const Vector3d p = X.translation();
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

void AddBox(const GripperBox& box, pb::Subject::Shapes& shapes) {
  pb::PlacedShape& placed = *shapes.add_shapes();
  pb::Pose& pose = *placed.mutable_x_body_shape();
  pose.set_tx_m(box.centre_G.x());
  pose.set_ty_m(box.centre_G.y());
  pose.set_tz_m(box.centre_G.z());
  pose.set_qw(1);
  placed.mutable_box()->set_size_x_m(box.size_m.x());
  placed.mutable_box()->set_size_y_m(box.size_m.y());
  placed.mutable_box()->set_size_z_m(box.size_m.z());
}

void RecordVerdict(const pb::CheckCollisionsResponse& response, std::size_t row,
                   Assessment& answer) {
  if (response.verdicts()[row] == pb::VERDICT_FREE) return;
  answer.failure = GraspFailure::kBlocked;
  if (response.verdicts()[row] != pb::VERDICT_COLLISION) return;
  const auto object = At<std::int32_t>(response.object_index(), row);
  if (object >= 0) answer.obstacle = response.objects(object).name();
}

// The place of a pad that touches something first; of places within a micrometre, the first in the
// list. The ray of the middle must have hit.
std::size_t FirstHit(const pb::CastRaysResponse& response, std::size_t middle) {
  constexpr double kSame_m = 1e-6;
  std::size_t first = middle;
  for (std::size_t row = middle + 1; row < middle + kPadPoints.size(); ++row) {
    if (response.hit()[row] == 0) continue;
    const double sooner_m =
        At<double>(response.distance_m(), first) - At<double>(response.distance_m(), row);
    if (sooner_m > kSame_m) first = row;
  }
  return first;
}

// Indices of the attempts that are still worth a query.
using Indices = std::vector<std::size_t>;

// Calls `evaluate` for some attempts at a time until a call fails.
template <class Function>
absl::Status InBatches(const Indices& indices, const Function& evaluate) {
  for (std::size_t begin = 0; begin < indices.size(); begin += kAttemptsPerBatch) {
    const std::size_t end = std::min(begin + kAttemptsPerBatch, indices.size());
    const absl::Status status =
        evaluate(Indices(indices.begin() + static_cast<std::ptrdiff_t>(begin),
                         indices.begin() + static_cast<std::ptrdiff_t>(end)));
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

class Assessor {
 public:
  Assessor(const client::Connection& connection, const GraspQuery& query,
           const std::vector<Attempt>& attempts)
      : connection_(connection), query_(query), attempts_(attempts), answers_(attempts.size()) {}

  // Checks that the open gripper has room at the grasp: the cheapest query, which most attempts
  // fail.
  absl::Status CheckGraspPoses();
  absl::Status CheckApproaches();
  absl::Status CheckClosing();
  absl::Status CastContactRays();
  std::vector<Assessment> Take() { return std::move(answers_); }

 private:
  Indices Remaining() const {
    Indices remaining;
    for (std::size_t i = 0; i < answers_.size(); ++i) {
      if (answers_[i].failure == GraspFailure::kNone) remaining.push_back(i);
    }
    return remaining;
  }

  template <class Request>
  Request NewRequest() const {
    Request request;
    request.set_world(query_.world);
    request.mutable_options()->set_world_uid(query_.world_uid);
    request.mutable_options()->mutable_at_revision()->set_exact(query_.revision);
    return request;
  }

  absl::Status CheckApproaches(const Indices& indices);
  absl::Status CheckClosing(const std::string& target, const Indices& indices);
  void ReadContacts(const pb::CastRaysResponse& response, std::size_t first_row, std::size_t i);

  const client::Connection& connection_;
  const GraspQuery& query_;
  const std::vector<Attempt>& attempts_;
  std::vector<Assessment> answers_;
};

absl::Status Assessor::CheckGraspPoses() {
  for (std::size_t begin = 0; begin < attempts_.size(); begin += kAttemptsPerBatch) {
    const std::size_t end = std::min(begin + kAttemptsPerBatch, attempts_.size());
    auto request = NewRequest<pb::CheckCollisionsRequest>();
    request.mutable_options()->set_margin_m(query_.clearance_m);
    pb::Subject::Shapes& shapes = *request.mutable_subject()->mutable_shapes();
    for (const GripperBox& box : OpenBoxes(query_.gripper)) AddBox(box, shapes);
    std::vector<PoseRow> rows;
    for (std::size_t i = begin; i < end; ++i) rows.push_back(RowOf(attempts_[i].X_WG));
    shapes.mutable_x_world_body()->set_data(client::RowBytes(rows));
    const auto response =
        connection_.Call(&pb::QueryService::Stub::CheckCollisions, connection_.queries(), request);
    if (!response.ok()) return response.status();
    for (std::size_t i = begin; i < end; ++i) RecordVerdict(*response, i - begin, answers_[i]);
  }
  return absl::OkStatus();
}

absl::Status Assessor::CheckApproaches() {
  return InBatches(Remaining(), [this](const Indices& batch) { return CheckApproaches(batch); });
}

absl::Status Assessor::CheckApproaches(const Indices& indices) {
  auto request = NewRequest<pb::CheckMotionsRequest>();
  request.mutable_options()->set_margin_m(query_.clearance_m);
  pb::Subject::Shapes& shapes = *request.mutable_subject()->mutable_shapes();
  for (const GripperBox& box : OpenBoxes(query_.gripper)) AddBox(box, shapes);
  std::vector<PoseRow> rows;
  for (const std::size_t i : indices) {
    const Isometry3d& X_WG = attempts_[i].X_WG;
    rows.push_back(RowOf(X_WG * Eigen::Translation3d(0, 0, -query_.approach_m)));
    rows.push_back(RowOf(X_WG));
  }
  shapes.mutable_x_world_body()->set_data(client::RowBytes(rows));
  const auto response =
      connection_.Call(&pb::QueryService::Stub::CheckMotions, connection_.queries(), request);
  if (!response.ok()) return response.status();
  for (std::size_t row = 0; row < indices.size(); ++row) {
    Assessment& answer = answers_[indices[row]];
    if (response->verdicts()[row] == pb::MOTION_VERDICT_FREE) {
      answer.clearance_m = query_.clearance_m + At<double>(response->clearance_m(), row);
      continue;
    }
    answer.failure = GraspFailure::kBlocked;
    const auto object = At<std::int32_t>(response->object_index(), row);
    if (object >= 0) answer.obstacle = response->objects(object).name();
  }
  return absl::OkStatus();
}

absl::Status Assessor::CheckClosing() {
  std::map<std::string, Indices> by_target;
  for (const std::size_t i : Remaining()) {
    if (!attempts_[i].target.empty()) by_target[attempts_[i].target].push_back(i);
  }
  for (const auto& [target, indices] : by_target) {
    const absl::Status status = InBatches(indices, [this, &name = target](const Indices& batch) {
      return CheckClosing(name, batch);
    });
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

absl::Status Assessor::CheckClosing(const std::string& target, const Indices& indices) {
  auto request = NewRequest<pb::CheckCollisionsRequest>();
  request.mutable_options()->add_ignore(target);
  pb::Subject::Shapes& shapes = *request.mutable_subject()->mutable_shapes();
  AddBox(ClosingBox(query_.gripper), shapes);
  std::vector<PoseRow> rows;
  for (const std::size_t i : indices) rows.push_back(RowOf(attempts_[i].X_WG));
  shapes.mutable_x_world_body()->set_data(client::RowBytes(rows));
  const auto response =
      connection_.Call(&pb::QueryService::Stub::CheckCollisions, connection_.queries(), request);
  if (!response.ok()) return response.status();
  for (std::size_t row = 0; row < indices.size(); ++row) {
    RecordVerdict(*response, row, answers_[indices[row]]);
  }
  return absl::OkStatus();
}

absl::Status Assessor::CastContactRays() {
  const Indices remaining = Remaining();
  for (std::size_t begin = 0; begin < remaining.size(); begin += kRayAttemptsPerBatch) {
    const std::size_t end = std::min(begin + kRayAttemptsPerBatch, remaining.size());
    std::vector<RayRow> rays;
    for (std::size_t g = begin; g < end; ++g) {
      const Isometry3d& X_WG = attempts_[remaining[g]].X_WG;
      for (const double side : {-1.0, 1.0}) {
        for (const auto& [y, z] : kPadPoints) {
          const Vector3d from = X_WG * Vector3d(side * query_.gripper.opening_m / 2,
                                                y * query_.gripper.finger_width_m / 2,
                                                z * query_.gripper.pad_length_m / 2);
          const Vector3d to = -side * X_WG.linear().col(0);
          rays.push_back({from.x(), from.y(), from.z(), to.x(), to.y(), to.z()});
        }
      }
    }
    auto request = NewRequest<pb::CastRaysRequest>();
    request.mutable_rays()->set_data(client::RowBytes(rays));
    request.mutable_options()->set_max_distance_m(query_.gripper.opening_m);
    const auto response =
        connection_.Call(&pb::QueryService::Stub::CastRays, connection_.queries(), request);
    if (!response.ok()) return response.status();
    for (std::size_t g = begin; g < end; ++g) {
      ReadContacts(*response, (g - begin) * kRaysPerAttempt, remaining[g]);
    }
  }
  return absl::OkStatus();
}

void Assessor::ReadContacts(const pb::CastRaysResponse& response, std::size_t first_row,
                            std::size_t i) {
  Assessment& answer = answers_[i];
  const Vector3d closing_W = attempts_[i].X_WG.linear().col(0);
  std::array<double, 2> travel_m = {};  // the travel of each finger until its pad touches something
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t middle = first_row + side * kPadPoints.size();
    if (response.hit()[middle] == 0) {
      answer.failure = GraspFailure::kMissed;
      return;
    }
    const std::size_t first = FirstHit(response, middle);
    const std::string touched =
        response.objects(At<std::int32_t>(response.object_index(), first)).name();
    if (answer.held_object.empty()) answer.held_object = touched;
    const std::string& wanted =
        attempts_[i].target.empty() ? answer.held_object : attempts_[i].target;
    if (touched != wanted) {
      answer.failure = GraspFailure::kMissed;
      answer.obstacle = touched;
      return;
    }
    travel_m[side] = At<double>(response.distance_m(), first);
    const auto& [y, z] = kPadPoints[first - middle];
    const double direction = side == 0 ? 1 : -1;
    Contact& contact = answer.contacts[side];
    contact.point_W =
        attempts_[i].X_WG * Vector3d(direction * (travel_m[side] - query_.gripper.opening_m / 2),
                                     y * query_.gripper.finger_width_m / 2,
                                     z * query_.gripper.pad_length_m / 2);
    contact.normal_W = {At<double>(response.normal(), 3 * first),
                        At<double>(response.normal(), 3 * first + 1),
                        At<double>(response.normal(), 3 * first + 2)};
    contact.angle_rad =
        std::acos(std::clamp(-contact.normal_W.dot(direction * closing_W), -1.0, 1.0));
    contact.part = At<std::int32_t>(response.object_part(), first);
  }
  answer.width_m = query_.gripper.opening_m - travel_m[0] - travel_m[1];
  answer.off_centre_m = std::abs(travel_m[0] - travel_m[1]) / 2;
  const double steepest = std::max(answer.contacts[0].angle_rad, answer.contacts[1].angle_rad);
  if (answer.width_m <= 0) {
    answer.failure = GraspFailure::kMissed;
  } else if (steepest > std::atan(query_.friction)) {
    answer.failure = GraspFailure::kSlipped;
  }
}

}  // namespace

absl::StatusOr<std::vector<Assessment>> Assess(const client::Connection& connection,
                                               const GraspQuery& query,
                                               const std::vector<Attempt>& attempts) {
  Assessor assessor(connection, query, attempts);
  if (absl::Status status = assessor.CheckGraspPoses(); !status.ok()) return status;
  if (absl::Status status = assessor.CheckApproaches(); !status.ok()) return status;
  if (absl::Status status = assessor.CheckClosing(); !status.ok()) return status;
  if (absl::Status status = assessor.CastContactRays(); !status.ok()) return status;
  return assessor.Take();
}

}  // namespace cwm::grasp
