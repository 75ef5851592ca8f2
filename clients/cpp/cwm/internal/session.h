// The state that views of a world share, and calls that are sent once more if the server was lost.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/query_stream.h"
#include "cwm/changes.h"

namespace cwm::CWM_API::internal {

// A connection that was answered once.
struct Session {
  explicit Session(client::Connection without_deadline) : connection(std::move(without_deadline)) {}

  client::Connection connection;  // without a deadline
  v1::Limits limits = {};
  std::mutex mutex = {};
  std::set<std::string> sent_meshes = {};  // their hashes
};

// The settings of a WorldView, which never change.
struct View {
  std::shared_ptr<Session> session;
  std::shared_ptr<const client::Connection> connection;  // with the view's timeout
  std::shared_ptr<client::QueryStream> stream = {};      // absent: each query is a call
  std::string world = {};
  std::string uid = {};  // of the pinned world
  std::optional<std::int64_t> pinned = {};
  std::optional<double> timeout_s = {};
  std::vector<Change> supposed = {};  // changes of WhatIf that no stream has
};

// A new id under which a server recognises a repeated write.
std::string NewRequestId();

// Throws the error.
[[noreturn]] void Throw(const absl::Status& status, const client::Connection& connection);

// Throws kInvalidArgument. "poses[3]", "is no rigid transform, must be ...".
[[noreturn]] void ThrowBadArgument(const std::string& field, const std::string& description);

// True once the server answers again, which may take a few seconds, but not after the time.
bool IsBack(const client::Connection& connection, std::optional<double> retry_after_s,
            std::optional<std::chrono::steady_clock::time_point> end);

std::optional<std::chrono::milliseconds> DeadlineOf(std::optional<double> timeout_s);

// Calls `attempt(connection)`, which returns a StatusOr, and once more if the server was lost and
// is back. For queries, and writes that have a request id.
template <class Attempt>
auto Repeat(const View& view, const Attempt& attempt) {
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> end;
  if (const auto deadline = DeadlineOf(view.timeout_s)) end = Clock::now() + *deadline;
  auto result = attempt(*view.connection);
  if (!absl::IsUnavailable(result.status())) return result;
  const auto retry_after_s = client::DetailsOf(result.status()).retry_after_s;
  if (!IsBack(*view.connection, retry_after_s, end)) return result;
  if (!end) return attempt(*view.connection);
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(*end - Clock::now());
  return attempt(view.connection->WithDeadline(std::max(left, std::chrono::milliseconds::zero())));
}

template <class Attempt>
auto RepeatOrThrow(const View& view, const Attempt& attempt) {
  auto result = Repeat(view, attempt);
  if (!result.ok()) Throw(result.status(), *view.connection);
  return *std::move(result);
}

// One unary call of a service: Call(view, &Stub::GetObject, &Connection::worlds, request).
template <class Stub, class Request, class Response>
Response Call(const View& view,
              grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
              Stub& (client::Connection::*stub)() const, const Request& request) {
  return RepeatOrThrow(view, [&](const client::Connection& connection) {
    return connection.Call(method, (connection.*stub)(), request);
  });
}

// Sets the revision if the view is pinned.
template <class Request>
void SetRevision(const View& view, Request& request) {
  if (!view.pinned) return;
  request.mutable_at_revision()->set_exact(*view.pinned);
  request.set_world_uid(view.uid);
}

}  // namespace cwm::CWM_API::internal
