// Checks whether memory is given back when worlds are deleted.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cpp/cloud_upload.h"
#include "tests/benchmarks/benchmark_scans.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

constexpr int kMeshes = 12, kScans = 3, kObjects = 20'000;

bool FillWithMeshes(MeasuredServer& server) {
  Target target{.server = server};
  if (!StoreLargeTori(target, kMeshes)) return false;
  for (int i = 0; i < kMeshes; ++i) {
    if (!PutMesh(server, absl::StrCat("mesh_", i), target.hashes[static_cast<std::size_t>(i)])) {
      return false;
    }
  }
  return true;
}

bool FillWithScans(const MeasuredServer& server) {
  const BenchmarkScans scans = LoadBenchmarkScans();
  for (int i = 0; i < kScans && i < static_cast<int>(scans.files.size()); ++i) {
    v1::IngestCloudHeader header;
    header.set_world(absl::StrCat("scan_", i));
    if (!client::IngestCloud(server.connection(), header, scans.files[static_cast<std::size_t>(i)])
             .ok()) {
      return false;
    }
  }
  return true;
}

bool DeleteAll(const MeasuredServer& server) {
  const client::Connection& connection = server.connection();
  const auto worlds = connection.Call(&v1::WorldService::Stub::ListWorlds, connection.worlds(),
                                      v1::ListWorldsRequest());
  if (!worlds.ok()) return false;
  for (const v1::World& world : worlds->worlds()) {
    v1::DeleteWorldRequest request;
    request.set_world(world.name());
    if (!connection.Call(&v1::WorldService::Stub::DeleteWorld, connection.worlds(), request).ok()) {
      return false;
    }
  }
  return true;
}

struct Kind {
  std::string name;
  std::function<bool(MeasuredServer&)> fill;
};

// The share that was given back; empty if it could not be measured.
std::optional<double> Returned(const Kind& kind, Report& report) {
  MeasuredServer server;
  // Threads and tables made with the first object of each kind stay.
  if (!server.up() || !PutBoxes(server, "first", 10) || !DeleteAll(server)) return std::nullopt;
  server.WaitUntilIdle(2);
  const auto before = static_cast<double>(server.ResidentBytes());
  if (!kind.fill(server)) return std::nullopt;
  server.WaitUntilIdle(3);
  const auto full = static_cast<double>(server.ResidentBytes());
  if (!DeleteAll(server)) return std::nullopt;
  double min_bytes = full;
  for (int i = 0; i < 50; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    min_bytes = std::min(min_bytes, static_cast<double>(server.ResidentBytes()));
  }
  if (!server.running() || full <= before) return std::nullopt;
  const double share = (full - min_bytes) / (full - before);
  char text[200];
  std::snprintf(
      text, sizeof(text),
      "Memory of %-8s %7.1f MiB before, %7.1f MiB full, %7.1f MiB within 5 s of DeleteWorld: "
      "%.2f came back",
      kind.name.c_str(), before / kMebi, full / kMebi, min_bytes / kMebi, share);
  report.Detail(text);
  return share;
}

}  // namespace

void MeasureMemoryReturned(Report& report) {
  const std::vector<Kind> kinds = {
      {"objects", [](MeasuredServer& server) { return PutBoxes(server, "objects", kObjects); }},
      {"meshes", FillWithMeshes},
      {"scans", [](MeasuredServer& server) { return FillWithScans(server); }},
      {"robots",
       [](MeasuredServer& server) {
         for (int i = 0; i < 8; ++i) {
           if (!LoadArm(server, absl::StrCat("arm_", i), 1'000)) return false;
         }
         return true;
       }},
  };
  double worst = 1;
  std::string which;
  for (const Kind& kind : kinds) {
    const auto share = Returned(kind, report);
    if (!share) return report.Fail("worlds of " + kind.name + " could not be filled and deleted");
    if (*share < worst) {
      worst = *share;
      which = kind.name;
    }
  }
  report.Add(
      WithLimit({.key = "memory_returned",
                 .value = worst,
                 .unit = "1",
                 .how = "share of the growth of anonymous resident memory that is gone within "
                        "5 s of DeleteWorld; worst of worlds of objects, meshes, scans and "
                        "robots, each in a server of its own: " +
                        which},
                0.8, "limit, at least"));
}

}  // namespace cwm::benchmarks
