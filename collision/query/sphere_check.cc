#include "collision/query/sphere_check.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collision/query/body_search.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {

SphereCheck::SphereCheck(const JointRows& rows, SphereQuery query)
    : rows_(&rows),
      query_(std::make_shared<const SphereQuery>(std::move(query))),
      order_(*query_->program) {
  const RobotModel& model = rows.model();
  std::vector<double> base = rows.states().base;
  for (const int variable : rows.group().variables) {
    const Variable& of_row = model.variables[static_cast<std::size_t>(variable)];
    // Set within limits, so that only the base's other variables are tested.
    base[static_cast<std::size_t>(variable)] =
        std::isfinite(of_row.lower) ? of_row.lower : std::min(0.0, of_row.upper);
  }
  base_is_within_limits_ = !OutOfLimits(model, base).has_value();
}

std::optional<SphereCheck> SphereCheck::Make(const WorldSnapshot& world, const QueryBody& body,
                                             const BodyRows& rows, const QueryOptions& options) {
  const auto* joints = dynamic_cast<const JointRows*>(&rows);
  if (joints == nullptr) return std::nullopt;
  std::optional<SphereQuery> query = CompileQuery(world, body, *joints, rows.size(), options);
  if (!query) return std::nullopt;
  return SphereCheck(*joints, *std::move(query));
}

std::span<const Verdict> SphereCheck::Check(std::size_t first, std::size_t count) {
  const std::size_t width = rows_->group().variables.size();
  const std::size_t stride = (count + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
  values_.resize(query_->program->inputs.size() * stride);
  sorted_values_.resize(values_.size());
  marks_.resize(count);
  verdicts_.resize(count);
  LoadStates(query_->program->inputs, rows_->states().rows.data() + first * width, width, count,
             stride, values_.data(), marks_.data());
  const std::span<const std::uint32_t> order = order_.Sort(values_.data(), stride, count);
  for (std::size_t k = 0; k < query_->program->inputs.size(); ++k) {
    const float* from = values_.data() + k * stride;
    float* to = sorted_values_.data() + k * stride;
    for (std::size_t i = 0; i < count; ++i) to[i] = from[order[i]];
    std::fill(to + count, to + stride, 0.0F);
  }
  CheckLanes(stride, count, order);
  if (!base_is_within_limits_) std::ranges::fill(verdicts_, Verdict::kOutOfLimits);
  return verdicts_;
}

void SphereCheck::CheckLanes(std::size_t stride, std::size_t count,
                             std::span<const std::uint32_t> order) {
  lane_verdicts_.resize(count);
  found_.resize(count);
  open_.resize(count);
  CheckStates(query_->program->lanes, query_->scene, sorted_values_.data(), stride, count, memory_,
              lane_verdicts_.data(), found_.data());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t row = order[i];
    const LaneVerdict verdict = lane_verdicts_[i];
    open_[row] = found_[i];
    if (marks_[row] == StateMark::kOutOfLimits) {
      verdicts_[row] = Verdict::kOutOfLimits;
    } else if (marks_[row] == StateMark::kTooFar) {
      verdicts_[row] = Verdict::kUndecided;
      open_[row] = BodySearch::kAllUnresolved;
    } else {
      verdicts_[row] = verdict == LaneVerdict::kFree  ? Verdict::kFree
                       : verdict == LaneVerdict::kHit ? Verdict::kCollision
                                                      : Verdict::kUndecided;
    }
  }
}

}  // namespace cwm::collision
