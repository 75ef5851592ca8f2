// Queries over one stream, which keeps the snapshot that it answers from: an exact revision stays
// available however often the world changes meanwhile.
#pragma once

#include <memory>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "cwm/v1/query.pb.h"

namespace cwm::client {

class QueryStream {
 public:
  // The connection must outlive the stream. There is no deadline; a lost server ends it.
  explicit QueryStream(const Connection& connection);
  ~QueryStream();
  QueryStream(const QueryStream&) = delete;
  QueryStream& operator=(const QueryStream&) = delete;

  // The answer to the request, whose id is set here; an error in the answer becomes the status.
  absl::StatusOr<v1::StreamQueriesResponse> Evaluate(v1::StreamQueriesRequest& request);

 private:
  absl::Status EndOfStream();

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
      stream_;
  std::int64_t id_ = 0;
};

}  // namespace cwm::client
