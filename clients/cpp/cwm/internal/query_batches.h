// Queries in batches: what is above the server's limits is cut, asked about one revision, and put
// together again.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cwm/internal/geometry_messages.h"
#include "cwm/internal/session.h"
#include "cwm/internal/world_messages.h"
#include "cwm/queries.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"

namespace cwm::CWM_API::internal {

// The numbers of a pose, see PoseRows.
inline constexpr std::size_t kPoseWidth = 7;
// chosen: more links than most robots have; batches with an answer for each link are cut by it.
inline constexpr std::int64_t kManyLinks = 128;

// How a request is sent: a call of a service, and a part of the messages of a stream.
template <class Request>
struct Method;
template <>
struct Method<v1::CheckCollisionsRequest> {
  using Response = v1::CheckCollisionsResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::CheckCollisions;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_check_collisions;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_check_collisions;
};
template <>
struct Method<v1::GetDistancesRequest> {
  using Response = v1::GetDistancesResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::GetDistances;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_get_distances;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_get_distances;
};
template <>
struct Method<v1::GetContactsRequest> {
  using Response = v1::GetContactsResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::GetContacts;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_get_contacts;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_get_contacts;
};
template <>
struct Method<v1::GetWorldContactsRequest> {
  using Response = v1::GetWorldContactsResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::GetWorldContacts;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_get_world_contacts;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_get_world_contacts;
};
template <>
struct Method<v1::CastRaysRequest> {
  using Response = v1::CastRaysResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::CastRays;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_cast_rays;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_cast_rays;
};
template <>
struct Method<v1::SamplePointsRequest> {
  using Response = v1::SamplePointsResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::SamplePoints;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_sample_points;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_sample_points;
};
template <>
struct Method<v1::CheckMotionsRequest> {
  using Response = v1::CheckMotionsResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::CheckMotions;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_check_motions;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_check_motions;
};
template <>
struct Method<v1::SolvePosesRequest> {
  using Response = v1::SolvePosesResponse;
  static constexpr auto kCall = &v1::QueryService::Stub::SolvePoses;
  static constexpr auto kIn = &v1::StreamQueriesRequest::mutable_solve_poses;
  static constexpr auto kOut = &v1::StreamQueriesResponse::mutable_solve_poses;
};

template <class Request>
using ResponseOf = typename Method<Request>::Response;

// One query; over the view's stream, if it has one. The request is unchanged afterwards.
template <class Request>
absl::StatusOr<ResponseOf<Request>> Ask(const View& view, Request& request) {
  using M = Method<Request>;
  if (view.stream == nullptr) {
    return Repeat(view, [&](const client::Connection& connection) {
      return connection.Call(M::kCall, connection.queries(), request);
    });
  }
  v1::StreamQueriesRequest streamed;
  (streamed.*M::kIn)()->Swap(&request);
  auto response = view.stream->Evaluate(streamed);
  (streamed.*M::kIn)()->Swap(&request);
  if (!response.ok()) return response.status();
  return std::move(*((*response).*M::kOut)());
}
// Forward kinematics is a call of another service, without a stream.
template <>
struct Method<v1::GetLinkPosesRequest> {
  using Response = v1::GetLinkPosesResponse;
};
absl::StatusOr<v1::GetLinkPosesResponse> Ask(const View& view, v1::GetLinkPosesRequest& request);

// Sends the meshes that were not sent yet over this connection, or all.
void SendMeshes(const View& view, const std::vector<MeshBlob>& meshes, bool again);

// Calls `attempt()`, which returns a StatusOr, once the server has the meshes, and once more if it
// has lost those that were sent before.
template <class Attempt>
auto WithMeshes(const View& view, const std::vector<MeshBlob>& meshes, const Attempt& attempt) {
  SendMeshes(view, meshes, /*again=*/false);
  auto result = attempt();
  if (!meshes.empty() && client::DetailsOf(result.status()).reason == "GEOMETRY_UNKNOWN") {
    SendMeshes(view, meshes, /*again=*/true);
    result = attempt();
  }
  if (!result.ok()) Throw(result.status(), *view.connection);
  return *std::move(result);
}

// The rows of a query as they travel. A unit, which is a row or a motion of several, stays whole:
// unit i has the rows from unit_begin[i] to unit_begin[i + 1].
struct Batches {
  std::vector<double> numbers = {};  // row by row; empty: there are none
  std::size_t width = 0;
  std::vector<std::int64_t> unit_begin = {0, 1};
  std::int64_t answers_per_unit = 1;

