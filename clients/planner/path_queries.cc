#include "clients/planner/path_queries.h"

#include <cstring>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::planner {
namespace {

void AddRow(const Row& row, v1::Subject& subject) {
  v1::JointRows& rows = *subject.mutable_robot()->mutable_rows();
  rows.set_scalar(v1::SCALAR_F64);
  rows.set_width(static_cast<std::int32_t>(row.size()));
  rows.mutable_data()->append(reinterpret_cast<const char*>(row.data()),
                              row.size() * sizeof(double));
}

// The contact of a CollisionRow or a MotionRow; empty if no pair is named.
template <class ResponseRow>
std::string ContactText(const ResponseRow& row) {
  if (!row.has_body_link() && !row.has_object()) return "";
  const std::string who = row.has_body_object() ? row.body_object() : row.body_link();
  if (!row.has_object()) {
    return absl::StrCat(who, " meets ", row.object_link(), " of the robot itself");
  }
  const std::string of_robot = row.has_object_link() ? absl::StrCat(":", row.object_link()) : "";
  return absl::StrCat(who, " meets ", row.object(), of_robot);
}

}  // namespace

absl::StatusOr<std::string> DescribeCollision(client::QueryStream& stream,
                                              v1::CheckCollisionsRequest query, const Row& row) {
  AddRow(row, *query.mutable_subject());
  query.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  v1::StreamQueriesRequest request;
  *request.mutable_check_collisions() = std::move(query);
  const auto response = stream.Evaluate(request);
  if (!response.ok()) return response.status();
  const v1::CheckCollisionsResponse& answer = response->check_collisions();
  if (answer.rows_size() != 1) return absl::DataLossError("the server answered no row of 1");
  const std::string contact = ContactText(answer.rows(0));
  return contact.empty()
             ? absl::StrCat("the verdict is ", v1::Verdict_Name(answer.rows(0).verdict()))
             : contact;
}

absl::StatusOr<Certificate> CertifyPath(client::QueryStream& stream,
                                        const v1::CheckCollisionsRequest& query,
                                        const std::vector<Row>& path) {
  v1::StreamQueriesRequest stream_request;
  v1::CheckMotionsRequest& request = *stream_request.mutable_check_motions();
  request.set_world(query.world());
  *request.mutable_subject() = query.subject();
  *request.mutable_options() = query.options();
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  for (const Row& row : path) AddRow(row, *request.mutable_subject());
  request.add_path_row_counts(static_cast<std::int32_t>(path.size()));
  const auto response = stream.Evaluate(stream_request);
  if (!response.ok()) return response.status();
  const v1::CheckMotionsResponse& answer = response->check_motions();
  if (answer.rows_size() != 1) return absl::DataLossError("the server answered no motion of 1");
  const v1::MotionRow& row = answer.rows(0);
  return Certificate{.verdict = row.verdict(),
                     .clearance_m = row.clearance_m(),
                     .segment = row.segment(),
                     .contact = ContactText(row),
                     .accuracy = row.trust()};
}

}  // namespace cwm::planner
