// The costs of queries and of publishing, beside another server program, in turn.
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/measured_server.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr int kRounds = 12;
constexpr double kPart_s = 0.35;

v1::GetDistancesRequest DistancesRequest(int rows) {
  v1::GetDistancesRequest request;
  request.set_world("w");
  request.mutable_subject()->mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(0.02);
  request.mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(rows, 0));
  return request;
}

// Wall time of a call in microseconds, and the server's processor time for it.
struct Cost {
  double wall_us = 0, cpu_us = 0;
};

template <class Call>
Cost CostOf(const MeasuredServer& server, const Call& call, bool* ok) {
  std::vector<double> wall_us;
  const double cpu_s = server.Cpu_s();
  const auto start = SteadyClock::now();
  while (SecondsSince(start) < kPart_s) {
    const auto sent = SteadyClock::now();
    *ok = call() && *ok;
    wall_us.push_back(SecondsSince(sent) * 1e6);
  }
  const auto count = static_cast<double>(wall_us.size());
  return {Median(wall_us), (server.Cpu_s() - cpu_s) / count * 1e6};
}

struct Side {
  std::unique_ptr<MeasuredServer> server;
  std::vector<Cost> small, batch, change;
};

bool MeasureRound(Side& side, int round) {
  const client::Connection& connection = side.server->connection();
  const v1::GetDistancesRequest one = DistancesRequest(1), many = DistancesRequest(10'000);
  v1::ApplyChangesRequest change;
  change.set_world("w");
  v1::MoveObject* move = change.add_changes()->mutable_move();
  move->set_name("box_0");
  int count = 0;
  bool ok = true;
  const auto send_query = [&](const v1::GetDistancesRequest& request) {
    return connection.Call(&v1::QueryService::Stub::GetDistances, connection.queries(), request)
        .ok();
  };
  side.small.push_back(CostOf(
      *side.server, [&] { return send_query(one); }, &ok));
  side.batch.push_back(CostOf(
      *side.server, [&] { return send_query(many); }, &ok));
  side.change.push_back(CostOf(
      *side.server,
      [&] {
        move->mutable_x_world_object()->set_tx_m(round + 1e-6 * ++count);
        move->mutable_x_world_object()->set_qw(1);
        return connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), change)
            .ok();
      },
      &ok));
  return ok;
}

// Adds the medians of our times and of the other server's, and of the ratios of each round.
void AddCost(const std::string& key, const std::string& what, const std::vector<Cost>& ours,
             const std::vector<Cost>& others, Report& report) {
  std::vector<double> our_us, other_us, wall_ratios, cpu_ratios;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    our_us.push_back(ours[i].wall_us);
    other_us.push_back(others[i].wall_us);
    wall_ratios.push_back(ours[i].wall_us / others[i].wall_us);
    cpu_ratios.push_back(ours[i].cpu_us / others[i].cpu_us);
  }
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "; ours over the other's, median of rounds: %.3f by the clock, %.3f by the server's "
      "processor time (at most 1.03)",
      Median(wall_ratios), Median(cpu_ratios));
  report.Add({.key = key,
              .value = Median(our_us),
              .unit = "us",
              .baseline = "the other server",
              .baseline_value = Median(other_us),
              .ratio = Median(cpu_ratios),
              .how = what + text});
}

}  // namespace

void MeasureCostsBeside(const std::string& other_program, Report& report) {
  Side ours, other;
  ours.server = std::make_unique<MeasuredServer>();
  other.server = std::make_unique<MeasuredServer>(MeasuredServerOptions{.program = other_program});
  for (const Side* side : {&ours, &other}) {
    if (!side->server->up() || !PutBoxes(*side->server, "w", 200)) {
      return report.Fail("a server for the costs did not come up");
    }
  }
  for (int round = 0; round < kRounds; ++round) {
    Side& first = round % 2 == 0 ? ours : other;
    Side& second = round % 2 == 0 ? other : ours;
    if (!MeasureRound(first, round) || !MeasureRound(second, round)) {
      return report.Fail("a call of the costs failed");
    }
  }
  AddCost("question_us", "median GetDistances of one row, 200 boxes", ours.small, other.small,
          report);
  AddCost("batch_us", "median GetDistances of 10 000 rows", ours.batch, other.batch, report);
  AddCost("publish_call_us", "median ApplyChanges that moves one of 200 boxes", ours.change,
          other.change, report);
}

}  // namespace cwm::benchmarks
