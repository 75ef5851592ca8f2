#include "server/rpc/accept_loop.h"

#include <fcntl.h>
#include <pthread.h>
#include <spdlog/spdlog.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <list>
#include <map>
#include <mutex>
#include <string_view>
#include <thread>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/peer_uid.h"
#include "server/rpc/http2_preface.h"

namespace cwm::server {
namespace {

using User = Connections::User;

// chosen: if no file descriptor is free for a connection, one may be free after this time.
constexpr auto kAcceptPause = std::chrono::milliseconds(50);
// The period at which closed connections are dropped from the table and refusals are logged.
constexpr auto kTick = std::chrono::seconds(1);
// chosen: accepts from one listener before the other listeners and the silent connections have
// their turn.
constexpr int kMaxAcceptsAtOnce = 64;
constexpr int kMaxEvents = 64;

std::string UserName(User user) {
  return user ? absl::StrCat("user ", *user) : std::string("an unknown user");
}

std::string PeerAddressOf(int descriptor) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  return {reinterpret_cast<const char*>(&address), std::min<std::size_t>(size, sizeof(address))};
}

bool IsDescriptorShortage(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

// True for errors of a single connection that ended before it was accepted, or of its network.
bool IsPerConnectionError(int error) {
  return error == EINTR || error == ECONNABORTED || error == EPROTO || error == ENETDOWN ||
         error == ENOPROTOOPT || error == EHOSTDOWN || error == ENONET || error == EHOSTUNREACH ||
         error == EOPNOTSUPP || error == ENETUNREACH || error == EPERM;
}

FileDescriptor OpenReserve() { return FileDescriptor(open("/dev/null", O_RDONLY | O_CLOEXEC)); }

}  // namespace

struct AcceptLoop::State {
  State(std::vector<FileDescriptor> listeners_in, Connections& connections_in,
        std::chrono::milliseconds max_silence_in, HandOver hand_over_in, Allows allows_in)
      : listeners(std::move(listeners_in)),
        connections(connections_in),
        max_silence(max_silence_in),
        hand_over(std::move(hand_over_in)),
        allows(std::move(allows_in)) {}

  struct Silent {
    FileDescriptor connection;
    Clock::time_point close_at;
  };
  using Queue = std::list<Silent>;
  struct SilentEntry {
    User user;
    Queue::iterator silent;
  };

  bool Watch(int descriptor, std::uint32_t events) {
    epoll_event event{};
    event.events = events;
    event.data.fd = descriptor;
    return epoll_ctl(epoll.number(), EPOLL_CTL_ADD, descriptor, &event) == 0;
  }

  bool Prepare() {
    bool is_ready = epoll.is_open() && wake.is_open() && Watch(wake.number(), EPOLLIN);
    for (const FileDescriptor& listener : listeners) {
      is_ready = is_ready && Watch(listener.number(), EPOLLIN);
    }
    return is_ready && reserve.is_open();
  }

  void Wake() const {
    const std::uint64_t one = 1;
    // The counter can only be full if the loop is about to wake anyway.
    [[maybe_unused]] const ssize_t written = write(wake.number(), &one, sizeof(one));
  }

  void Run() {
    pthread_setname_np(pthread_self(), "accept");
    while (!stopping) {
      try {
        TakeTurn();
      } catch (const std::exception& error) {  // out of memory, which may be temporary
        spdlog::error("accepting connections: {}", error.what());
        std::this_thread::sleep_for(kAcceptPause);
      }
    }
    while (!silent_by_user.empty())
      Close(silent_by_user.begin()->first, silent_by_user.begin()->second.begin());
  }

  void TakeTurn() {
    std::array<epoll_event, kMaxEvents> events;
    const int count = epoll_wait(epoll.number(), events.data(), kMaxEvents, Timeout_ms());
    for (int i = 0; i < count; ++i) HandleEvent(events[static_cast<std::size_t>(i)].data.fd);
    if (stop_listening && is_listening) CloseListeners();
    CloseTooSilent();
    if (is_paused && Clock::now() >= resume_at) Resume();
    if (Clock::now() >= next_tick) Tick();
  }

  int Timeout_ms() const {
    auto until = Clock::time_point::max();
    if (unlogged_count > 0 || connections.open() > 0) until = next_tick;
    if (is_paused) until = std::min(until, resume_at);
    for (const auto& [user, queue] : silent_by_user)
      until = std::min(until, queue.front().close_at);
    if (until == Clock::time_point::max()) return -1;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now());
    return static_cast<int>(std::max<std::int64_t>(left.count(), 0));
  }

