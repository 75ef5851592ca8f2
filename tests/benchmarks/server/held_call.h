// One call of any method, given as bytes, that a client holds open as long as it likes.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/client_callback.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace cwm::benchmarks {

struct CallPlan {
  std::string method;                      // "cwm.v1.WorldService/ApplyChanges"
  std::vector<std::string> messages = {};  // serialized, sent in order
  bool half_closes = true;                 // false: the client never says that it is done
  bool reads = true;                       // false: answers stay with the server beyond 64 KiB
  bool compresses = false;                 // gzip
  std::vector<std::pair<std::string, std::string>> metadata = {};
};

// The bytes of all messages on the wire, with gRPC's prefix of five bytes each, without headers.
std::int64_t WireBytes(const CallPlan& plan);

// A held call. Thread safe. Its destructor cancels the call and waits for that, even if the server
// is gone.
class HeldCall final : private grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  HeldCall(const std::shared_ptr<grpc::Channel>& channel, CallPlan plan);
  ~HeldCall() override;
  HeldCall(const HeldCall&) = delete;
  HeldCall& operator=(const HeldCall&) = delete;

  void Cancel();
  // True if the call is over.
  bool WaitUntilDone(std::chrono::milliseconds limit);
  // True if all messages are sent or the call is over.
  bool WaitUntilSent(std::chrono::milliseconds limit);
  std::int64_t wire_bytes() const { return wire_bytes_; }
  // "open" until it is over, then the name of its status code.
  std::string Outcome() const;
  // The status of a call that is over.
  grpc::Status status() const;

 private:
  void SendNext();
  void OnWriteDone(bool ok) override;
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;

  const CallPlan plan_;
  const std::int64_t wire_bytes_;
  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::ByteBuffer outgoing_, incoming_;
  std::size_t next_ = 0;  // of the messages
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool sent_ = false, done_ = false;
  grpc::Status status_;
};

// The name of a code: "RESOURCE_EXHAUSTED".
std::string CodeName(grpc::StatusCode code);

}  // namespace cwm::benchmarks
