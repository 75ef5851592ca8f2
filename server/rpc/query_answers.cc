#include "server/rpc/query_answers.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stop_token>
#include <string_view>
#include <utility>

#include "collision/world/apply_fault.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/query_queue.h"
#include "server/wire/answers.h"
#include "server/wire/objects.h"
#include "server/wire/pair_options.h"
#include "server/wire/poses.h"
#include "server/wire/prepared_bytes.h"
#include "server/wire/queries.h"

namespace cwm::server {
namespace {

// The size of an answer on the wire, in columns.
struct AnswerSize {
  int scalars;
  int bytes;  // of the non-scalar columns
};
AnswerSize SizeOfAnswer(const v1::CheckCollisionsRequest&) { return {0, 14}; }
AnswerSize SizeOfAnswer(const v1::GetDistancesRequest& request) {
  constexpr int kJoints = 7;  // of an arm
  return {11 + (request.want_joint_gradient() ? kJoints : 0), 14};
}
AnswerSize SizeOfAnswer(const v1::GetContactsRequest&) { return {11, 13}; }
AnswerSize SizeOfAnswer(const v1::GetWorldContactsRequest&) { return {11, 17}; }
AnswerSize SizeOfAnswer(const v1::CheckMotionsRequest&) { return {3, 18}; }
AnswerSize SizeOfAnswer(const v1::SolvePosesRequest& request) {
  constexpr int kJoints = 9;  // of an arm, with the two errors
  return {std::max(1, request.max_solutions()) * kJoints, 5};
}
AnswerSize SizeOfAnswer(const v1::GetLinkPosesRequest&) { return {7, 0}; }
AnswerSize SizeOfAnswer(const v1::CastRaysRequest&) { return {4, 10}; }
AnswerSize SizeOfAnswer(const v1::SamplePointsRequest&) { return {5, 10}; }

template <class Request>
ContactCount ContactCountOf(const Request&) {
  return {};
}
ContactCount ContactCountOf(const v1::GetWorldContactsRequest&) { return kWorldContactCount; }

// The time to pass an answer to a client on this machine. measured: three times the time on an
// otherwise idle machine (1.2 to 1.7 ns per byte of columns, 1 us per message).
std::chrono::nanoseconds HandoverTime(const AnswerSize& size, const ParsedQueryOptions& options,
                                      const ReplySlowdown& slowdown) {
  constexpr int kByteCost_ns = 4, kMessageCost_ns = 3'000;
  const int scalar_bytes = options.precision == Precision::kSingle ? 4 : 8;
  const int quiet_ns = options.form == Form::kRows
                           ? kMessageCost_ns
                           : kByteCost_ns * (size.scalars * scalar_bytes + size.bytes);
  return std::chrono::nanoseconds(static_cast<std::int64_t>(quiet_ns * slowdown.Factor()));
}

// chosen: reading a request may always take this long; the answer then has the rows that there was
// time for, possibly none. A query that takes longer to read than its time budget fails.
constexpr auto kShortReading = std::chrono::milliseconds(10);

// The values that all kinds of queries share once they are parsed.
struct ParsedQuery {
  std::shared_ptr<World> world;
  collision::Revision revision;  // the world's, without overlays
  SnapshotPtr snapshot;          // at that revision, with the overlays
  ParsedQueryOptions options;
  WorkBudget budget;         // for reading the query
  MemoryCharge charge = {};  // paid by its client, for the geometry that the overlay prepares

