// The entries that a world gives to its journal, and the journal's interface. The core knows no
// store: server/store implements the interface.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "server/core/history.h"
#include "server/core/write_facts.h"

namespace cwm::server {

struct RobotFiles;  // load_robot.h

// How much of an acknowledged write survives.
enum class Durability : std::uint8_t {
  kObserved,  // the end of the process; a power cut may take the newest of these writes
  kDurable,   // a power cut, too
};

// The id under which a write was requested, for retries.
struct WrittenRequest {
  std::string id;
  std::string digest;
  bool is_ingest = false;
};

// One write of a world: its results, not the request.
struct WorldWrite {
  EventPtr event = {};  // nullptr: the write made no revision
  WriteFacts facts = {};
  std::optional<WrittenRequest> request = {};
  // The newest numbers of names (World::ReserveName) that this write gave, by stem.
  std::vector<std::pair<std::string, std::int64_t>> last_numbers = {};
};

// The end of a world, with what was asked for, for retries.
struct WorldDeletion {
  std::string requested_uid = {};
  std::string request_id = {};
};

struct JournalEntry {
  std::string world_uid;
  collision::Revision revision;  // of the world after it
  collision::WallTime when;
  Durability durability = Durability::kDurable;
  // It takes something back, such as an allowance whose time is over, and is small: it is written
  // even when the room on the disk is kept for such entries.
  bool may_use_reserve = false;
  std::optional<std::string> created_name = {};  // the first entry of a world: its name
  std::variant<WorldWrite, WorldDeletion> what = {};
};

using PreparedModelPtr = std::shared_ptr<const collision::PreparedModel>;

class Journal {
 public:
  virtual ~Journal() = default;

  // Called once per entry, in the order of the entries, by a thread of the journal. OK: the entry
  // survives, as its durability promises. ResourceExhausted DISK_FULL: nothing of it was written,
  // nor of later entries of its world that were appended before this call returned; the world goes
  // on from its last journaled state.
  using Done = std::function<void(const absl::Status& status)>;

  // Appends the entry behind all earlier ones. Does not wait for the disk. Entries of one world are
  // appended by one thread at a time.
  virtual void Append(const JournalEntry& entry, Done done) = 0;

  // Stores the large geometry of the models, before a world journals changes of objects that have
  // them: of what is put, and, for durable changes, of what was only observed so far. Ignores null
  // pointers. Heavy, so no lock may be held. ResourceExhausted DISK_FULL.
  virtual absl::Status KeepGeometry(std::span<const PreparedModelPtr> models,
                                    Durability durability) = 0;
  // Stores the files of a robot; returns the hash that names them (RobotGeometry::files_hash).
  virtual absl::StatusOr<std::string> KeepRobotFiles(const RobotFiles& files) = 0;
};

}  // namespace cwm::server
