#include "clients/cpp/query_stream.h"

#include <utility>

namespace cwm::client {
namespace {

absl::Status FromError(const v1::QueryError& error) {
  ErrorDetails details{.reason = error.reason(),
                       .fields = {},
                       .metadata = {error.metadata().begin(), error.metadata().end()},
                       .retry_after_s = {}};
  for (const v1::FieldError& field : error.fields()) {
    details.fields.push_back({field.field(), field.description()});
  }
  if (error.has_retry_delay()) {
    details.retry_after_s =
        static_cast<double>(error.retry_delay().seconds()) + 1e-9 * error.retry_delay().nanos();
  }
  return MakeStatus(static_cast<absl::StatusCode>(error.code()), error.message(), details);
}

}  // namespace

QueryStream::QueryStream(const Connection& connection)
    : stream_(connection.queries().StreamQueries(&context_)) {}

QueryStream::~QueryStream() {
  if (!end_.ok()) return;  // finished already
  stream_->WritesDone();
  v1::StreamQueriesResponse ignored;
  while (stream_->Read(&ignored)) {
  }
  // The query that failed has already returned the error.
  static_cast<void>(stream_->Finish());
}

absl::StatusOr<v1::StreamQueriesResponse> QueryStream::Evaluate(v1::StreamQueriesRequest& request) {
  std::int64_t id = 0;
  {
    const std::lock_guard lock(write_mutex_);
    id = ++last_id_;
    request.set_id(id);
    if (!is_over_) stream_->Write(request);  // if it fails, so does the read
  }
  std::unique_lock lock(read_mutex_);
  turn_.wait(lock, [&] { return next_id_ == id; });
  v1::StreamQueriesResponse response;
  if (end_.ok() && !stream_->Read(&response)) {
    end_ = StatusFromGrpc(stream_->Finish());
    if (end_.ok()) end_ = absl::UnavailableError("the server ended the stream");
    is_over_ = true;
  }
  ++next_id_;
  turn_.notify_all();
  if (!end_.ok()) return end_;
  if (response.has_error()) return FromError(response.error());
  return response;
}

}  // namespace cwm::client
