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

}  // namespace

Connection::Connection(ConnectOptions options)
    : options_(std::move(options)),
      channel_(grpc::CreateCustomChannel(options_.address, grpc::InsecureChannelCredentials(),
                                         Arguments())),
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
