// A stream of questions, answered in order: one read, then the work, then one write, then the next
// read.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <stop_token>

#include "cwm/v1/query.grpc.pb.h"
#include "server/rpc/query_answers.h"

namespace cwm::server {

// A message whose question fails is answered with its error; the stream goes on.
class StreamQueriesCall final
    : public grpc::ServerBidiReactor<v1::StreamQueriesRequest, v1::StreamQueriesResponse>,
      public Drainable,
      public std::enable_shared_from_this<StreamQueriesCall> {
 public:
  static StreamQueriesCall* Start(grpc::CallbackServerContext* context, Runtime& runtime);

  // Ends the stream where it waits for the client; an answer under way is still sent.
  void Drain() override;

 private:
  StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override;

  void ReadNext();
  void Enqueue();
  absl::Status AnswerRequest(const CallContext& call);
  void Reply(const absl::Status& status);
  // Once; later calls do nothing.
  void FinishOnce(const absl::Status& status);

  Runtime& runtime_;
  const Clock::time_point deadline_;
  std::stop_source stop_;
  HeldSnapshot held_;
  v1::StreamQueriesRequest request_;
  v1::StreamQueriesResponse response_;
  std::shared_ptr<StreamQueriesCall> self_;  // until OnDone
  bool counted_ = false;                     // in the quota of streams

  std::mutex mutex_;
  bool reading_ = false;   // waits for the client
  bool finished_ = false;  // Finish was called
};

}  // namespace cwm::server
