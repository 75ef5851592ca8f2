// What the clients of a server did and saw: one format for all campaigns, kept as lines of JSON.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/fault/model.h"

namespace cwm::fault {

// A call, or what was done to the machine under the server.
struct Operation {
  enum class Kind {
    kWrite,   // `changes`
    kDelete,  // of the world
    kRead,
    kCut,  // the power went off at `invoke_ns`; the server is back at `return_ns`
    // The wall clock went ahead by more than what is kept for watches and retries.
    kClockAhead,
  };
  enum class Outcome {
    kOk,
    kError,    // the server refused the call: it has no effect
    kUnknown,  // no answer came
  };
  enum class At { kLatest, kAtLeast, kExact };

  int client = 0;
  Kind kind = Kind::kWrite;
  std::string world = {};       // its name
  std::string world_uid = {};   // of the reply; without one, as the request gave it
  std::string request_id = {};  // of writes and deletions: the same for all attempts
  std::vector<Change> changes = {};
  std::optional<std::int64_t> expected_revision = {};
  std::int64_t invoke_ns = 0;
  std::int64_t return_ns = 0;
  Outcome outcome = Outcome::kOk;
  std::int64_t revision = 0;                         // kOk
  std::string reason = {};                           // kError
  std::optional<std::int64_t> actual_revision = {};  // of REVISION_MISMATCH

  // Reads.
  At at = At::kLatest;
  std::int64_t asked_revision = 0;  // kAtLeast, kExact
  // True for the first read of a world after a restart, before any client went on.
  bool after_restart = false;
  // The parts that were read, all at `revision`.
  std::optional<std::uint64_t> objects_hash = {};
  std::optional<std::uint64_t> robots_hash = {};
  std::optional<std::uint64_t> rules_hash = {};
  // SHA-256 of the very bytes of replies, by what was asked: the same revision must give the same
  // bytes at all times.
  std::map<std::string, std::string> digests = {};
};

// One message of a watch.
struct WatchMessage {
  enum class Kind { kInitialState, kEvents, kBookmark };
  std::int64_t time_ns = 0;
  std::int64_t revision = 0;
  Kind kind = Kind::kBookmark;
  bool more = false;  // the next message continues this one
  std::vector<Effect> effects = {};
};

// One stream of a watch. A client that resumes opens another one.
struct Watch {
  int client = 0;
  std::string world = {};
  std::string world_uid = {};
  std::optional<std::int64_t> from_revision = {};
  bool is_lossless = true;
  std::int64_t invoke_ns = 0;
  std::vector<WatchMessage> messages = {};
  std::string end_reason = {};  // of the error that ended it; empty: it was broken off
};

struct History {
  std::vector<Operation> operations = {};
  std::vector<Watch> watches = {};
};

void Write(const History& history, std::ostream& out);
// Throws nlohmann::json::exception for a line that is no part of a history.
History ReadHistory(std::istream& in);

}  // namespace cwm::fault
