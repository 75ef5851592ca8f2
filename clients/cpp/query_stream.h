// Queries over one stream, which keeps the snapshot that it answers from: an exact revision stays
// available however often the world changes meanwhile.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "cwm/v1/query.pb.h"

namespace cwm::client {

// Thread safe: the queries of several threads overlap.
class QueryStream {
 public:
  // The connection must outlive the stream. There is no deadline; a lost server ends it.
  explicit QueryStream(const Connection& connection);
  ~QueryStream();
  QueryStream(const QueryStream&) = delete;
  QueryStream& operator=(const QueryStream&) = delete;

  // The answer to the request, whose id is set here; an error in the answer becomes the status,
  // which is the one that a unary call returns.
  absl::StatusOr<v1::StreamQueriesResponse> Evaluate(v1::StreamQueriesRequest& request);

 private:
  using Stream = grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>;

  grpc::ClientContext context_;
  std::unique_ptr<Stream> stream_;
  std::mutex write_mutex_;
  std::int64_t last_id_ = 0;  // written

  // Answers come in the order of the queries: each caller reads its own when it is its turn.
  std::mutex read_mutex_;
  std::condition_variable turn_;
  std::int64_t next_id_ = 1;  // to be read
  absl::Status end_;          // why the stream is over; OK: it is not
  std::atomic<bool> is_over_ = false;
};

}  // namespace cwm::client
