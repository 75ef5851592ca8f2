#include "server/durable_worlds.h"

#include <spdlog/spdlog.h>
#include <unistd.h>

#include <chrono>
#include <ctime>
#include <future>
#include <thread>
#include <utility>

#include "server/core/error.h"
#include "server/core/live/live_commit.h"
#include "server/service_manager.h"
#include "server/store/replay.h"
#include "server/store/sqlite/sqlite_store.h"

namespace cwm::server {
namespace {

// Called by the journal's thread, which cannot go on and must not run the destructors of what other
// threads use.
void EndProcess(const absl::Status& status) {
  const std::string reason(status.message());
  spdlog::critical("the store failed, so the server ends: {}", reason);
  NotifyServiceManager("STATUS=the store failed: " + reason);
  spdlog::default_logger()->flush();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // lets the log's thread write
  _exit(kStoreFailedExitCode);
}

// Tells the service manager how far the start is, and that it may take so long from now on.
void TellStart(const std::string& state, std::chrono::microseconds extension) {
  NotifyServiceManager("STATUS=" + state +
                       "\nEXTEND_TIMEOUT_USEC=" + std::to_string(extension.count()));
}

// Tells each percent.
class ReplayReport {
 public:
  explicit ReplayReport(Application& application) : application_(application) {}

  void operator()(double share) {
    application_.gate.SetProgress(share);
    const int percent = static_cast<int>(100 * share);
    if (percent == percent_) return;
    percent_ = percent;
    constexpr auto kExtension = std::chrono::minutes(1);  // chosen: a percent takes less
    TellStart("replaying " + std::to_string(percent) + " %", kExtension);
  }

 private:
  Application& application_;
  int percent_ = -1;
};

// Ends the allowances whose time was over before the restart, so that no client finds one in force.
absl::Status ExpireRules(const WorldRegistry& worlds) {
  for (const std::shared_ptr<World>& world : worlds.List()) {
    const absl::Status expired = world->ExpireRules(Clock::now());
    if (expired.ok()) continue;
    if (DetailsOf(expired).reason != "DISK_FULL") return expired;
    spdlog::warn(
        "world '{}': allowances whose time is over stay in force until the disk has room: {}",
        world->name(), std::string(expired.message()));
  }
  return absl::OkStatus();
}

// Takes away what sensors saw moving before the restart: nobody knows where it is now.
absl::Status RemoveOldMovers(const WorldRegistry& worlds) {
  for (const std::shared_ptr<World>& world : worlds.List()) {
    const auto make = [](const SnapshotPtr& latest) { return RemoveMovers(*latest); };
    if (make(world->Snapshot()).empty()) continue;
    const absl::Status removed =
        world->Update(make, {}, {.durability = Durability::kObserved}).status();
    if (removed.ok()) continue;
    if (DetailsOf(removed).reason != "DISK_FULL") return removed;
    spdlog::warn("world '{}': movers of before the restart stay until the disk has room: {}",
                 world->name(), std::string(removed.message()));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<std::unique_ptr<DurableWorlds>> DurableWorlds::Open(const Options::Store& options) {
  // chosen: opening reads the whole database, of which a disk gives some 100 MB in a second.
  constexpr auto kExtension = std::chrono::minutes(5);
  TellStart("opening the store", kExtension);
  auto store = OpenSqliteStore({.path = options.directory,
                                .accept_loss = options.accept_loss,
                                .allow_network_mount = options.allow_network_mount,
                                .warn = [](const std::string& text) { spdlog::warn("{}", text); }});
  if (!store.ok()) return store.status();
  return std::unique_ptr<DurableWorlds>(
      new DurableWorlds("sqlite:" + options.directory, options.accept_loss, *std::move(store)));
}

std::optional<absl::Status> DurableWorlds::Restore(Application& application,
                                                   const sigset_t& signals) {
  constexpr timespec kPeriod = {.tv_sec = 0, .tv_nsec = 10'000'000};
  std::promise<absl::Status> promise;
  auto restored = promise.get_future();
  std::thread thread([this, &application, promise = std::move(promise)]() mutable {
    promise.set_value(RestoreAll(application));
  });
  while (restored.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    if (sigtimedwait(&signals, nullptr, &kPeriod) > 0) {
      thread.detach();
      return std::nullopt;
    }
  }
  thread.join();
  return restored.get();
}

absl::Status DurableWorlds::RestoreAll(Application& application) {
  auto replayed = Replay(*store_, {.retention = application.retention,
                                   .limits = application.limits,
                                   .accept_loss = accept_loss_,
                                   .memory = application.memory,
                                   .progress = ReplayReport(application)});
  if (!replayed.ok()) return replayed.status();
  for (const std::string& warning : replayed->warnings) spdlog::warn("{}", warning);
  spdlog::info("restored {} worlds from {}: {} records, {} snapshots, {} geometries, {:.1f} s",
               replayed->worlds.size(), location_, replayed->record_count, replayed->snapshot_count,
               replayed->geometry_count, replayed->seconds);
  journal_ =
      std::make_unique<StoreJournal>(std::move(store_), std::move(replayed->compactor), EndProcess,
                                     [](const std::string& text) { spdlog::warn("{}", text); });
  application.worlds.SetJournal(journal_.get());
  application.worlds.Restore(std::move(replayed->worlds), replayed->deleted);
  application.store_admin = journal_.get();
  if (absl::Status expired = ExpireRules(application.worlds); !expired.ok()) return expired;
  return RemoveOldMovers(application.worlds);
}

absl::Status DurableWorlds::Close(Application& application) {
  application.worlds.StopExpiry();
  if (journal_ != nullptr) return journal_->Close();
  return store_ != nullptr ? store_->Close() : absl::OkStatus();
}

}  // namespace cwm::server
