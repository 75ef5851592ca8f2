// Motions of a subject; declared in queries.h.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/wire/queries.h"

namespace cwm::server {
namespace {

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

}  // namespace

absl::StatusOr<MotionQuery> MotionQueryFromProto(const v1::CheckMotionsRequest& request,
                                                 const QuerySource& source) {
  const FieldPath root;
  const FieldPath subject = root.Field("subject");
  if (request.subject().has_points()) {
    return subject.Field("points").Error(
        "do not move, must be one of shapes, object, robot: give a small sphere as shapes");
  }
  auto query = StateQueryFromProto(request.subject(), source, subject);
  if (!query.ok()) return query.status();
  auto paths = PathsOf(request, RowsOf(*query)->size());
  if (!paths.ok()) return paths.status();
  return MotionQuery{*std::move(query), *std::move(paths)};
}

}  // namespace cwm::server
