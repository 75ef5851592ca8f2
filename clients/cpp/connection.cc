#include "clients/cpp/connection.h"

#include <grpc/grpc.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

#include <mutex>

#include "proto/transfer/chunks.h"

namespace cwm::client {
namespace {

// The server answers pings of idle watches; 30 s notices a lost peer without waking a laptop much.
constexpr int kKeepaliveMs = 30'000;

// gRPC cleans up after the last of its objects, and waits there for up to 10 s (1.51): for a poll
// that a message has left behind which the socket did not take at once. It is kept for the process.
void KeepLibrary() {
  static std::once_flag once;
  std::call_once(once, grpc_init);
}

grpc::ChannelArguments Arguments() {
  KeepLibrary();
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  arguments.SetMaxSendMessageSize(kMaxMessageBytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveMs);
  // A proxy is for the web, not for a socket beside us.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  // A socket for each connection: small calls over one do not wait behind megabytes of another's.
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  return arguments;
}

// A channel on which every call ends with `status`.
std::shared_ptr<grpc::Channel> FailingChannel(const std::string& address,
                                              const absl::Status& status) {
  KeepLibrary();
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

Connection::Connection(ConnectOptions options)
    : options_(std::move(options)),
      channel_(MakeChannel(options_.address)),
      worlds_(cwm::v1::WorldService::NewStub(channel_)),
      perception_(cwm::v1::PerceptionService::NewStub(channel_)),
      queries_(cwm::v1::QueryService::NewStub(channel_)),
      robots_(cwm::v1::RobotService::NewStub(channel_)),
      admin_(cwm::v1::AdminService::NewStub(channel_)) {}

void Connection::Prepare(grpc::ClientContext& context) const {
  if (options_.deadline) {
    context.set_deadline(std::chrono::system_clock::now() + *options_.deadline);
  }
}

}  // namespace cwm::client
