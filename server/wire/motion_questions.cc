// Motions of what asks; declared in questions.h.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"
#include "server/wire/questions.h"

namespace cwm::server {
namespace {

using collision::JointKind;
using collision::Path;

absl::StatusOr<std::vector<Path>> PathsOf(const v1::CheckMotionsRequest& request,
                                          std::size_t row_count) {
  const FieldPath root;
  std::vector<Path> paths;
  if (request.path_row_counts().empty()) {
    if (row_count % 2 != 0) {
      return root.Field("subject").Error(
          absl::StrCat("has ", row_count, row_count == 1 ? " row" : " rows",
                       ", must have an even number: rows 2i and 2i + 1 are the ends of motion i, "
                       "unless path_row_counts says otherwise"));
    }
    for (std::size_t row = 0; row < row_count; row += 2) paths.push_back({.first_row = row});
    return paths;
  }
  std::size_t next = 0;
  for (int i = 0; i < request.path_row_counts_size() && next <= row_count; ++i) {
    const int count = request.path_row_counts(i);
    if (count < 2) {
      return root.Item("path_row_counts", i)
          .Error(absl::StrCat("is ", count, ", must be at least 2"));
    }
    paths.push_back({.first_row = next, .row_count = static_cast<std::size_t>(count)});
    next += paths.back().row_count;
  }
  if (next == row_count) return paths;
  const std::string sum = next > row_count ? "more" : absl::StrCat(next);
  return root.Field("path_row_counts")
      .Error(absl::StrCat("add up to ", sum, ", must add up to the ", row_count,
                          " rows of the subject"));
}

bool IsCompound(const collision::ModelLink& link) {
  return link.kind == JointKind::kPlanar || link.kind == JointKind::kFloating;
}

absl::Status CheckFollowed(const RobotStates& states, const std::vector<Path>& paths,
                           const FieldPath& path) {
  const collision::RobotModel& model = states.robot->model();
  if (std::ranges::none_of(model.links, IsCompound)) return absl::OkStatus();
  const collision::JointRows rows(model, *states.group, {.base = states.base, .rows = states.rows});
  for (const Path& asked : paths) {
    for (std::size_t k = asked.first_row + 1; k < asked.first_row + asked.row_count; ++k) {
      const auto link =
          collision::JointMotion::FirstNotFollowed(model, rows.State(k - 1), rows.State(k));
      if (!link.has_value()) continue;
      const collision::ModelLink& moved = model.links[static_cast<std::size_t>(*link)];
      const std::string field = absl::StrCat("data row ", k);
      return path.Field(field).Error(
          absl::StrCat(moved.kind == JointKind::kPlanar ? "planar" : "floating", " joint ",
                       collision::Quoted(moved.joint), " differs from row ", k - 1,
                       ", must stand still within a motion: no bounds are known of its way"));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<MotionQuestion> FromProto(const v1::CheckMotionsRequest& request,
                                         const QuestionSource& source) {
  const FieldPath root;
  const FieldPath subject = root.Field("subject");
  if (request.subject().has_points()) {
    return subject.Field("points").Error(
        "do not move, must be one of shapes, object, robot: give a small sphere as shapes");
  }
  auto question = FromProto(request.subject(), source, subject);
  if (!question.ok()) return question.status();
  auto paths = PathsOf(request, RowsOf(*question)->size());
  if (!paths.ok()) return paths.status();
  if (const auto* states = std::get_if<RobotStates>(&question->where)) {
    const FieldPath robot = subject.Field("robot");
    auto status = CheckFollowed(*states, *paths, robot.Field("rows"));
    if (!status.ok()) return status;
  }
  return MotionQuestion{*std::move(question), *std::move(paths)};
}

}  // namespace cwm::server
