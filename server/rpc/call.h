// One call as the services see it: its time, its cancellation, and unary calls whose work a queue
// does.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

struct WorldAtRevision {
  std::shared_ptr<World> world;
  SnapshotPtr snapshot;
};

struct CallContext {
  Clock::time_point deadline = Clock::time_point::max();  // max: none
  std::stop_token stop;
  std::optional<WorldAtRevision> reached = {};  // what the call awaited, if it did
};

// The call's deadline on the steady clock.
Clock::time_point DeadlineOf(const grpc::CallbackServerContext& context);

// When the answer has to leave with what there is by then: the smaller of the budget and 0.9 of the
// remaining deadline. Nothing without either.
std::optional<Clock::time_point> GiveUpAt(std::optional<std::chrono::nanoseconds> time_budget,
                                          Clock::time_point deadline);

// A revision that the world has to reach before the work can begin.
struct RevisionToAwait {
  std::shared_ptr<World> world;
  collision::Revision revision;
};

using CallWork = std::function<absl::Status(const CallContext&)>;

// Runs `work`; an exception that got this far (memory, a foreign library) becomes a status.
absl::Status RunGuarded(const CallWork& work, const CallContext& call);

// A call that was cancelled because the server ends says so: SERVER_DRAINING. Other statuses stay.
absl::Status WhyItEnded(absl::Status status, const Runtime& runtime);

// How long work takes.
enum class WorkLength {
  kAny,
  kShort,  // less than waking another thread for it
};

// Hands `work` to the queue once the world has the revision to await (revision_waits.h), and
// finishes the call with its status. A full queue is RESOURCE_EXHAUSTED at once. Short work that
// awaits nothing is done here where the queue allows it, and hears of no cancellation then. Work that
// has not begun when the server drains is not done: SERVER_DRAINING.
grpc::ServerUnaryReactor* StartUnary(
    grpc::CallbackServerContext* context, Runtime& runtime, WorkQueue& queue, CallWork work,
    absl::StatusOr<std::optional<RevisionToAwait>> await = {std::nullopt},
    WorkLength length = WorkLength::kAny);

}  // namespace cwm::server
