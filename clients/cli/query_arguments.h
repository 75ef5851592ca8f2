// Options of every query.
#pragma once

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/body_arguments.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/row_columns.h"
#include "clients/cli/unknown_names.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

struct QueryArguments {
  std::string at_revision;  // "latest", "N" (exact) or "N+" (at least)
  cwm::v1::Engine engine = cwm::v1::ENGINE_UNSPECIFIED;
  cwm::v1::Representation representation = cwm::v1::REPRESENTATION_UNSPECIFIED;
  cwm::v1::UnseenSpace unseen = cwm::v1::UNSEEN_SPACE_UNSPECIFIED;
  double margin_m = 0;
  std::optional<double> max_distance_m;
  int max_results = 0;
  int max_contacts = 0;
  std::vector<std::string> ignore;
  std::vector<std::string> only;          // NAME or ROBOT:LINK
  std::vector<std::string> ignore_pairs;  // "A,B"
  std::vector<std::string> what_if;       // see what_if.h
  double margin_sigma = 0;
  std::optional<double> support_tolerance_m;
  std::optional<double> time_budget_s;
};

// Arguments of commands that print a verdict a row.
struct VerdictArguments {
  BodyArguments body;
  QueryArguments query;
  bool exit_code = false;  // the exit code is the answer, see ExitCodeOfRows
};

void AddVerdictOptions(CLI::App& command, VerdictArguments& arguments);
void AddQueryOptions(CLI::App& command, QueryArguments& query);
// For verdicts and contacts; distances are geometric.
void AddMarginOption(CLI::App& command, QueryArguments& query);
// For queries about pairs; rays and samples have no pair rules.
void AddPairRuleOptions(CLI::App& command, QueryArguments& query);
void AddRevisionOption(CLI::App& command, std::string& at_revision);

// A usage error for anything but "", "latest", "N" and "N+".
absl::StatusOr<cwm::v1::AtRevision> ParseRevision(const std::string& text);

google::protobuf::Duration ToDuration(double seconds);

// Requests F64 answers in rows, so that JSON is readable.
absl::StatusOr<cwm::v1::QueryOptions> ParseQueryOptions(const QueryArguments& query);

// Asks as many requests as `requests` says and returns the answers as one, with all rows in order.
// All are answered from the first answer's revision, and none is asked after a partial answer.
// `fill` puts the rows of the i-th one into a request and returns their number; `adapt` changes an
// answer before it is appended to those before it.
template <class Request, class Response, class Method, class Fill, class Adapt>
absl::StatusOr<Response> EvaluateInTurn(Session& session, Method method, std::size_t requests,
                                        cwm::v1::QueryOptions options, Fill fill, Adapt adapt) {
  Response all;
  std::int64_t completed = 0;
  for (std::size_t i = 0; i < requests; ++i) {
    Request request;
    request.set_world(session.world);
    *request.mutable_options() = options;
    const auto asked = static_cast<std::int64_t>(fill(i, request));
    auto answer = session.connection().Call(method, session.connection().queries(), request);
    if (!answer.ok()) return answer.status();
    if (absl::Status status = adapt(all, *answer); !status.ok()) return status;
    all.MergeFrom(*answer);
    completed += answer->completed_count();
    if (answer->completed_count() < asked) break;
    options.mutable_at_revision()->set_exact(answer->revision());
    options.set_world_uid(answer->world_uid());
  }
  all.set_completed_count(completed);  // a prefix of all rows
  WarnAboutUnknownNames(session, options);
  return all;
}

// Removes the names of variables from an answer if those before it have them already.
template <class Response>
void KeepVariablesOnce(const Response&, Response&) {}
inline void KeepVariablesOnce(const cwm::v1::GetDistancesResponse& all,
                              cwm::v1::GetDistancesResponse& answer) {
  if (all.variables_size() > 0) answer.clear_variables();
}

