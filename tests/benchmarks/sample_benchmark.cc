// The distance of the world and its gradient at points: in process, and through a running server.
#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "clients/cpp/connection.h"
#include "collision/geometry/signed_distance.h"
#include "collision/query/query.h"
#include "tests/benchmarks/benchmark_world.h"
#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/running_server.h"

namespace cwm::benchmarks {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kPoints = 65'536;  // the largest batch of a request
constexpr int kThreads = 2;
constexpr int kRounds = 30;

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

// Points in random order over the space of the benchmark world.
std::vector<Vector3> ScatteredPoints() {
  std::vector<Vector3> points;
  for (const Pose& X : RandomPoses(kPoints, 7)) points.push_back(X.translation());
  return points;
}

// Points as an optimiser needs them: 64 balls of an arm along trajectories of 128 steps.
std::vector<Vector3> PointsOfTrajectories() {
  constexpr std::size_t kBalls = 64, kSteps = 128;
  const std::vector<Pose> ends =
      RandomPoses(static_cast<int>(2 * std::size_t{kPoints} / kSteps), 11);
  std::vector<Vector3> points;
  for (std::size_t step = 0; points.size() < kPoints; ++step) {
    const std::size_t trajectory = points.size() / (kBalls * kSteps);
    const double share = static_cast<double>(step % kSteps) / kSteps;
    for (std::size_t ball = 0; ball < kBalls; ++ball) {
      const std::size_t line = trajectory * kBalls + ball;
      points.emplace_back((1 - share) * ends[2 * line].translation() +
                          share * ends[2 * line + 1].translation());
    }
  }
  return points;
}

// The best rate of the rounds, because other users of the machine only ever slow it down.
template <class Function>
double BestRate(const Function& evaluate, int rounds = kRounds) {
  double best = 0;
  for (int round = 0; round < rounds; ++round) {
    const Clock::time_point start = Clock::now();
    if (!evaluate()) return 0;
    best = std::max(best, kPoints / Seconds(Clock::now() - start));
  }
  return best;
}

double OwnRate(const collision::WorldSnapshot& world, const std::vector<Vector3>& points,
               int threads) {
  collision::QueryOptions options;
  options.threads = threads;
  return BestRate([&] { return collision::SamplePoints(world, points, options).ok(); });
}

// The baseline: a plain loop over all parts for the distance alone; each thread takes its share.
double PlainRate(const std::vector<Vector3>& points) {
  struct Solid {
    Pose X_SW;
    Shape shape;
  };
  std::vector<Solid> solids;
  for (const Placed<>& placed : BenchmarkShapes()) {
    solids.push_back({placed.X_FS.inverse(), placed.shape});
  }
  std::vector<double> distances(points.size());
  const auto work = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double nearest_m = 1e300;
      for (const Solid& solid : solids) {
        nearest_m = std::min(nearest_m, SignedDistance_m(solid.shape, solid.X_SW * points[i]));
      }
      distances[i] = nearest_m;
    }
  };
  return BestRate(
      [&] {
        std::jthread other(work, points.size() / kThreads, points.size());
        work(0, points.size() / kThreads);
        return true;
      },
      5);
}

// The rate on one stream that sends the next batch before it reads the answer of the last one;
// points and answers are in F64.
double StreamRate(const RunningServer& server, const std::vector<Vector3>& points, int batches) {
  v1::StreamQueriesRequest request;
  v1::Subject::Points* rows = request.mutable_sample_points()->mutable_points();
  rows->set_data(points.data(), points.size() * sizeof(Vector3));
  grpc::ClientContext context;
  const auto stream = server.connection().queries().StreamQueries(&context);
  v1::StreamQueriesResponse response;
  if (!stream->Write(request)) return 0;
  const Clock::time_point start = Clock::now();
  for (int batch = 0; batch < batches; ++batch) {
    if (batch + 1 < batches && !stream->Write(request)) return 0;
    if (!stream->Read(&response)) return 0;
    if (response.sample_points().completed_count() != kPoints) return 0;
  }
  const double elapsed_s = Seconds(Clock::now() - start);
  stream->WritesDone();
  return stream->Finish().ok() ? batches * kPoints / elapsed_s : 0;
}

void PrintRate(const char* what, double rate, Report& report) {
  char text[128];
  std::snprintf(text, sizeof(text), "  %-48s %6.1f M points/s", what, 1e-6 * rate);
  rate > 0 ? report.Detail(text) : report.Fail(text);
}

double MeasureInProcess(const std::vector<Vector3>& points, Report& report) {
  const auto world = MakeBenchmarkWorld();
  double own = 0, plain = 0, alone = 0;
  for (int round = 0; round < 3; ++round) {  // in turn
    own = std::max(own, OwnRate(*world, points, kThreads));
    plain = std::max(plain, PlainRate(points));
    alone = std::max(alone, OwnRate(*world, points, 1));
  }
  report.Detail("Signed distance and gradient at points, 30 boxes, cylinders, spheres, capsules:");
  PrintRate("in process, scattered points, two threads", own, report);
  PrintRate("the same, one thread", alone, report);
  PrintRate("points of trajectories, two threads",
            OwnRate(*world, PointsOfTrajectories(), kThreads), report);
  PrintRate("points of trajectories, one thread", OwnRate(*world, PointsOfTrajectories(), 1),
            report);
  PrintRate("loop over all parts, distance alone, two threads", plain, report);
  PrintRate("300 objects, one thread", OwnRate(*MakeLargeWorld(300), points, 1), report);
  report.Add({.key = "sample_points_per_s",
              .value = own,
              .unit = "1/s",
              .baseline = "loop over all parts",
              .baseline_value = plain,
              .ratio = own / plain,
              .how = "in process, two threads, distance, gradient, object and trust of 65 536 "
                     "scattered points among 30 objects; the baseline, on two threads too, has the "
                     "distance alone; best of 3 x 30 batches"});
  return alone;
}

}  // namespace

void MeasureSamples(Report& report) {
  const std::vector<Vector3> points = ScatteredPoints();
  const double alone = MeasureInProcess(points, report);
  const RunningServer server;
  if (!server.up()) return report.Fail("the server did not come up: no samples through gRPC");
  double rate = 0;
  for (int round = 0; round < 5; ++round) rate = std::max(rate, StreamRate(server, points, 20));
  PrintRate("through gRPC, scattered points", rate, report);
  report.Add({.key = "sample_points_grpc_per_s",
              .value = rate,
              .unit = "1/s",
              .baseline = "in process, one thread",
              .baseline_value = alone,
              .ratio = rate / alone,
              .how = "StreamQueries over the Unix socket, batches of 65 536 points, F64 both ways, "
                     "two in flight; client and server share the cores; best of 5 x 20 batches"});
}

}  // namespace cwm::benchmarks
