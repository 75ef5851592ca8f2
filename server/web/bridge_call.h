// A call of the server's own services whose events are delivered on the viewer's thread.
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

// The services, and the thread that receives their messages.
struct Bridge {
  boost::asio::io_context& context;  // runs on one thread
  grpc::GenericStub services;        // over a channel into this process
};

// Used only on the viewer's thread. For unary calls and response streams alike: one request, then
// messages, each read after the previous one was handled, so that the messages of a slow reader are
// not queued anywhere.
class BridgeCall final : public grpc::ClientBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer> {
 public:
  // Called on the viewer's thread; must not own anything that has to be destroyed there.
  struct Listener {
    std::function<void(std::string message)> message;  // the next comes only after ReadNext
    std::function<void(grpc::Status)> end;             // once, at the end
  };
  struct Request {
    const std::string& method;  // as in readable_methods.h
    const std::string& body;
    std::optional<std::chrono::milliseconds> timeout =
        {};  // after which the call ends; empty: never
  };
  static std::shared_ptr<BridgeCall> Start(Bridge& bridge, const Request& request,
                                           Listener listener);

  void ReadNext();
  // No message is delivered afterwards, only the end.
  void Cancel();

 private:
  BridgeCall(Bridge& bridge, Listener listener);
  void OnReadDone(bool ok) override;
  void OnDone(const grpc::Status& status) override;
  void Deliver(std::string message);

  boost::asio::io_context& context_;
  // Keeps the thread running while there are events to deliver.
  const boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_;
  const Listener listener_;
  grpc::ClientContext call_;
  grpc::ByteBuffer request_;
  grpc::ByteBuffer response_;
  bool delivered_ = false;  // a message was delivered and ReadNext not called since
  bool cancelled_ = false;
  std::shared_ptr<BridgeCall> self_;  // until the call is over
};

}  // namespace cwm::server