  std::int64_t unit_count() const { return static_cast<std::int64_t>(unit_begin.size()) - 1; }
  std::int64_t row_count() const { return unit_begin.back(); }
  // The bytes of the rows of these units.
  std::string Bytes(std::int64_t first_unit, std::int64_t end_unit) const;
};

// Each row is a unit.
Batches BatchesOfRows(std::vector<double> numbers, std::size_t width);

// The options as a message, with what the view supposes, and the meshes that they need.
v1::QueryOptions OptionsOf(const View& view, const QueryOptions& options,
                           std::vector<MeshBlob>& meshes);

// The end of the first request's units from `first` on.
std::int64_t EndOfBatch(const View& view, const Batches& batches, std::int64_t first,
                        std::size_t head_bytes);

// How often a query of several requests begins anew when the server has forgotten its revision
// meanwhile: a world with joint states at 100 Hz keeps one for two or three seconds.
inline constexpr int kMaxAttempts = 3;

// The replies, in order, all about one revision. `fill(request, first, end)` sets what a request
// has besides world and options: the subject with the rows of these units.
template <class Request>
std::vector<ResponseOf<Request>> Evaluate(const View& view, const QueryOptions& options,
                                          std::vector<MeshBlob> meshes, const Batches& batches,
                                          const auto& fill) {
  v1::QueryOptions message = OptionsOf(view, options, meshes);
  const auto begin = std::chrono::steady_clock::now();
  const auto left_s = [&] {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
    return *options.time_budget_s - passed.count();
  };
  for (int attempt = 1;; ++attempt) {
    std::vector<ResponseOf<Request>> replies;
    SetRevision(view, message);
    try {
      for (std::int64_t first = 0; first < batches.unit_count();) {
        const std::int64_t end = EndOfBatch(view, batches, first, message.ByteSizeLong());
        if (options.time_budget_s && !replies.empty()) {
          if (left_s() <= 0) break;
          *message.mutable_time_budget() = DurationFrom(left_s(), "options.time_budget_s");
        }
        Request request;
        request.set_world(view.world);
        *request.mutable_options() = message;
        fill(request, first, end);
        replies.push_back(WithMeshes(view, meshes, [&] { return Ask(view, request); }));
        const ResponseOf<Request>& reply = replies.back();
        if (reply.completed_count() < end - first) break;
        message.mutable_at_revision()->set_exact(reply.revision());
        message.set_world_uid(reply.world_uid());
        first = end;
      }
      return replies;
    } catch (const Error& error) {
      if (error.reason() != "REVISION_COMPACTED" || view.pinned || attempt == kMaxAttempts) throw;
      message.clear_at_revision();
      message.clear_world_uid();
    }
  }
}

// A subject with its rows.
struct BoundSubject {
  v1::Subject message;  // without the bytes of the rows
  Batches batches;
  std::vector<MeshBlob> meshes = {};

  // The subject with the rows of these units.
  void Fill(std::int64_t first_unit, std::int64_t end_unit, v1::Subject& subject) const;
};
// `name` is that of the rows' argument. Throws kInvalidArgument if the rows are not of the kind
// that the subject needs.
BoundSubject Bind(const Subject& subject, const Rows& rows, const std::string& name);
BoundSubject Bind(const RobotSubject& robot, const Rows& rows, const std::string& name);

}  // namespace cwm::CWM_API::internal
