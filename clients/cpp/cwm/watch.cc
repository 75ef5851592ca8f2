#include "cwm/watch.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"
#include "cwm/internal/session.h"
#include "cwm/internal/world_messages.h"
#include "cwm/world.h"

namespace cwm::CWM_API {
namespace {

using Clock = std::chrono::steady_clock;
using Pause = std::chrono::milliseconds;

// chosen: delays between attempts to reach the server again.
constexpr Pause kFirstPause(100), kMaxPause(2'000);

Event EventFrom(const v1::ObjectEvent& message) {
  if (message.has_put()) return ObjectPut{internal::FromMessage(message.put())};
  if (!message.has_move()) return ObjectRemoved{message.remove()};
  return ObjectMoved{.name = message.move().name(),
                     .X_WO = internal::FromMessage(message.move().x_world_object()),
                     .pose_revision = message.pose_revision(),
                     .motion = static_cast<Motion>(message.motion())};
}

SensorFacts FactsFrom(const v1::SensorFacts& message) {
  SensorFacts facts{.motion = static_cast<Motion>(message.motion()),
                    .visibility = static_cast<Visibility>(message.visibility())};
  if (message.has_identity_certain()) facts.identity_certain = message.identity_certain();
  facts.carried_by = message.carried_by();
  return facts;
}

Event EventFrom(const v1::RobotEvent& message) {
  if (message.has_put()) return RobotPut{internal::FromMessage(message.put())};
  if (!message.has_state()) return RobotRemoved{message.remove()};
  const v1::RobotStateEvent& state = message.state();
  return RobotMoved{
      .name = state.name(),
      .X_WB = internal::FromMessage(state.x_world_base()),
      .state = Eigen::Map<const Eigen::VectorXd>(state.state().data(), state.state_size()),
      .state_revision = state.state_revision()};
}

}  // namespace

// The call WatchWorld, made again after the last revision that was told whole whenever it is lost.
class Watcher::Call {
 public:
  Call(std::shared_ptr<internal::Session> session, const std::string& world,
       const WatchOptions& options)
      : session_(std::move(session)), give_up_after_s_(options.give_up_after_s) {
    request_.set_world(world);
    request_.set_world_uid(options.world_uid);
    if (options.from_revision) request_.set_from_revision(*options.from_revision);
    request_.set_mode(options.coalesced ? v1::WATCH_MODE_COALESCED : v1::WATCH_MODE_LOSSLESS);
    request_.set_view(static_cast<v1::ObjectView>(options.view));
    begun_ = options.from_revision.has_value();
  }
  ~Call() {
    Close();
    static_cast<void>(End());  // a cancelled call has no error to tell
  }

  std::optional<WatchEvent> Next() {
    while (!closed_) {
      if (!reader_ && !Begin()) break;
      v1::WatchWorldResponse message;
      if (!reader_->Read(&message)) {
        const absl::Status status = End();
        if (!closed_) Recover(status);
        continue;
      }
      lost_at_.reset();
      pause_ = kFirstPause;
      if (auto event = EventOf(message)) return event;
    }
    return std::nullopt;
  }

  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    if (context_) context_->TryCancel();
    closing_.notify_all();
  }

 private:
  // False if the watch was closed meanwhile.
  bool Begin() {
    const std::lock_guard lock(mutex_);
    if (closed_) return false;
    initial_.reset();
    pending_.clear();
    context_ = std::make_unique<grpc::ClientContext>();
    reader_ = session_->connection.worlds().WatchWorld(context_.get(), request_);
    return true;
  }

  // Ends the present call.
  absl::Status End() {
    if (!reader_) return absl::OkStatus();
    absl::Status status = client::StatusFromGrpc(reader_->Finish());
    reader_.reset();
    const std::lock_guard lock(mutex_);
    context_.reset();
    return status;
  }

  std::optional<WatchEvent> EventOf(const v1::WatchWorldResponse& message) {
    if (message.has_initial_state()) return SnapshotOf(message);
    if (message.has_events()) {
      const auto& events = message.events();
      for (const v1::ObjectEvent& event : events.events()) pending_.push_back(EventFrom(event));
      for (const v1::RobotEvent& event : events.robot_events()) {
        pending_.push_back(EventFrom(event));
      }
      for (const v1::PairRule& rule : events.pair_rules()) {
        pending_.push_back(RuleSet{internal::FromMessage(rule)});
      }
      if (events.more()) return std::nullopt;
      SetTold(message);
      return Changes{.world_uid = message.world_uid(),
                     .revision = message.revision(),
                     .events = std::exchange(pending_, {})};
    }
    // In the middle of a revision a bookmark says nothing about it.
    if (!pending_.empty() || initial_) return std::nullopt;
    SetTold(message);
    Bookmark bookmark{.world_uid = message.world_uid(), .revision = message.revision()};
    for (const auto& [name, stamp] : message.bookmark().last_observed()) {
      bookmark.last_observed[name] = internal::FromMessage(stamp);
    }
    for (const auto& [name, facts] : message.bookmark().facts()) {
      bookmark.facts[name] = FactsFrom(facts);
    }
    return bookmark;
  }

