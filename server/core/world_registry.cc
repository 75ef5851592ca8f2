// All worlds of the server, by name.
#include <algorithm>
#include <map>
#include <mutex>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/core/error.h"
#include "server/core/world.h"

namespace cwm::server {
namespace {

constexpr char kDefaultName[] = "default";
constexpr std::size_t kLongestName = 128;  // fits a file name with room for a suffix

const std::string& Resolve(const std::string& name) {
  static const std::string& kDefault = *new std::string(kDefaultName);
  return name.empty() ? kDefault : name;
}

absl::Status CheckName(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  if (name.size() <= kLongestName && std::all_of(name.begin(), name.end(), allowed)) {
    return absl::OkStatus();
  }
  return InvalidField("world",
                      absl::StrCat("is \"", name.substr(0, kLongestName), "\", must be 1 to ",
                                   kLongestName, " letters, digits or \"_-.\""));
}

// 128 random bits from the system: no two worlds of any server share them.
std::string RandomUid() {
  std::random_device bits;
  std::string uid;
  for (int i = 0; i < 4; ++i) absl::StrAppendFormat(&uid, "%08x", bits());
  return uid;
}

}  // namespace

struct WorldRegistry::State {
  const Limits limits;
  const Retention retention;
  const std::function<Clock::time_point()> now;
  mutable std::mutex mutex;
  std::map<std::string, std::shared_ptr<World>> worlds;
  bool draining = false;

  // Under the mutex.
  absl::StatusOr<std::shared_ptr<World>> Find(const std::string& name,
                                              const std::string& uid) const {
    const auto found = worlds.find(Resolve(name));
    if (found == worlds.end()) {
      return MakeError(absl::StatusCode::kNotFound,
                       absl::StrCat("world: there is no \"", Resolve(name), "\""),
                       {.reason = "WORLD_UNKNOWN", .metadata = {{"world", Resolve(name)}}});
    }
    if (!uid.empty() && uid != found->second->uid()) {
      return MakeError(absl::StatusCode::kFailedPrecondition,
                       absl::StrCat("world_uid: is \"", uid, "\", the world \"", Resolve(name),
                                    "\" is now \"", found->second->uid(), "\""),
                       {.reason = "WORLD_REPLACED",
                        .metadata = {{"expected_uid", uid}, {"actual_uid", found->second->uid()}}});
    }
    return found->second;
  }
};

WorldRegistry::WorldRegistry(Limits limits, Retention retention,
                             std::function<Clock::time_point()> now)
    : state_(new State{.limits = limits,
                       .retention = retention,
                       .now = std::move(now),
                       .mutex = {},
                       .worlds = {}}) {}

WorldRegistry::~WorldRegistry() = default;

absl::StatusOr<std::shared_ptr<World>> WorldRegistry::FindOrCreate(const std::string& name) {
  if (const absl::Status valid = CheckName(name); !valid.ok()) return valid;
  std::lock_guard lock(state_->mutex);
  const auto found = state_->worlds.find(Resolve(name));
  if (found != state_->worlds.end()) return found->second;
  if (static_cast<std::int64_t>(state_->worlds.size()) >= state_->limits.max_worlds) {
    return MakeError(absl::StatusCode::kResourceExhausted,
                     absl::StrCat("world: there are ", state_->worlds.size(), ", must be at most ",
                                  state_->limits.max_worlds),
                     {.reason = "TOO_MANY_WORLDS",
                      .metadata = {{"limit", std::to_string(state_->limits.max_worlds)}}});
  }
  auto world = std::make_shared<World>(Resolve(name), RandomUid(), state_->retention, state_->now);
  if (state_->draining) world->Drain();
  state_->worlds.emplace(Resolve(name), world);
  return world;
}

absl::StatusOr<std::shared_ptr<World>> WorldRegistry::Find(const std::string& name,
                                                           const std::string& uid) const {
  std::lock_guard lock(state_->mutex);
  return state_->Find(name, uid);
}

std::vector<std::shared_ptr<World>> WorldRegistry::List() const {
  std::lock_guard lock(state_->mutex);
  std::vector<std::shared_ptr<World>> worlds;
  worlds.reserve(state_->worlds.size());
  for (const auto& [name, world] : state_->worlds) worlds.push_back(world);
  return worlds;
}

absl::StatusOr<std::shared_ptr<World>> WorldRegistry::Delete(const std::string& name,
                                                             const std::string& uid) {
  absl::StatusOr<std::shared_ptr<World>> world = absl::UnknownError("");
  {
    std::lock_guard lock(state_->mutex);
    world = state_->Find(name, uid);
    if (!world.ok()) return world;
    state_->worlds.erase(Resolve(name));
  }
  (*world)->Close();  // waits for the writer's turn: not under our lock
  return world;
}

void WorldRegistry::Drain() {
  {
    std::lock_guard lock(state_->mutex);
    state_->draining = true;
  }
  for (const std::shared_ptr<World>& world : List()) world->Drain();
}

}  // namespace cwm::server
