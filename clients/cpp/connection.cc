#include "clients/cpp/connection.h"

#include <grpc/grpc.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include "proto/keep_grpc.h"
#include "proto/transfer/chunks.h"

namespace cwm::client {
namespace {

// chosen: the server answers pings of idle watches; 30 s detects a lost peer without waking a
// laptop often.
constexpr int kKeepaliveMs = 30'000;
// chosen: a restarted local server is back soon.
constexpr int kFirstReconnectMs = 100, kMaxReconnectMs = 2'000;

grpc::ChannelArguments Arguments() {
  KeepGrpcInitialized();
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  arguments.SetMaxSendMessageSize(kMaxMessageBytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, kFirstReconnectMs);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, kMaxReconnectMs);
  // HTTP proxies are for the web, not for a local socket.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // Each connection has a socket of its own, so that small calls do not wait behind another
  // connection's megabytes.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return arguments;
}

// A channel on which every call fails with `status`.
std::shared_ptr<grpc::Channel> FailingChannel(const std::string& address,
                                              const absl::Status& status) {
  KeepGrpcInitialized();
  const std::string message(status.message());
  return grpc::CreateChannelInternal(
      "",
      grpc_lame_client_channel_create(address.c_str(), static_cast<grpc_status_code>(status.code()),
                                      message.c_str()),
      {});
}

// Fills in the default address.
std::shared_ptr<grpc::Channel> MakeChannel(std::string& address) {
  if (address.empty()) {
    address = DefaultAddress();
    if (const absl::Status status = PrepareDefaultAddress(); !status.ok()) {
      return FailingChannel(address, status);
    }
  }
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), Arguments());
}

}  // namespace

Connection::Connection(ConnectOptions options) : Connection(options, nullptr) {}

Connection::Connection(ConnectOptions options, std::shared_ptr<grpc::Channel> channel)
    : options_(std::move(options)),
      channel_(channel ? std::move(channel) : MakeChannel(options_.address)),
      worlds_(cwm::v1::WorldService::NewStub(channel_)),
      perception_(cwm::v1::PerceptionService::NewStub(channel_)),
      queries_(cwm::v1::QueryService::NewStub(channel_)),
      robots_(cwm::v1::RobotService::NewStub(channel_)),
      admin_(cwm::v1::AdminService::NewStub(channel_)) {}

Connection Connection::WithDeadline(std::optional<std::chrono::milliseconds> deadline) const {
  return Connection({.address = options_.address, .deadline = deadline}, channel_);
}

void Connection::Prepare(grpc::ClientContext& context) const {
  if (options_.deadline) {
    context.set_deadline(std::chrono::system_clock::now() + *options_.deadline);
  }
}

}  // namespace cwm::client