  std::optional<WatchEvent> SnapshotOf(const v1::WatchWorldResponse& message) {
    if (!initial_) initial_ = Snapshot{.world_uid = {}, .revision = 0};
    const auto& state = message.initial_state();
    for (const v1::Object& object : state.objects()) {
      initial_->objects.push_back(internal::FromMessage(object));
    }
    for (const v1::Robot& robot : state.robots()) {
      initial_->robots.push_back(internal::FromMessage(robot));
    }
    for (const v1::PairRule& rule : state.pair_rules()) {
      initial_->rules.push_back(internal::FromMessage(rule));
    }
    if (!state.initial_state_done()) return std::nullopt;
    Snapshot snapshot = *std::exchange(initial_, std::nullopt);
    snapshot.world_uid = message.world_uid();
    snapshot.revision = message.revision();
    snapshot.anew = std::exchange(anew_, {});
    SetTold(message);
    return snapshot;
  }

  // A lost connection goes on from here.
  void SetTold(const v1::WatchWorldResponse& message) {
    begun_ = true;
    request_.set_world_uid(message.world_uid());
    request_.set_from_revision(message.revision());
  }

  void BeginAnew(std::string why) {
    anew_ = std::move(why);
    request_.clear_from_revision();
    request_.clear_world_uid();
  }

  // Prepares the next call, or throws.
  void Recover(const absl::Status& status) {
    const std::string reason = client::DetailsOf(status).reason;
    if (reason == "WORLD_REPLACED") {
      return BeginAnew("the world was replaced: the server was restarted, or the world deleted");
    }
    if (reason == "REVISION_COMPACTED") {
      return BeginAnew(absl::StrCat("the server no longer keeps what happened since: ",
                                    std::string(status.message())));
    }
    // A restarted server does not have the world until somebody creates it again.
    const bool waits_for_world = lost_at_.has_value() && reason == "WORLD_UNKNOWN";
    // The client did not cancel, so the server is shutting down, as it is if it ends without error.
    const bool is_lost = status.ok() || absl::IsUnavailable(status) || absl::IsCancelled(status) ||
                         reason == "WATCH_TOO_SLOW";
    const auto now = Clock::now();
    if (!lost_at_) lost_at_ = now;
    const bool gives_up =
        give_up_after_s_ && now - *lost_at_ > std::chrono::duration<double>(*give_up_after_s_);
    if (!(is_lost || waits_for_world) || !begun_ || gives_up) {
      closed_ = true;
      internal::Throw(status.ok() ? absl::UnavailableError("the server ended the watch") : status,
                      session_->connection);
    }
    std::unique_lock lock(mutex_);
    closing_.wait_for(lock, pause_, [&] { return closed_.load(); });
    pause_ = std::min(2 * pause_, kMaxPause);
  }

  const std::shared_ptr<internal::Session> session_;
  v1::WatchWorldRequest request_;
  const std::optional<double> give_up_after_s_;
  std::mutex mutex_;  // of context_
  std::condition_variable closing_;
  std::atomic<bool> closed_ = false;
  std::unique_ptr<grpc::ClientContext> context_;
  std::unique_ptr<grpc::ClientReader<v1::WatchWorldResponse>> reader_;
  std::optional<Clock::time_point> lost_at_;
  Pause pause_ = kFirstPause;
  std::string anew_;
  bool begun_ = false;
  std::optional<Snapshot> initial_;  // as far as it arrived
  std::vector<Event> pending_;       // of a revision that is not complete yet
};

Watcher::Watcher(std::unique_ptr<Call> call) : call_(std::move(call)) {}
Watcher::~Watcher() = default;
Watcher::Watcher(Watcher&&) noexcept = default;
Watcher& Watcher::operator=(Watcher&&) noexcept = default;

std::optional<WatchEvent> Watcher::Next() { return call_->Next(); }
void Watcher::Close() { call_->Close(); }

Watcher World::Watch(const WatchOptions& options) const {
  if (options.from_revision.value_or(0) > 0 && options.world_uid.empty()) {
    internal::ThrowBadArgument("options.world_uid",
                               "is empty, must be that of the world whose revision from_revision "
                               "is");
  }
  return Watcher(std::make_unique<Watcher::Call>(view().session, view().world, options));
}

}  // namespace cwm::CWM_API
