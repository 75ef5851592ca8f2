#include "tests/benchmarks/live/revision_probe.h"

#include <grpcpp/client_context.h>

#include <algorithm>
#include <utility>

#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

// chosen: the time after which the thread looks whether it must end.
constexpr auto kWait = std::chrono::milliseconds(500);

// The distance of a small sphere from the nearest object.
v1::GetDistancesRequest QueryAt(const std::string& world, std::int64_t least_revision) {
  v1::GetDistancesRequest request;
  request.set_world(world);
  request.mutable_options()->mutable_at_revision()->set_at_least(least_revision);
  v1::Subject::Shapes& subject = *request.mutable_subject()->mutable_shapes();
  subject.add_shapes()->mutable_sphere()->set_radius_m(0.02);
  const double pose[7] = {0.6, 0, 0.9, 0, 0, 0, 1};
  subject.mutable_x_world_body()->set_data(pose, sizeof(pose));
  return request;
}

}  // namespace

RevisionProbe::RevisionProbe(const std::string& address, std::string world)
    : world_(std::move(world)),
      connection_({.address = address, .deadline = kWait}),
      thread_([this] { Run(); }) {}

RevisionProbe::~RevisionProbe() {
  stops_ = true;
  thread_.join();
}

void RevisionProbe::Run() {
  std::int64_t next = 0;
  while (!stops_) {
    const auto answer = connection_.Call(&v1::QueryService::Stub::GetDistances,
                                         connection_.queries(), QueryAt(world_, next));
    if (!answer.ok()) continue;  // no such revision within the wait
    const std::lock_guard lock(mutex_);
    seen_.push_back({.revision = answer->revision(), .at = SteadyClock::now()});
    next = answer->revision() + 1;
  }
}

std::optional<SteadyClock::time_point> RevisionProbe::SeenAt(std::int64_t revision) const {
  const std::lock_guard lock(mutex_);
  const auto seen = std::ranges::lower_bound(seen_, revision, std::less<>(),
                                             [](const Seen& s) { return s.revision; });
  if (seen == seen_.end()) return std::nullopt;
  return seen->at;
}

std::size_t RevisionProbe::seen_count() const {
  const std::lock_guard lock(mutex_);
  return seen_.size();
}

std::vector<double> ChangeTimes_ms(const std::vector<FrameAnswer>& answers, std::size_t first,
                                   const RevisionProbe& probe) {
  std::vector<double> times_ms;
  std::int64_t newest = first > 0 ? answers[first - 1].response.revision() : 0;
  for (std::size_t i = first; i < answers.size(); ++i) {
    const FrameAnswer& answer = answers[i];
    if (!answer.is_processed() || answer.response.revision() <= newest) continue;
    newest = answer.response.revision();
    const bool has_change = answer.response.changes().moved_size() > 0;
    const auto seen = probe.SeenAt(newest);
    if (!has_change || !seen) continue;
    times_ms.push_back(std::chrono::duration<double, std::milli>(*seen - answer.sent).count());
  }
  return times_ms;
}

}  // namespace cwm::benchmarks
