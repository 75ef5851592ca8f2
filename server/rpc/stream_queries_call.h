// A stream of questions, answered in order: one read, then the work, then one write, then the next
// read.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>

#include "cwm/v1/query.grpc.pb.h"
#include "server/rpc/query_answers.h"

namespace cwm::server {

// A message whose question fails is answered with its error; the stream goes on.
//
// At any time one has the turn: the client, while a read waits for it, or one of ours (a reaction,
// a task, a wait for a revision). Only the holder starts operations or finishes, and only ours can
// give it away or keep it for good; so nothing is started after Finish, and Finish is called once.
// Tasks and waits hold the call alive.
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
  void Work();
  absl::Status AnswerRequest(const CallContext& call);
  void Reply(const absl::Status& status);
  // Takes the turn from the client; false when ours have it.
  bool TakeTurn();
  void End(const absl::Status& status);

  Runtime& runtime_;
  const OpenStreams::Token open_{runtime_.open_streams};
  const Clock::time_point deadline_;
  std::stop_source stop_;
  HeldSnapshot held_;
  v1::StreamQueriesRequest request_;
  std::optional<WorldAtRevision> reached_;  // what request_ awaited, if it did
  v1::StreamQueriesResponse response_;
  std::shared_ptr<StreamQueriesCall> self_;  // until OnDone
  bool counted_ = false;                     // in the quota of streams

  enum class Turn { kOurs, kClients };
  // Held over StartRead, so that nobody finishes between giving the turn away and the read. gRPC
  // does the same with a lock of its own that StartRead takes: it never reacts within the call.
  std::mutex mutex_;
  Turn turn_ = Turn::kOurs;
};

}  // namespace cwm::server
