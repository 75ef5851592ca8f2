#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "cwm/internal/columns.h"
#include "cwm/internal/query_batches.h"
#include "cwm/world.h"

namespace cwm::CWM_API {
namespace {

using internal::Batches;
using internal::BoundSubject;
using internal::Columns;
using internal::kManyLinks;
using internal::kPoseWidth;

}  // namespace

PoseResult WorldView::Solve(const RobotSubject& robot, std::span<const Eigen::Isometry3d> X_WT,
                            const SolveOptions& options) const {
  using Reply = v1::SolvePosesResponse;
  const BoundSubject seeds = internal::Bind(robot, options.seeds, "options.seeds");
  const Batches& states = seeds.batches;
  const auto pose_count = static_cast<std::int64_t>(X_WT.size());
  if (!states.numbers.empty() && states.row_count() != 1 && states.row_count() != pose_count) {
    internal::ThrowBadArgument(
        "options.seeds", absl::StrCat("are ", states.row_count(), ", must be 1 or one for each of ",
                                      pose_count, " poses"));
  }
  std::vector<double> numbers;
  numbers.reserve(kPoseWidth * X_WT.size());
  for (std::size_t i = 0; i < X_WT.size(); ++i) {
    const auto row = internal::PoseNumbers(X_WT[i], absl::StrCat("X_WT[", i, "]"));
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  Batches batches = internal::BatchesOfRows(std::move(numbers), kPoseWidth);
  batches.answers_per_unit = std::max(1, options.max_solutions);

  v1::SolvePosesRequest common;
  *common.mutable_robot() = seeds.message.robot();
  common.set_tool(options.tool);
  common.set_tool_link(options.tool_link);
  if (options.X_LT) {
    *common.mutable_x_link_tool() = internal::ToMessage(*options.X_LT, "options.X_LT");
  }
  common.set_position_tolerance_m(options.position_tolerance_m);
  common.set_rotation_tolerance_rad(options.rotation_tolerance_rad);
  common.set_max_solutions(options.max_solutions);
  common.set_same_branch(options.same_branch);
  common.set_avoid_collision(options.avoid_collision);
  common.set_max_steps(options.max_steps);
  const auto replies = internal::Evaluate<v1::SolvePosesRequest>(
      view(), options.query, {}, batches,
      [&](v1::SolvePosesRequest& request, std::int64_t first, std::int64_t end) {
        request.MergeFrom(common);
        request.mutable_x_world_tool()->set_data(batches.Bytes(first, end));
        if (states.numbers.empty()) return;
        request.mutable_robot()->mutable_rows()->set_data(
            states.row_count() == 1 ? states.Bytes(0, 1) : states.Bytes(first, end));
      });

  PoseResult result;
  result.row_count = static_cast<Eigen::Index>(pose_count);
  if (replies.empty()) return result;
  const Reply& first = replies.front();
  result.world_uid = first.world_uid();
  result.revision = first.revision();
  result.variables.assign(first.variables().begin(), first.variables().end());
  result.tool_link = first.tool_link();
  for (const Reply& reply : replies) {
    result.completed_count += static_cast<Eigen::Index>(reply.completed_count());
  }
  result.status = internal::ColumnsOfRows(replies).Bytes<PoseStatus>(
      [](const Reply& r) -> auto& { return r.status(); });
  result.row_begin = internal::JoinRowBegins(
      replies, [](const Reply& r) -> auto& { return r.row_begin(); });
  const Columns<Reply> columns(replies,
                               [](const Reply& r) { return internal::LastBegin(r.row_begin()); });
  result.states = columns.Matrix(
      [](const Reply& r) -> auto& { return r.joints().data(); },
      static_cast<Eigen::Index>(result.variables.size()));
  result.position_error_m =
      columns.Doubles([](const Reply& r) -> auto& { return r.position_error_m(); });
  result.rotation_error_rad =
      columns.Doubles([](const Reply& r) -> auto& { return r.rotation_error_rad(); });
  return result;
}

LinkPoses WorldView::PosesOfLinks(const RobotSubject& robot, const Rows& states,
                                  std::vector<std::string> links,
                                  const QueryOptions& options) const {
  using Reply = v1::GetLinkPosesResponse;
  BoundSubject bound = internal::Bind(robot, states, "states");
  bound.batches.answers_per_unit =
      links.empty() ? kManyLinks : static_cast<std::int64_t>(links.size());
  const auto replies = internal::Evaluate<v1::GetLinkPosesRequest>(
      view(), options, {}, bound.batches,
      [&](v1::GetLinkPosesRequest& request, std::int64_t first, std::int64_t end) {
        v1::Subject subject;
        bound.Fill(first, end, subject);
        request.mutable_robot()->Swap(subject.mutable_robot());
        request.mutable_links()->Assign(links.begin(), links.end());
      });
  LinkPoses result;
  result.row_count = static_cast<Eigen::Index>(bound.batches.unit_count());
  if (replies.empty()) return result;
  result.world_uid = replies.front().world_uid();
  result.revision = replies.front().revision();
  result.links.assign(replies.front().links().begin(), replies.front().links().end());
  const auto link_count = static_cast<std::int64_t>(result.links.size());
  const Columns<Reply> columns(replies,
                               [&](const Reply& r) { return r.completed_count() * link_count; });
  const Eigen::MatrixXd poses = columns.Matrix(
      [](const Reply& r) -> auto& { return r.x_world_link().data(); },
      static_cast<Eigen::Index>(kPoseWidth));
  for (const Reply& reply : replies) {
    result.completed_count += static_cast<Eigen::Index>(reply.completed_count());
  }
  result.X_WL.reserve(static_cast<std::size_t>(poses.cols()));
  for (Eigen::Index i = 0; i < poses.cols(); ++i) {
    result.X_WL.push_back(internal::PoseFromNumbers(poses.col(i).data()));
  }
  return result;
}

}  // namespace cwm::CWM_API
