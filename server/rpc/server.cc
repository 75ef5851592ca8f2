#include "server/rpc/server.h"

#include <grpc/grpc.h>
#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <grpcpp/server_posix.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <set>
#include <thread>
#include <utility>

#include "grpc/health/v1/health.pb.h"
#include "proto/keep_grpc.h"
#include "server/net/may_connect.h"
#include "server/rpc/accept_loop.h"
#include "server/rpc/admin_service.h"
#include "server/rpc/call_interceptor.h"
#include "server/rpc/listen_address.h"
#include "server/rpc/listener.h"
#include "server/rpc/perception_service.h"
#include "server/rpc/query_service.h"
#include "server/rpc/robot_service.h"
#include "server/rpc/self_check.h"
#include "server/rpc/socket_lock.h"
#include "server/rpc/world_service.h"

namespace cwm::server {
namespace {

constexpr int kClientPingPeriod_ms = 10'000;  // clients may ping this often, even without calls
// chosen: a call that came before a drain is refused with its reason within this time.
constexpr auto kTimeToRefuse = std::chrono::milliseconds(100);
// chosen: a call on which nobody works and whose client takes nothing for so long is waiting for
// that client only.
constexpr auto kMaxQuietTime = std::chrono::milliseconds(500);
// chosen: work that is asked to stop notices within this time.
constexpr auto kTimeToStop = std::chrono::milliseconds(500);
// chosen: clients that read notice the end of a connection within this time.
constexpr auto kTimeToReadEnd = std::chrono::milliseconds(50);

void SetChannelArguments(const Application& application, grpc::ServerBuilder& builder) {
  const Limits& limits = application.limits;
  const TransportLimits& transport = application.transport;
  builder.SetMaxReceiveMessageSize(static_cast<int>(limits.max_message_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_METADATA_SIZE,
                             static_cast<int>(limits.max_metadata_bytes));
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS,
                             static_cast<int>(MaxCallsOfConnection(limits)));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS,
                             static_cast<int>(transport.keepalive_time.count()));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS,
                             static_cast<int>(transport.keepalive_timeout.count()));
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS,
                             kClientPingPeriod_ms);
  // gRPC 1.51 inflates a compressed message on its own thread without a limit, so that a thousand
  // bytes become a million. Compressed calls end with UNIMPLEMENTED, as gRPC prescribes.
  for (const auto algorithm : {GRPC_COMPRESS_DEFLATE, GRPC_COMPRESS_GZIP}) {
    builder.SetCompressionAlgorithmSupportStatus(algorithm, false);
  }
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
}

// Locks all Unix sockets among the addresses, each once and in sorted order, so that two servers
// that want the same sockets do not deadlock.
absl::StatusOr<std::vector<SocketLock>> LockSockets(const std::vector<std::string>& addresses) {
  std::set<std::string> paths;
  for (const std::string& address : addresses) {
    if (const auto path = SocketPath(address)) paths.insert(*path);
  }
  std::vector<SocketLock> locks;
  for (const std::string& path : paths) {
    auto lock = SocketLock::Acquire(path);
    if (!lock.ok()) return lock.status();
    locks.push_back(*std::move(lock));
  }
  return locks;
}

bool IsUnixSocket(int descriptor) {
  sockaddr_storage own{};
  socklen_t size = sizeof(own);
  return getsockname(descriptor, reinterpret_cast<sockaddr*>(&own), &size) == 0 &&
         own.ss_family == AF_UNIX;
}

}  // namespace

struct Server::State {
  explicit State(Application& application) : runtime(application) {}

  absl::Status Start(const ListenOptions& listen);
  absl::Status StartGrpc();
  absl::Status StartListening(const ListenOptions& listen);
  void SetHealth(bool is_serving);
  void RemoveSockets();
  void EndCalls(Clock::time_point begun, std::chrono::milliseconds grace);

  Runtime runtime;
  AdminService admin{runtime};
  PerceptionService perception{runtime};
  QueryService query{runtime};
  RobotService robot{runtime};
  WorldService world{runtime};
  std::vector<std::string> addresses;
  std::vector<std::pair<std::string, SocketFile>> sockets;  // created by this server
  std::unique_ptr<grpc::Server> grpc;                       // ends before the services it calls
  std::unique_ptr<AcceptLoop> accept_loop;  // last: ends before the server it hands connections to
};

absl::Status Server::State::Start(const ListenOptions& listen) {
  for (const std::string& address : listen.addresses) {
    if (auto checked = CheckListenAddress(address); !checked.ok()) return checked.status();
  }
  const auto locks = LockSockets(listen.addresses);  // held until it listens
  if (!locks.ok()) return locks.status();
  for (const std::string& address : listen.addresses) {
    if (auto status = CheckVacant(address); !status.ok()) return status;
  }
  if (auto status = StartGrpc(); !status.ok()) return status;
  return StartListening(listen);
}

