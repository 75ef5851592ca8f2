// One call of the server's own services, told on the viewer's thread.
#pragma once

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace cwm::server {

// Where calls go and where they are told.
struct Bridge {
  boost::asio::io_context& context;  // of one thread
  grpc::GenericStub services;        // of a channel into this process
};

// Used on the viewer's thread alone. Unary calls and streams of answers alike: one request, then
// messages, each read when the one before was dealt with, so that what a slow reader does not take
// piles up nowhere.
class BridgeCall final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  // Run on the viewer's thread; must own nothing that has to end there.
  struct Listener {
    std::function<void(std::string message)> message;  // then nothing until ReadNext
    std::function<void(grpc::Status)> end;             // once, at last
  };
  struct Asked {
    const std::string& method;  // as in readable_methods.h
    const std::string& request;
    std::optional<std::chrono::milliseconds> time = {};  // after which it ends; absent: never
  };
  static std::shared_ptr<BridgeCall> Start(Bridge& bridge, const Asked& asked, Listener listener);

  void ReadNext();
  // No message comes any more, but an end.
  void Cancel();

 private:
  BridgeCall(Bridge& bridge, Listener listener);
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void Tell(std::string message);

  boost::asio::io_context& context_;
  // The thread goes on for what is still to be told.
  const boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  const Listener listener_;
  grpc::ClientContext call_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  bool told_ = false;  // a message, of which ReadNext has not been called
  bool cancelled_ = false;
  std::shared_ptr<BridgeCall> self_;  // until it is over
};

}  // namespace cwm::server
