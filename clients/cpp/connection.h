// A connection to a server, with the stubs of its services.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "clients/cpp/call_error.h"
#include "cwm/v1/admin.grpc.pb.h"
#include "cwm/v1/perception.grpc.pb.h"
#include "cwm/v1/query.grpc.pb.h"
#include "cwm/v1/robot.grpc.pb.h"
#include "cwm/v1/world.grpc.pb.h"
#include "proto/transfer/default_address.h"

namespace cwm::client {

struct ConnectOptions {
  std::string address = {};  // "unix:PATH" or "HOST:PORT"; empty: DefaultAddress(), checked
  // For every unary call and upload; empty: no deadline.
  std::optional<std::chrono::milliseconds> deadline = {};
};

// Cheap to construct: the network is used by the first call. Thread safe. All calls share one
// socket, so calls that must not wait behind large messages need a connection of their own. Without
// an address in the options, every call fails with the error of PrepareDefaultAddress() if another
// user could answer there.
class Connection {
 public:
  explicit Connection(ConnectOptions options);

  // In the form that is dialed, the default address included.
  const std::string& address() const { return options_.address; }
  const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

  cwm::v1::WorldService::Stub& worlds() const { return *worlds_; }
  cwm::v1::PerceptionService::Stub& perception() const { return *perception_; }
  cwm::v1::QueryService::Stub& queries() const { return *queries_; }
  cwm::v1::RobotService::Stub& robots() const { return *robots_; }
  cwm::v1::AdminService::Stub& admin() const { return *admin_; }

  // The same connection with another deadline of its calls.
  Connection WithDeadline(std::optional<std::chrono::milliseconds> deadline) const;

  // Sets the deadline of the options.
  void Prepare(grpc::ClientContext& context) const;

  // One unary call:
  //   connection.Call(&WorldService::Stub::GetObject, connection.worlds(), request)
  template <class Stub, class Request, class Response>
  absl::StatusOr<Response> Call(grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&,
                                                             Response*),
                                Stub& stub, const Request& request) const {
    grpc::ClientContext context;
    Prepare(context);
    Response response;
    const grpc::Status status = (stub.*method)(&context, request, &response);
    if (!status.ok()) return StatusFromGrpc(status);
    return response;
  }

 private:
  Connection(ConnectOptions options, std::shared_ptr<grpc::Channel> channel);

  ConnectOptions options_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<cwm::v1::WorldService::Stub> worlds_;
  std::unique_ptr<cwm::v1::PerceptionService::Stub> perception_;
  std::unique_ptr<cwm::v1::QueryService::Stub> queries_;
  std::unique_ptr<cwm::v1::RobotService::Stub> robots_;
  std::unique_ptr<cwm::v1::AdminService::Stub> admin_;
};

}  // namespace cwm::client
