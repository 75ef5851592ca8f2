// A stream of questions, answered in order: while one is being answered the next is read, and the
// answer before it is written.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "cwm/v1/query.grpc.pb.h"
#include "server/rpc/query_answers.h"

namespace cwm::server {

// A message whose question fails is answered with its error; the stream goes on.
//
// A message goes through three places, each of which holds one: it is read, it is answered, its
// answer is written. Whatever happens (a reaction, an answer, a drain) is noted under the lock, and
// then all that can is moved on. Only there are operations started and is the call finished: once,
// when nothing is being answered or written and nothing more can come. Tasks and waits hold the
// call alive.
class StreamQueriesCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                                public Drainable,
                                public std::enable_shared_from_this<StreamQueriesCall> {
 public:
  static StreamQueriesCall* Start(grpc::CallbackServerContext* context, Runtime& runtime);

  // An answer under way is still sent; what was read after its question is not answered.
  void Drain() override { Advance(); }

 private:
  StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override;

  // Moves on what can be moved.
  void Advance();
  bool MoveOn();
  void Read();
  void FinishIfOver();
  // Of the question that has just come into its place. Each ends in Answered.
  void Begin();
  void ParseAndPlan();
  void AnswerIfItThrows(const std::function<void()>& work);
  void Plan();
  void Break(const absl::Status& status);
  void Enqueue();
  WorkQueue& Queue();
  void Work();
  absl::Status AnswerRequest(const CallContext& call);
  void Answered(const absl::Status& status);
  void End(const absl::Status& status);

  Runtime& runtime_;
  const Clock::time_point deadline_;
  std::stop_source stop_;
  OpenCalls::Token open_{runtime_.open_calls, stop_};
  StreamMemory memory_;
  std::shared_ptr<StreamQueriesCall> self_;  // until OnDone
  grpc::CallbackServerContext* const context_;
  const ClientId client_;
  std::optional<QuotaShare> place_;  // of a stream
  MemoryCharge charge_;              // of the request and its answer
  StallTimers::Guard reading_;       // of an answer, by the client

  enum class Place { kEmpty, kUnderWay, kDone };
  // What is under way belongs to who does it. Held over StartRead, StartWrite and Finish: gRPC
  // never reacts within them.
  std::mutex mutex_;
  Place read_ = Place::kEmpty;
  Place answer_ = Place::kEmpty;
  Place write_ = Place::kEmpty;             // never kDone
  std::optional<QuotaShare> ahead_;         // of read_, of messages that are read ahead
  bool client_is_done_ = false;             // nothing more is read
  bool client_is_gone_ = false;             // nothing more is written
  bool is_over_ = false;                    // Finish was called
  grpc::ByteBuffer next_;                   // of read_
  grpc::ByteBuffer request_bytes_;          // of answer_, until they are parsed
  v1::StreamQueriesRequest request_;        // of answer_
  double cost_s_ = 0;                       // of it, estimated
  std::optional<WorldAtRevision> reached_;  // what request_ awaited, if it did
  Clock::time_point begun_;                 // when request_ came into its place
  v1::StreamQueriesResponse response_;      // of answer_
  grpc::ByteBuffer answered_, written_;     // of answer_ and of write_
  absl::Status broken_;                     // why the stream ends, where it cannot go on
};

}  // namespace cwm::server
