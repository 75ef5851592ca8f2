// A stream of queries, answered in order: while one is being answered, the next is read and the
// previous answer is written.
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

// A query that fails is answered with its error, and the stream goes on.
//
// A message passes through three places, each of which holds one message: it is read, it is
// answered, its answer is written. Every event (a reaction, an answer, a drain) is recorded under
// the lock, and then every message that can advance does. Only there operations are started and the
// call is finished, once, when nothing is being answered or written and nothing more can come.
// Tasks and waits keep the call alive.
class StreamQueriesCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                                public Drainable,
                                public std::enable_shared_from_this<StreamQueriesCall> {
 public:
  static StreamQueriesCall* Start(grpc::CallbackServerContext* context, Runtime& runtime);

  // An answer in progress is still sent; later messages are not answered.
  void Drain() override { Advance(); }

 private:
  StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override;

  // Advances every message that can advance.
  void Advance();
  bool AdvanceLocked();
  void Read();
  void FinishIfOver();
  // Steps of the query that has just come into its place. Each ends in OnAnswered.
  void Begin();
  void ParseAndPlan();
  void AnswerOnException(const std::function<void()>& work);
  void Plan();
  void FailStream(const absl::Status& status);
  void Enqueue();
  WorkQueue& Queue();
  void Work();
  absl::Status AnswerRequest(const CallContext& call);
  void OnAnswered(const absl::Status& status);
  void End(const absl::Status& status);

  Runtime& runtime_;
  const Clock::time_point deadline_;
  std::stop_source stop_;
  OpenCalls::Token open_{runtime_.open_calls, stop_};
  StreamMemory memory_;
  std::shared_ptr<StreamQueriesCall> self_;  // until OnDone
  grpc::CallbackServerContext* const context_;
  const ClientId client_;
  std::optional<QuotaShare> quota_share_;  // in the quota of streams
  MemoryCharge charge_;                    // for the request and its answer
  StallTimers::Guard reading_;             // while the client reads an answer

  enum class SlotState { kEmpty, kInProgress, kDone };
  // While a slot is kInProgress, only the thread that fills it accesses its data. The mutex may be
  // held while StartRead, StartWrite or Finish runs, because gRPC calls no reaction within them.
  std::mutex mutex_;
  SlotState read_ = SlotState::kEmpty;
  SlotState answer_ = SlotState::kEmpty;
  SlotState write_ = SlotState::kEmpty;     // never kDone
  std::optional<QuotaShare> ahead_;         // for read_, if it is read ahead
  bool client_is_done_ = false;             // nothing more is read
  bool client_is_gone_ = false;             // nothing more is written
  bool is_over_ = false;                    // Finish was called
  grpc::ByteBuffer next_;                   // of read_
  grpc::ByteBuffer request_bytes_;          // of answer_, until they are parsed
  v1::StreamQueriesRequest request_;        // of answer_
  double cost_s_ = 0;                       // estimated cost of request_
  std::optional<WorldAtRevision> reached_;  // the revision that request_ awaited, if any
  Clock::time_point begin_time_;            // when request_ came to be answered
  v1::StreamQueriesResponse response_;      // of answer_
  grpc::ByteBuffer answered_, written_;     // of answer_ and write_
  absl::Status stream_error_;               // the error that ends the stream, if any
};

}  // namespace cwm::server
