#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {
void Target::HoldOver(const std::shared_ptr<grpc::Channel>& channel, CallPlan plan,
                      Sent& sent) const {
  constexpr auto kSendLimit = std::chrono::milliseconds(1'000);
  auto call = std::make_unique<HeldCall>(channel, std::move(plan));
  call->WaitUntilSent(kSendLimit);
  sent.bytes += call->wire_bytes();
  sent.calls.push_back(std::move(call));
}

void Target::Hold(CallPlan plan, Sent& sent) const {
  HoldOver(server.NewChannel(), std::move(plan), sent);
}

void Target::CallSequentially(const std::vector<CallPlan>& plans, double limit_s,
                              Sent& sent) const {
  constexpr auto kCallLimit = std::chrono::milliseconds(1'000);
  const auto start = SteadyClock::now();
  const auto channel = server.NewChannel();
  int count = 0;
  for (const CallPlan& plan : plans) {
    if (SecondsSince(start) > limit_s) break;
    HeldCall call(channel, plan);
    call.WaitUntilDone(kCallLimit);
    sent.bytes += call.wire_bytes();
    sent.outcome = std::to_string(++count) + " calls, last " + call.Outcome();
  }
}

std::vector<HostileRequest> HostileRequests() {
  std::vector<HostileRequest> all;
  for (const auto& requests :
       {WorldRequests(), ReadingRequests(), QueryRequests(), StreamRequests(), UploadRequests(),
        RobotRequests(), TransportRequests()}) {
    all.insert(all.end(), requests.begin(), requests.end());
  }
  return all;
}

}  // namespace cwm::benchmarks