absl::Status Server::State::StartGrpc() {
  KeepGrpcInitialized();
  grpc::EnableDefaultHealthCheckService(true);
  // The library serves health without its descriptor; using the descriptor links it, so that
  // reflection lists it.
  grpc::health::v1::HealthCheckRequest::descriptor();
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetChannelArguments(runtime.application, builder);
  builder.experimental().SetInterceptorCreators(CallInterceptors(runtime));
  for (grpc::Service* service :
       std::initializer_list<grpc::Service*>{&admin, &perception, &query, &robot, &world}) {
    builder.RegisterService(service);
  }
  grpc = builder.BuildAndStart();
  if (grpc == nullptr) return absl::UnavailableError("gRPC does not start");
  SetHealth(runtime.application.gate.is_open());
  return absl::OkStatus();
}

absl::Status Server::State::StartListening(const ListenOptions& listen) {
  const TransportLimits& limits = runtime.application.transport;
  std::vector<FileDescriptor> listeners;
  for (const std::string& address : listen.addresses) {
    auto listener = Listen(address, limits.keepalive_timeout);
    if (!listener.ok()) return listener.status();
    addresses.push_back(listener->address);
    if (const auto file = FindSocket(address)) sockets.emplace_back(address, *file);
    std::move(listener->sockets.begin(), listener->sockets.end(), std::back_inserter(listeners));
  }
  auto loop = AcceptLoop::Start(
      std::move(listeners), runtime.connections, limits.max_silence,
      [this](int descriptor) { grpc::AddInsecureChannelFromFd(grpc.get(), descriptor); },
      [allow_any = listen.allow_any_local_user](int descriptor, Connections::User user) {
        return IsUnixSocket(descriptor) || MayConnect(user, geteuid(), allow_any);
      });
  if (!loop.ok()) return loop.status();
  accept_loop = *std::move(loop);
  return absl::OkStatus();
}

void Server::State::SetHealth(bool is_serving) {
  grpc::HealthCheckServiceInterface& health = *grpc->GetHealthCheckService();
  health.SetServingStatus(is_serving);
  for (const char* name : {"cwm.v1.AdminService", "cwm.v1.PerceptionService", "cwm.v1.QueryService",
                           "cwm.v1.RobotService", "cwm.v1.WorldService"}) {
    health.SetServingStatus(name, is_serving);
  }
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
    if (state->grpc != nullptr) state->grpc->Shutdown();
    return status;
  }
  return std::unique_ptr<Server>(new Server(std::move(state)));
}

Server::Server(std::unique_ptr<State> state) : state_(std::move(state)) {}

Server::~Server() { Stop(std::chrono::milliseconds(0)); }

void Server::OpenGate() {
  state_->runtime.application.gate.Open();
  state_->SetHealth(true);
}

const std::vector<std::string>& Server::addresses() const { return state_->addresses; }

std::shared_ptr<grpc::Channel> Server::InProcessChannel() const {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetMaxSendMessageSize(-1);
  return state_->grpc->InProcessChannel(arguments);
}

absl::Status Server::CheckItself(std::chrono::milliseconds timeout) const {
  if (state_->accept_loop == nullptr || state_->addresses.empty()) return absl::OkStatus();
  AcceptLoop& loop = *state_->accept_loop;
  const absl::Status status =
      CheckHealth(state_->addresses.front(), timeout,
                  [&loop](std::string own_address) { loop.ExemptPeer(std::move(own_address)); });
  loop.ExemptPeer("");  // the address may belong to another client from now on
  return status;
}

void Server::State::EndCalls(Clock::time_point begun, std::chrono::milliseconds grace) {
  OpenCalls& calls = runtime.open_calls;
  const auto is_busy = [this] { return runtime.IsBusy(); };
  if (!calls.WaitUntilNone(begun + grace, kMaxQuietTime, is_busy)) {
    calls.RequestStop();
    calls.WaitUntilNone(Clock::now() + std::min(grace, kTimeToStop), kTimeToRefuse, is_busy);
  }
  if (runtime.connections.open() == 0) return;
  std::this_thread::sleep_until(begun + std::min(grace, kTimeToRefuse));
}

// gRPC's own shutdown waits for an answer of every client, and an idle client does not read for
// seconds; a call that arrives meanwhile ends with CANCELLED and no reason. So the connections are
// closed here once the calls have ended, in two steps, since a client that writes to a closed
// socket fails and loses the answers that it has not read yet.
void Server::Stop(std::chrono::milliseconds grace) {
  if (state_->grpc == nullptr) return;
  const auto begun = Clock::now();
  state_->SetHealth(false);
  if (state_->accept_loop != nullptr) state_->accept_loop->StopListening();
  state_->runtime.Drain();
  state_->RemoveSockets();
  state_->EndCalls(begun, grace);
  state_->accept_loop = nullptr;
  const Connections& connections = state_->runtime.connections;
  state_->runtime.connections.DropClosed();
  if (connections.open() > 0) {
    connections.ShutDown(SHUT_WR);
    std::this_thread::sleep_for(std::min(grace, kTimeToReadEnd));
    connections.ShutDown(SHUT_RDWR);
  }
  state_->grpc->Shutdown(std::chrono::system_clock::now() + std::min(grace, kTimeToRefuse));
  state_->grpc->Wait();
  state_->grpc = nullptr;
}

}  // namespace cwm::server