  AnswerContext Context(BodyNames body = {}) const {
    return {.world_uid = world->uid(),
            .revision = revision,
            .snapshot = *snapshot,
            .form = options.form,
            .precision = options.precision,
            .verdicts_only = options.query.naming == collision::Naming::kWhereTested,
            .joint_gradients = options.query.joint_gradients,
            .body = std::move(body)};
  }
};

// True if the stream's snapshot is the requested one.
bool HoldsRevision(const StreamMemory* memory, const World& world, const RevisionRule& rule) {
  const auto* exactly = std::get_if<Exactly>(&rule);
  return memory != nullptr && exactly != nullptr && memory->snapshot != nullptr &&
         memory->world_uid == world.uid() && memory->snapshot->revision() == exactly->revision;
}

absl::StatusOr<WorldAtRevision> FindWorldAt(const Runtime& runtime, const std::string& name,
                                            const ParsedQueryOptions& options,
                                            const CallContext& call, StreamMemory* memory) {
  const RevisionRule& rule = options.at_revision;
  // The world is asked first, so that the use also leases the revision there.
  auto at = server::FindWorldAt(runtime, name, options.world_uid, rule, call);
  if (!at.ok()) {
    const auto world = runtime.application.worlds.Find(name, options.world_uid);
    if (world.ok() && HoldsRevision(memory, **world, rule)) {
      return WorldAtRevision{*world, memory->snapshot};
    }
  } else if (memory != nullptr) {
    memory->world_uid = at->world->uid();
    memory->snapshot = at->snapshot;
  }
  return at;
}

absl::StatusOr<SnapshotPtr> WithOverlay(const Application& application,
                                        const v1::QueryOptions& options, SnapshotPtr base,
                                        WorkBudget* budget) {
  if (options.overlay().empty()) return base;
  auto changes = ChangesFromProto(options.overlay(), application.limits, application.geometry,
                                  FieldPath::OfRequest("options"), "overlay", budget);
  if (!changes.ok()) return changes.status();
  return WithChanges(base, *changes, "options.overlay", budget);
}

// Checks that the links of ignored pairs exist; otherwise an error in a name would go unnoticed.
absl::Status CheckIgnoredPairs(const std::vector<collision::NamedPair>& pairs,
                               const collision::WorldSnapshot& snapshot) {
  const auto owner_of = [&](const std::string& name) {
    const collision::WorldRobotPtr robot = snapshot.FindRobot(name);
    return collision::NameOwner{.robot = robot != nullptr ? &robot->model() : nullptr,
                                .is_object = snapshot.Find(name) != nullptr};
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto fault = collision::FieldRuleOf(CheckLinks(pairs[i], owner_of));
    if (!fault.has_value()) continue;
    const FieldPath options = FieldPath::OfRequest("options");
    const FieldPath pair = options.Item("ignore_pairs", static_cast<int>(i));
    return pair.Field(fault->field).Error(fault->rule);
  }
  return absl::OkStatus();
}

template <class Request>
absl::StatusOr<ParsedQuery> ParseQuery(Runtime& runtime, const Request& request,
                                       const CallContext& call, StreamMemory* memory) {
  auto options = QueryOptionsFromProto(request.options(), FieldPath::OfRequest("options"),
                                       ContactCountOf(request));
  if (!options.ok()) return options.status();
  auto at = FindWorldAt(runtime, request.world(), *options, call, memory);
  if (!at.ok()) return at.status();
  options->query.deadline = AnswerDeadline(options->time_budget, call.deadline);
  options->query.handover_per_entry =
      HandoverTime(SizeOfAnswer(request), *options, runtime.reply_slowdown);
  const auto read_until = std::max(options->query.deadline.value_or(Clock::time_point::max()),
                                   Clock::now() + kShortReading);
  ParsedQuery parsed{at->world, at->snapshot->revision(), at->snapshot, *std::move(options),
                     WorkBudget(read_until, call.stop)};
  if (memory != nullptr) {
    auto overlaid = memory->overlay.ApplyTo(*at->world, std::move(at->snapshot), &parsed.budget);
    if (!overlaid.ok()) return overlaid.status();
    at->snapshot = *std::move(overlaid);
  }
  if (!request.options().overlay().empty()) {
    const Application& application = runtime.application;
    auto charge = application.memory->Charge(
        MemoryBudget::Client(call.client),
        PreparedBytes(request.options().overlay(), application.geometry));
    if (!charge.ok()) return charge.status();
    parsed.charge = *std::move(charge);
  }
  auto snapshot =
      WithOverlay(runtime.application, request.options(), std::move(at->snapshot), &parsed.budget);
  if (!snapshot.ok()) return snapshot.status();
  parsed.snapshot = *std::move(snapshot);
  auto status = CheckIgnoredPairs(parsed.options.query.ignore_pairs, *parsed.snapshot);
  if (!status.ok()) return status;
  status = CheckNamedThings(parsed.options.query.only, *parsed.snapshot,
                            FieldPath::OfRequest("options"));
  if (!status.ok()) return status;
  return parsed;
}

// A kind of query about a body in rows.
template <class Columns, class Response>
struct BodyQuery {
  absl::StatusOr<Columns> (*evaluate)(const collision::WorldSnapshot& world,
                                      const collision::QueryBody& body,
                                      const collision::BodyRows& rows,
                                      const collision::QueryOptions& options, std::stop_token stop);
  // The field that limits the number of answers per row, and the resulting number.
  std::string_view field;
  std::int64_t (*per_row)(const collision::QueryOptions& options,
                          const collision::WorldSnapshot& world);
  void (*to_proto)(const Columns& answers, const AnswerContext& context, Response* response);
};

std::int64_t OnePerRow(const collision::QueryOptions&, const collision::WorldSnapshot&) {
  return 1;
}

// At most one answer per object and robot, and one for the body itself.
std::int64_t ResultsPerRow(const collision::QueryOptions& options,
                           const collision::WorldSnapshot& world) {
  if (options.pairs == collision::DistancePairs::kLinks) return 0;  // counted while they are found
  return std::min<std::int64_t>(
      options.max_results,
      static_cast<std::int64_t>(world.objects().size() + world.robots().size()) + 1);
}

std::int64_t ContactsPerRow(const collision::QueryOptions& options,
                            const collision::WorldSnapshot&) {
  return options.max_contacts;
}

template <class Columns, class Request, class Response>
absl::Status AnswerBody(Runtime& runtime, const Request& request, const CallContext& call,
                        StreamMemory* memory, const BodyQuery<Columns, Response>& kind,
                        Response* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  auto status = SetPairOptions(request, parsed->options);
  if (!status.ok()) return status;
  const Application& application = runtime.application;
  collision::QueryOptions& options = parsed->options.query;
  auto query = StateQueryFromProto(request.subject(),
                                   {*parsed->snapshot, application.geometry, application.limits,
                                    options.ignore, &parsed->budget, options.only},
                                   FieldPath::OfRequest("subject"));
  if (!query.ok()) return query.status();
  const Limits limits = LimitsOf(*query, options, application.limits);
  options.max_answers = static_cast<std::size_t>(MaxAnswers(parsed->options.form, limits));
  const std::unique_ptr<const collision::BodyRows> rows = RowsOf(*query);
  status = CheckForm(parsed->options.form, rows->size(), limits);
  if (!status.ok()) return status;
  status = CheckAnswers({kind.field, kind.per_row(options, *parsed->snapshot), rows->size()},
                        parsed->options.form, limits);
  if (!status.ok()) return status;
  const CoreShare share(runtime, IsBatch(runtime, request));
  options.threads = share.threads();
  auto answers = kind.evaluate(*parsed->snapshot, query->body, *rows, options, call.stop);
  if (absl::IsOutOfRange(answers.status())) return TooManyLinkPairs(options);
  if (!answers.ok()) return answers.status();
  kind.to_proto(*answers, parsed->Context(BodyNamesOf(*query)), response);
  return absl::OkStatus();
}

}  // namespace

absl::Status AnswerQuery(Runtime& runtime, const v1::CheckCollisionsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::CheckCollisionsResponse* response) {
  return AnswerBody(runtime, request, call, memory,
                    BodyQuery<collision::CollisionColumns, v1::CheckCollisionsResponse>{
                        collision::CheckCollisions, "", OnePerRow, CollisionAnswersToProto},
                    response);
}

absl::Status AnswerQuery(Runtime& runtime, const v1::GetDistancesRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetDistancesResponse* response) {
  return AnswerBody(
      runtime, request, call, memory,
      BodyQuery<collision::PairColumns, v1::GetDistancesResponse>{
          collision::GetDistances, "options.max_results", ResultsPerRow, DistanceAnswersToProto},
      response);
}

absl::Status AnswerQuery(Runtime& runtime, const v1::GetContactsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetContactsResponse* response) {
  return AnswerBody(
      runtime, request, call, memory,
      BodyQuery<collision::PairColumns, v1::GetContactsResponse>{
          collision::GetContacts, "options.max_contacts", ContactsPerRow, ContactAnswersToProto},
      response);
}

absl::Status AnswerQuery(Runtime& runtime, const v1::GetWorldContactsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetWorldContactsResponse* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  const Limits& limits = runtime.application.limits;
  collision::QueryOptions& options = parsed->options.query;
  if (parsed->options.form == Form::kRows && request.options().max_contacts() == 0) {
    options.max_contacts = static_cast<int>(
        std::min<std::int64_t>(options.max_contacts, limits.max_answers_as_messages));
  }
  const auto status =
      CheckAnswers({"options.max_contacts", options.max_contacts, 1}, parsed->options.form, limits);
  if (!status.ok()) return status;
  const CoreShare share(runtime, IsBatch(runtime, request));
  options.threads = share.threads();
  const auto answers = collision::GetWorldContacts(*parsed->snapshot, options, call.stop);
  if (!answers.ok()) return answers.status();
  WorldContactAnswersToProto(*answers, parsed->Context(), response);
  return absl::OkStatus();
}

absl::Status AnswerQuery(Runtime& runtime, const v1::CheckMotionsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::CheckMotionsResponse* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  const Application& application = runtime.application;
  auto motions = MotionQueryFromProto(
      request, {*parsed->snapshot, application.geometry, application.limits,
                parsed->options.query.ignore, &parsed->budget, parsed->options.query.only});
  if (!motions.ok()) return motions.status();
  auto status = CheckForm(parsed->options.form, motions->paths.size(), application.limits);
  if (!status.ok()) return status;
  const StateQuery& query = motions->query;
  const CoreShare share(runtime, IsBatch(runtime, request));
  parsed->options.query.threads = share.threads();
  auto answers = collision::CheckPaths(*parsed->snapshot, query.body, *WaypointsOf(query),
                                       motions->paths, parsed->options.query, call.stop);
  if (!answers.ok()) return answers.status();
  MotionAnswersToProto(*answers, parsed->Context(BodyNamesOf(query)), response);
  return absl::OkStatus();
}

absl::Status AnswerQuery(Runtime& runtime, const v1::SolvePosesRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::SolvePosesResponse* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  const Application& application = runtime.application;
  auto query = PoseQueryFromProto(
      request, {*parsed->snapshot, application.geometry, application.limits,
                parsed->options.query.ignore, &parsed->budget, parsed->options.query.only});
  if (!query.ok()) return query.status();
  const collision::PoseBatch batch = BatchOf(*query);
  auto status = CheckForm(parsed->options.form, query->X_WT.size(), application.limits);
  if (status.ok()) {
    status = CheckAnswers({"max_solutions", batch.max_solutions, query->X_WT.size()},
                          parsed->options.form, application.limits);
  }
  if (!status.ok()) return status;
  const CoreShare share(runtime, IsBatch(runtime, request));
  parsed->options.query.threads = share.threads();
  const collision::JointRows states = JointRowsOf(std::get<RobotRows>(query->query.states));
  auto answers = collision::SolvePoses(*parsed->snapshot, query->query.body, query->chain, states,
                                       batch, parsed->options.query, call.stop);
  if (!answers.ok()) return answers.status();
  PoseAnswersToProto(*answers, *query, parsed->Context(), response);
  return absl::OkStatus();
}

absl::Status AnswerQuery(Runtime& runtime, const v1::GetLinkPosesRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::GetLinkPosesResponse* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  const Application& application = runtime.application;
  const auto query = RobotQueryFromProto(
      request.robot(),
      {*parsed->snapshot, application.geometry, application.limits, parsed->options.query.ignore,
       &parsed->budget, parsed->options.query.only},
      FieldPath::OfRequest("robot"));
  if (!query.ok()) return query.status();
  const auto links = LinksFromProto(request, *query);
  if (!links.ok()) return links.status();
  const std::unique_ptr<const collision::BodyRows> rows = RowsOf(*query);
  const auto per_row = static_cast<std::int64_t>(links->size());
  auto status = CheckAnswers({"links", per_row, rows->size()}, Form::kColumns, application.limits);
  if (!status.ok()) return status;
  LinkPosesToProto(*query, *links, parsed->Context(), &parsed->budget, response);
  return call.stop.stop_requested() ? absl::CancelledError("the question was cancelled")
                                    : absl::OkStatus();
}

absl::Status AnswerQuery(Runtime& runtime, const v1::CastRaysRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::CastRaysResponse* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  const Limits& limits = runtime.application.limits;
  auto rays = RaysFromProto(request.rays(), limits.max_batch_rows, FieldPath::OfRequest("rays"));
  if (!rays.ok()) return rays.status();
  if (auto status = CheckForm(parsed->options.form, rays->size(), limits); !status.ok()) {
    return status;
  }
  for (collision::RayRow& ray : *rays) ray.max_distance_m = parsed->options.query.max_distance_m;
  const CoreShare share(runtime, IsBatch(runtime, request));
  parsed->options.query.threads = share.threads();
  auto answers = collision::CastRays(*parsed->snapshot, *rays, parsed->options.query, call.stop);
  if (!answers.ok()) return answers.status();
  RayAnswersToProto(*answers, *rays, parsed->Context(), response);
  return absl::OkStatus();
}

absl::Status AnswerQuery(Runtime& runtime, const v1::SamplePointsRequest& request,
                         const CallContext& call, StreamMemory* memory,
                         v1::SamplePointsResponse* response) {
  auto parsed = ParseQuery(runtime, request, call, memory);
  if (!parsed.ok()) return parsed.status();
  const Limits& limits = runtime.application.limits;
  auto points =
      PointsFromProto(request.points(), limits.max_batch_rows, FieldPath::OfRequest("points"));
  if (!points.ok()) return points.status();
  if (auto status = CheckForm(parsed->options.form, points->size(), limits); !status.ok()) {
    return status;
  }
  const CoreShare share(runtime, IsBatch(runtime, request));
  parsed->options.query.threads = share.threads();
  auto answers =
      collision::SamplePoints(*parsed->snapshot, *points, parsed->options.query, call.stop);
  if (!answers.ok()) return answers.status();
  SampleAnswersToProto(*answers, parsed->Context(), response);
  return absl::OkStatus();
}

}  // namespace cwm::server
