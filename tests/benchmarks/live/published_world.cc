#include "tests/benchmarks/live/published_world.h"

#include <utility>

namespace cwm::benchmarks {
namespace {

constexpr auto kPatience = std::chrono::seconds(10);

}  // namespace

PublishedWorld::PublishedWorld(const std::string& address, const std::string& world)
    : connection_({.address = address, .deadline = std::nullopt}),
      thread_([this, world] { Run(world); }) {}

PublishedWorld::~PublishedWorld() {
  context_.TryCancel();
  thread_.join();
}

void PublishedWorld::Run(const std::string& world) {
  v1::WatchWorldRequest request;
  request.set_world(world);
  const auto watch = connection_.worlds().WatchWorld(&context_, request);
  v1::WatchWorldResponse message;
  while (watch->Read(&message)) {
    const std::lock_guard lock(mutex_);
    Take(message);
    advanced_.notify_all();
  }
  static_cast<void>(watch->Finish());  // it ends by being cancelled
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  advanced_.notify_all();
}

void PublishedWorld::Take(const v1::WatchWorldResponse& message) {
  for (const v1::Object& object : message.initial_state().objects()) {
    newest_[object.name()] = std::make_shared<const v1::Object>(object);
  }
  if (message.has_initial_state() && !message.initial_state().initial_state_done()) return;
  if (message.has_events()) event_bytes_ += static_cast<std::int64_t>(message.ByteSizeLong());
  for (const v1::ObjectEvent& event : message.events().events()) {
    if (event.has_put()) {
      newest_[event.put().name()] = std::make_shared<const v1::Object>(event.put());
    } else if (event.has_move()) {
      const auto known = newest_.find(event.move().name());
      if (known == newest_.end()) continue;
      auto moved = std::make_shared<v1::Object>(*known->second);
      *moved->mutable_x_world_object() = event.move().x_world_object();
      moved->set_motion(event.motion());
      moved->set_pose_revision(event.pose_revision());
      known->second = std::move(moved);
    } else {
      newest_.erase(event.remove());
    }
  }
  if (message.events().more()) return;
  by_revision_[message.revision()] = newest_;
  revision_ = message.revision();
}

bool PublishedWorld::WaitFor(std::int64_t revision) {
  std::unique_lock lock(mutex_);
  advanced_.wait_for(lock, kPatience, [&] { return is_over_ || revision_ >= revision; });
  return revision_ >= revision;
}

PublishedObjects PublishedWorld::At(std::int64_t revision) const {
  const std::lock_guard lock(mutex_);
  const auto after = by_revision_.upper_bound(revision);
  return after == by_revision_.begin() ? PublishedObjects() : std::prev(after)->second;
}

std::int64_t PublishedWorld::event_bytes() const {
  const std::lock_guard lock(mutex_);
  return event_bytes_;
}

}  // namespace cwm::benchmarks
