// All worlds of the server, by name.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/world.h"

namespace cwm::server {

// The name that a request means; the empty name is "default".
const std::string& WorldNameOf(const std::string& name);

// FailedPrecondition WORLD_REPLACED.
absl::Status WorldReplaced(const std::string& name, const std::string& expected_uid,
                           const std::string& actual_uid);

// Thread safe. The empty name means "default".
class WorldRegistry {
 private:
  struct State;

 public:
  // `memory` is charged for all worlds; null: no limit.
  WorldRegistry(Limits limits, Retention retention, std::shared_ptr<MemoryBudget> memory = nullptr,
                std::function<Clock::time_point()> now = Clock::now);
  ~WorldRegistry();

  // A world to write to. A world that was created for the lease is visible only to writers until
  // the first write is published; otherwise it is removed with the last lease, so that a refused
  // write creates no world. Must not outlive the registry.
  class Lease {
   public:
    Lease(Lease&& other) noexcept;
    Lease& operator=(Lease&&) = delete;
    ~Lease();

    World& operator*() const { return *world_; }
    World* operator->() const { return world_.get(); }
    const std::shared_ptr<World>& world() const { return world_; }

    // True if the world is visible to everybody, since something was written.
    bool committed() const;

   private:
    friend class WorldRegistry;
    Lease(State& state, std::shared_ptr<World> world) : state_(state), world_(std::move(world)) {}

    State& state_;
    std::shared_ptr<World> world_;  // nullptr: moved from
  };

  // The world, or a new one under a lease. InvalidArgument for an invalid name (letters, digits, _
  // - . 1 to 128 characters), ResourceExhausted for too many worlds. A non-empty `uid` requires an
  // existing world: the errors of Find.
  absl::StatusOr<Lease> AcquireLease(const std::string& name, const std::string& uid = "");
  // The world, or a new one that is committed at once.
  absl::StatusOr<std::shared_ptr<World>> FindOrCreate(const std::string& name);
  // NotFound WORLD_UNKNOWN. FailedPrecondition WORLD_REPLACED if `uid` is non-empty and differs.
  absl::StatusOr<std::shared_ptr<World>> Find(const std::string& name,
                                              const std::string& uid = "") const;
  std::vector<std::shared_ptr<World>> List() const;  // by name

  struct Deleted {
    std::string uid;
    collision::Revision revision;  // its last
  };
  // The errors of Find; DISK_FULL, then the world stays. A retry with the same request_id, within
  // the time that ids are kept, gets the first reply; FailedPrecondition REQUEST_ID_REUSED for
  // another `uid` under the same id.
  absl::StatusOr<Deleted> Delete(const std::string& name, const std::string& uid = "",
                                 const std::string& request_id = "");
  // Ends all watches with a last bookmark, for shutting down.
  void Drain();
  // Ends what the registry writes by itself: from now on no rule expires. Must be called before the
  // journal closes.
  void StopExpiry();

  // Sets the journal of all worlds that are made from now on. It must outlive the registry.
  void SetJournal(Journal* journal);
  Journal* journal() const;  // nullptr: none
  // Adds the worlds of before a restart, visible to everybody, and recently deleted ones.
  void Restore(std::vector<WorldImage> worlds, std::span<const DeletedWorldImage> deleted);

  enum class WorldEvent { kCreated, kDeleted };
  // Called, without a lock of the registry, for each world that becomes visible to everybody and
  // for each that no longer is. Replaces the previous listener; may be empty.
  using Listener = std::function<void(const World& world, WorldEvent event)>;
  void SetListener(Listener listener);

 private:
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