// Asks every batch of bodies; `form` holds the fields of each request besides subject and options.
template <class Request, class Response, class Method>
absl::StatusOr<Response> EvaluateBatches(Session& session, Method method,
                                         const std::vector<Batch>& batches,
                                         const cwm::v1::QueryOptions& options,
                                         const Request& form = {}) {
  return EvaluateInTurn<Request, Response>(
      session, method, batches.size(), options,
      [&](std::size_t i, Request& request) {
        const Batch& batch = batches[i];
        request.MergeFrom(form);
        *request.mutable_subject() = batch.subject;
        request.mutable_options()->set_result_form(batch.row_count > kMaxMessageRows
                                                       ? cwm::v1::RESULT_FORM_COLUMNS
                                                       : cwm::v1::RESULT_FORM_ROWS);
        return batch.row_count;
      },
      [](const Response& all, Response& answer) {
        if (absl::Status status = ExpandRows(answer); !status.ok()) return status;
        const bool same_links = std::equal(all.body_links().begin(), all.body_links().end(),
                                           answer.body_links().begin(), answer.body_links().end());
        if (same_links) {  // kept once
          answer.clear_body_links();
          answer.clear_body_objects();
        }
        KeepVariablesOnce(all, answer);
        return absl::OkStatus();
      });
}

// The same for rows of numbers, in as many messages as necessary: `set` puts some of the rows into
// a request.
template <class Request, class Response, class Method, class Row, class Set>
absl::StatusOr<Response> EvaluateRows(Session& session, Method method, const std::vector<Row>& rows,
                                      const cwm::v1::QueryOptions& options, Set set) {
  return EvaluateInTurn<Request, Response>(
      session, method, (rows.size() + kMaxMessageRows - 1) / kMaxMessageRows, options,
      [&](std::size_t i, Request& request) {
        const std::size_t begin = i * kMaxMessageRows;
        const std::size_t count = std::min(kMaxMessageRows, rows.size() - begin);
        set(std::vector<Row>(&rows[begin], &rows[begin] + count), request);
        return count;
      },
      [](const Response&, Response&) { return absl::OkStatus(); });
}

// The exit code for --exit-code. Free means that all rows are known to be free: neither a state out
// of limits nor a row without an answer counts as free. `code_of` is the code of one verdict.
template <class Response, class CodeOf>
ExitCode ExitCodeOfRows(const Response& answer, std::size_t row_count, CodeOf code_of) {
  const bool all = static_cast<std::size_t>(answer.completed_count()) == row_count;
  ExitCode code = all ? ExitCode::kDone : ExitCode::kNotFree;
  for (const auto& row : answer.rows()) {
    const ExitCode of_row = code_of(row.verdict());
    if (of_row == ExitCode::kCollision) return of_row;
    if (of_row != ExitCode::kDone) code = of_row;
  }
  return code;
}

// The line below a table: "revision 7, 3 of 5 rows".
std::string Footer(std::int64_t revision, std::int64_t completed, std::size_t row_count,
                   const std::string& unit = "row");

// Prints an answer whose `rows` are a list, of which `row_count` were asked for; `print_table`
// prints them as a table, which the footer follows.
template <class Response, class PrintTableOf>
void PrintResult(Session& session, const Response& answer, std::size_t row_count,
                 PrintTableOf print_table, const std::string& unit = "row") {
  session.PrintList(
      answer,
      [&] {
        for (const auto& row : answer.rows()) session.PrintLine(row);
      },
      [&] {
        print_table(answer, session);
        session.streams.out << Footer(answer.revision(), answer.completed_count(), row_count, unit)
                            << "\n";
      });
}

// The obstacle of a row for tables: an object's name, or "itself" for a robot.
template <class Row>
std::string ObstacleName(const Row& row) {
  return row.object().empty() && row.has_object_link() ? "itself" : row.object();
}
// The obstacle of a ray or point, with the link if it is a robot.
template <class Row>
std::string HitObstacleName(const Row& row) {
  return row.has_object_link() ? row.object() + ":" + row.object_link() : row.object();
}
// The part of the body in contact: a robot's link, with the attached object if any.
template <class Row>
std::string BodyName(const Row& row) {
  return row.has_body_object() ? row.body_link() + " with " + row.body_object() : row.body_link();
}
std::size_t RowCount(const std::vector<Batch>& batches);

}  // namespace cwm::cli