  void HandleEvent(int descriptor) {
    if (descriptor == wake.number()) {
      std::uint64_t ignored = 0;
      [[maybe_unused]] const ssize_t size = read(descriptor, &ignored, sizeof(ignored));
      return;
    }
    // A late event of a descriptor that was closed a moment ago finds nobody, or the next
    // connection with that number, which may be checked at any time.
    if (const auto entry = silent_by_descriptor.find(descriptor);
        entry != silent_by_descriptor.end()) {
      return CheckPreface(entry->second.user, entry->second.silent);
    }
    for (const FileDescriptor& listener : listeners) {
      if (listener.number() == descriptor) return Accept(descriptor, kMaxAcceptsAtOnce);
    }
  }

  void Accept(int listener, int max_count) {
    for (int i = 0; i < max_count; ++i) {
      FileDescriptor connection(accept4(listener, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
      if (connection.is_open()) {
        Admit(std::move(connection));
        continue;
      }
      const int error = errno;
      if (error == EAGAIN) return;
      if (IsPerConnectionError(error)) continue;
      if (IsDescriptorShortage(error)) {
        ShedWithReserve(listener);
      } else {
        Shed(0, absl::StrCat("accept: ", std::strerror(error)));
      }
      return Pause();
    }
  }

  // Accepts and closes a waiting connection with the reserve descriptor, so that its client learns
  // of the refusal at once.
  void ShedWithReserve(int listener) {
    reserve.Close();
    const FileDescriptor connection(accept4(listener, nullptr, nullptr, SOCK_CLOEXEC));
    if (connection.is_open()) Shed(1, "the process has no file descriptor left");
  }

  void Pause() {
    if (!reserve.is_open()) reserve = OpenReserve();
    is_paused = true;
    resume_at = Clock::now() + kAcceptPause;
    SetListenerEvents(0);
  }

  void Resume() {
    if (!reserve.is_open()) reserve = OpenReserve();
    is_paused = false;
    SetListenerEvents(EPOLLIN);
  }

  void SetListenerEvents(std::uint32_t events) {
    for (const FileDescriptor& listener : listeners) {
      epoll_event event{};
      event.events = events;
      event.data.fd = listener.number();
      epoll_ctl(epoll.number(), EPOLL_CTL_MOD, listener.number(), &event);
    }
  }

  bool IsExempt(int descriptor) {
    const std::lock_guard lock(mutex);
    return !exempt_peer.empty() && PeerAddressOf(descriptor) == exempt_peer;
  }

  void Admit(FileDescriptor connection) {
    const User user = PeerUid(connection.number());
    if (allows && !allows(connection.number(), user)) {
      return Shed(1, absl::StrCat(UserName(user),
                                  " is another user of the machine (--allow-any-local-user)"));
    }
    if (IsExempt(connection.number())) {
      connections.AdmitAlways(user);
    } else {
      const auto of_user = silent_by_user.find(user);
      const auto count = of_user == silent_by_user.end() ? 0 : of_user->second.size();
      if (static_cast<std::int64_t>(count) >= connections.limits().silent_of_user) {
        CloseOldestSilent(user, "connections that are silent");
      }
      if (!connections.TryAdmit(user) &&
          !(CloseOldestSilent(user, "connections") && connections.TryAdmit(user))) {
        return Shed(1, absl::StrCat(UserName(user), " or all together have as many as may be"));
      }
    }
    const int descriptor = connection.number();
    Queue& queue = silent_by_user[user];
    queue.push_back({std::move(connection), Clock::now() + max_silence});
    const auto position = std::prev(queue.end());
    silent_by_descriptor[descriptor] = {user, position};
    // Edge-triggered, since the received bytes are left in the socket.
    if (!Watch(descriptor, EPOLLIN | EPOLLRDHUP | EPOLLET)) {
      Close(user, position);
      return Shed(1, absl::StrCat("epoll: ", std::strerror(errno)));
    }
    CheckPreface(user, position);
  }

  void CheckPreface(User user, Queue::iterator silent) {
    std::array<char, kHttp2PrefaceAndHeaderBytes> received;
    const int descriptor = silent->connection.number();
    const ssize_t size =
        recv(descriptor, received.data(), received.size(), MSG_PEEK | MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (size <= 0) return Close(user, silent);  // the peer has closed the connection
    const auto beginning =
        CheckHttp2Preface(std::string_view(received.data(), static_cast<std::size_t>(size)));
    if (beginning == Http2PrefaceState::kIncomplete) return;
    if (beginning == Http2PrefaceState::kWrong) {
      Close(user, silent);
      return Shed(1, absl::StrCat(UserName(user), " does not speak HTTP/2"));
    }
    epoll_ctl(epoll.number(), EPOLL_CTL_DEL, descriptor, nullptr);
    FileDescriptor connection = Remove(user, silent);
    hand_over(connections.Register(std::move(connection), user));
  }

  FileDescriptor Remove(User user, Queue::iterator silent) {
    FileDescriptor connection = std::move(silent->connection);
    silent_by_descriptor.erase(connection.number());
    Queue& queue = silent_by_user.at(user);
    queue.erase(silent);
    if (queue.empty()) silent_by_user.erase(user);
    return connection;
  }

  void Close(User user, Queue::iterator silent) {
    Remove(user, silent).Close();
    connections.CancelAdmission(user);
  }

  bool CloseOldestSilent(User user, const char* what) {
    const auto queue = silent_by_user.find(user);
    if (queue == silent_by_user.end()) return false;
    Close(user, queue->second.begin());
    Shed(1, absl::StrCat(UserName(user), " has too many ", what));
    return true;
  }

  void CloseTooSilent() {
    const auto now = Clock::now();
    std::vector<User> users;
    for (const auto& [user, queue] : silent_by_user) {
      if (queue.front().close_at <= now) users.push_back(user);
    }
    for (const User user : users) {
      for (auto queue = silent_by_user.find(user);
           queue != silent_by_user.end() && queue->second.front().close_at <= now;
           queue = silent_by_user.find(user)) {
        Close(user, queue->second.begin());
        Shed(1, absl::StrCat(UserName(user), " said nothing for ", max_silence.count(), " ms"));
      }
    }
  }

  void CloseListeners() {
    for (FileDescriptor& listener : listeners) {
      // Connections in the kernel's backlog were made before the end, so they are still accepted.
      Accept(listener.number(), SOMAXCONN);
      listener.Close();
    }
    listeners.clear();
    is_listening = false;
    const std::lock_guard lock(mutex);
    has_stopped_listening = true;
    changed.notify_all();
  }

  void Shed(std::int64_t count, std::string why) {
    connections.CountShed(count);
    if (unlogged_count++ == 0) why_shed = std::move(why);
  }

  void Tick() {
    next_tick = Clock::now() + kTick;
    connections.DropClosed();
    if (unlogged_count == 0) return;
    spdlog::warn("connections refused or closed: {}, the first because {}; {} are open",
                 unlogged_count, why_shed, connections.open());
    unlogged_count = 0;
  }

  std::vector<FileDescriptor> listeners;
  Connections& connections;
  const std::chrono::milliseconds max_silence;
  const HandOver hand_over;
  const Allows allows;
  FileDescriptor epoll{epoll_create1(EPOLL_CLOEXEC)};
  FileDescriptor wake{eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  FileDescriptor reserve = OpenReserve();

  // Members used only by the loop's thread.
  std::map<User, Queue> silent_by_user;  // silent connections in order of arrival
  std::unordered_map<int, SilentEntry>
      silent_by_descriptor;  // of silent connections, by descriptor
  bool is_listening = true;
  bool is_paused = false;
  Clock::time_point resume_at;
  Clock::time_point next_tick = Clock::now() + kTick;
  std::int64_t unlogged_count = 0;  // refusals not logged yet
  std::string why_shed;             // the reason of the first of them

  std::atomic<bool> stop_listening = false;
  std::atomic<bool> stopping = false;
  std::mutex mutex;
  std::condition_variable changed;
  bool has_stopped_listening = false;
  std::string exempt_peer;
  std::thread thread;  // last: starts when the other members exist
};

absl::StatusOr<std::unique_ptr<AcceptLoop>> AcceptLoop::Start(std::vector<FileDescriptor> listeners,
                                                              Connections& connections,
                                                              std::chrono::milliseconds max_silence,
                                                              HandOver hand_over, Allows allows) {
  auto state = std::make_unique<State>(std::move(listeners), connections, max_silence,
                                       std::move(hand_over), std::move(allows));
  if (!state->Prepare()) {
    return absl::UnavailableError(
        absl::StrCat("cannot accept connections: ", std::strerror(errno)));
  }
  state->thread = std::thread([loop = state.get()] { loop->Run(); });
  return std::unique_ptr<AcceptLoop>(new AcceptLoop(std::move(state)));
}

AcceptLoop::AcceptLoop(std::unique_ptr<State> state) : state_(std::move(state)) {}

AcceptLoop::~AcceptLoop() { Stop(); }

void AcceptLoop::ExemptPeer(std::string peer_address) {
  const std::lock_guard lock(state_->mutex);
  state_->exempt_peer = std::move(peer_address);
}

void AcceptLoop::StopListening() {
  state_->stop_listening = true;
  state_->Wake();
  std::unique_lock lock(state_->mutex);
  state_->changed.wait(lock, [this] { return state_->has_stopped_listening; });
}

void AcceptLoop::Stop() {
  if (!state_->thread.joinable()) return;
  StopListening();
  state_->stopping = true;
  state_->Wake();
  state_->thread.join();
}

}  // namespace cwm::server
