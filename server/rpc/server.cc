#include "server/rpc/server.h"

#include <grpc/grpc.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "grpc/health/v1/health.pb.h"
#include "server/rpc/admin_service.h"
#include "server/rpc/call_interceptor.h"
#include "server/rpc/listen_address.h"
#include "server/rpc/perception_service.h"
#include "server/rpc/query_service.h"
#include "server/rpc/robot_service.h"
#include "server/rpc/socket_lock.h"
#include "server/rpc/world_service.h"

namespace cwm::server {
namespace {

// An idle watch is noticed as dead within 40 s; clients may ping every 10 s, also without calls.
constexpr int kKeepaliveTime_ms = 30'000;
constexpr int kKeepaliveTimeout_ms = 10'000;
constexpr int kClientPingPeriod_ms = 10'000;
// Streams that drain end at once; only one whose client does not read takes longer.
constexpr auto kStreamsEndWithin = std::chrono::milliseconds(500);

void SetChannelArguments(const Limits& limits, grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(static_cast<int>(limits.max_message_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE,
                             static_cast<int>(limits.max_metadata_bytes));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepaliveTime_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepaliveTimeout_ms);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                             kClientPingPeriod_ms);
  // Two servers on one port would share its clients between two different worlds.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
}

// Sockets that are made while it lives are the user's alone.
class PrivateUmask {
 public:
  PrivateUmask() : before_(umask(0177)) {}
  ~PrivateUmask() { umask(before_); }
  PrivateUmask(const PrivateUmask&) = delete;
  PrivateUmask& operator=(const PrivateUmask&) = delete;

 private:
  const mode_t before_;
};

// gRPC cleans up after the last of its objects, and waits there for up to 10 s (1.51): for a poll
// that a message has left behind which the socket did not take at once. It is kept for the process.
void KeepLibrary() {
  static std::once_flag once;
  std::call_once(once, grpc_init);
}

struct BoundAddress {
  std::string address;
  std::string binding;  // what gRPC is given
  int port = 0;         // 0 for a Unix socket, and for one that could not be bound
};

bool IsUnix(const std::string& address) { return address.starts_with("unix:"); }

// What a client dials: the port that was picked in the place of 0.
std::string Dialable(const BoundAddress& bound) {
  if (IsUnix(bound.address)) return bound.address;
  return absl::StrCat(bound.address.substr(0, bound.address.rfind(':') + 1), bound.port);
}

// Of all Unix sockets among the addresses, each once and in one order for everybody: two servers
// that ask for the same in another order do not wait for each other for ever.
absl::StatusOr<std::vector<SocketLock>> LockSockets(const std::vector<std::string>& addresses) {
  std::set<std::string> paths;
  for (const std::string& address : addresses) {
    if (const auto path = SocketPath(address)) paths.insert(*path);
  }
  std::vector<SocketLock> locks;
  for (const std::string& path : paths) {
    auto lock = SocketLock::Take(path);
    if (!lock.ok()) return lock.status();
    locks.push_back(*std::move(lock));
  }
  return locks;
}

}  // namespace

struct Server::State {
  explicit State(Application& application) : runtime(application) {}

  absl::Status Start(const ListenOptions& listen);
  void RemoveSockets();

  Runtime runtime;
  AdminService admin{runtime};
  PerceptionService perception{runtime};
  QueryService query{runtime};
  RobotService robot{runtime};
  WorldService world{runtime};
  std::vector<std::string> addresses;
  std::vector<std::pair<std::string, SocketFile>> sockets;  // that it made
  std::unique_ptr<grpc::Server> grpc;                       // last: ends before what it calls
};

absl::Status Server::State::Start(const ListenOptions& listen) {
  KeepLibrary();
  grpc::EnableDefaultHealthCheckService(true);
  // The library serves health without a descriptor; naming ours links it, so that reflection tells
  // it.
  grpc::health::v1::HealthCheckRequest::descriptor();
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetChannelArguments(runtime.application.limits, builder);
  builder.experimental().SetInterceptorCreators(CallInterceptors(runtime.log));
  std::vector<BoundAddress> bound(listen.addresses.size());
  for (std::size_t i = 0; i < bound.size(); ++i) {
    auto address = CheckListenAddress(listen.addresses[i]);
    if (!address.ok()) return address.status();
    bound[i].address = *address;
    bound[i].binding = BindingAddress(*address);
    builder.AddListeningPort(bound[i].binding, grpc::InsecureServerCredentials(), &bound[i].port);
  }
  const auto locks = LockSockets(listen.addresses);  // until it listens
  if (!locks.ok()) return locks.status();
  for (const BoundAddress& address : bound) {
    if (auto status = CheckVacant(address.address); !status.ok()) return status;
  }
  for (grpc::Service* service :
       std::initializer_list<grpc::Service*>{&admin, &perception, &query, &robot, &world}) {
    builder.RegisterService(service);
  }
  {
    const PrivateUmask umask;
    grpc = builder.BuildAndStart();
  }
  if (grpc == nullptr) {
    return absl::UnavailableError(
        "cannot listen on all of the addresses: is one in use, or its folder missing?");
  }
  for (const BoundAddress& address : bound) {
    if (auto status = MoveIntoPlace(address.binding, address.address); !status.ok()) return status;
    addresses.push_back(Dialable(address));
    if (const auto file = FindSocket(address.address)) sockets.emplace_back(address.address, *file);
  }
  grpc->GetHealthCheckService()->SetServingStatus(true);
  for (const char* name : {"cwm.v1.AdminService", "cwm.v1.PerceptionService", "cwm.v1.QueryService",
                           "cwm.v1.RobotService", "cwm.v1.WorldService"}) {
    grpc->GetHealthCheckService()->SetServingStatus(name, true);
  }
  return absl::OkStatus();
}

void Server::State::RemoveSockets() {
  for (const auto& [address, file] : sockets) RemoveSocket(address, file);
  sockets.clear();
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(Application& application,
                                                      const ListenOptions& listen) {
  auto state = std::make_unique<State>(application);
  if (auto status = state->Start(listen); !status.ok()) {
    state->RemoveSockets();
    return status;
  }
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() { Stop(std::chrono::milliseconds(0)); }

const std::vector<std::string>& Server::addresses() const { return state_->addresses; }

std::shared_ptr<grpc::Channel> Server::InProcessChannel() const {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  return state_->grpc->InProcessChannel(arguments);
}

void Server::Stop(std::chrono::milliseconds grace) {
  if (state_->grpc == nullptr) return;
  state_->grpc->GetHealthCheckService()->SetServingStatus(false);
  state_->runtime.Drain();
  // A connection that closes with its last stream can take the stream's status with it: a client
  // that writes at that moment fails and does not read what is left. So the streams end first; then
  // gRPC's farewell waits for the client to answer. What still works then ends by itself, while a
  // successor may already listen.
  const auto end = Clock::now() + grace;
  state_->runtime.open_streams.WaitUntilNone(std::min(grace, kStreamsEndWithin));
  state_->grpc->Shutdown(std::chrono::system_clock::now() + (end - Clock::now()));
  state_->grpc->Wait();
  state_->grpc = nullptr;
  state_->RemoveSockets();
}

}  // namespace cwm::server
