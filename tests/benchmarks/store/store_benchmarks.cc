#include "tests/benchmarks/store/store_benchmarks.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "tests/benchmarks/server/server_benchmarks.h"
#include "tests/benchmarks/store/write_load.h"

namespace cwm::benchmarks {
namespace {

namespace fs = std::filesystem;

constexpr int kWriters = 16;
constexpr double kSeconds = 10;  // of each load
constexpr int kCalls = 2'000;    // of each kind by one client

// A directory for stores, which is removed with its owner.
class StoreFolder {
 public:
  explicit StoreFolder(const std::string& parent) {
    fs::create_directories(parent);
    path_ = parent + "/bench-store-XXXXXX";
    if (mkdtemp(path_.data()) == nullptr) path_.clear();
  }
  ~StoreFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  StoreFolder(const StoreFolder&) = delete;
  StoreFolder& operator=(const StoreFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

std::string LoadOfMachine() {
  std::string load;
  std::getline(std::ifstream("/proc/loadavg"), load, ' ');
  return load;
}

// Overwrites 4 KiB of an allocated file and flushes them.
class FlushedFile {
 public:
  explicit FlushedFile(const std::string& path)
      : fd_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
    for (int i = 0; i < kPages && ok_; ++i) ok_ = write(fd_, page_.data(), kPage) == kPage;
    ok_ = ok_ && fsync(fd_) == 0;
  }
  ~FlushedFile() { close(fd_); }
  FlushedFile(const FlushedFile&) = delete;
  FlushedFile& operator=(const FlushedFile&) = delete;

  // False if the disk refuses.
  bool Flush() {
    const off_t at = static_cast<off_t>(++count_ % kPages) * kPage;
    ok_ = ok_ && pwrite(fd_, page_.data(), kPage, at) == kPage && fdatasync(fd_) == 0;
    return ok_;
  }

 private:
  static constexpr int kPage = 4'096, kPages = 1'024;
  const int fd_;
  const std::vector<char> page_ = std::vector<char>(kPage, 'x');
  int count_ = 0;
  bool ok_ = true;
};

// Appends the duration of `call` in milliseconds; false if it fails.
template <class Call>
bool AddTime(const Call& call, std::vector<double>* times_ms) {
  const auto start = SteadyClock::now();
  const bool ok = call();
  times_ms->push_back(SecondsSince(start) * 1e3);
  return ok;
}

// The i-th write of one writer.
bool MoveBox(const MeasuredServer& server, int i) {
  const client::Connection& connection = server.connection();
  return connection
      .Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(),
            MoveOfBox("w", 0, 1e-4 * (i + 1)))
      .ok();
}

std::string Format(const char* form, double a, double b = 0, double c = 0) {
  char text[200];
  std::snprintf(text, sizeof(text), form, a, b, c);
  return text;
}

// Revisions a second; adds a line of details.
std::optional<double> Load(const StoreFolder& folder, int worlds, const std::string& key,
                           std::vector<double>* wall_ms, Report& report) {
  const auto server = StartServer(folder / key);
  if (server == nullptr) {
    report.Fail(key + ": the server does not come up");
    return std::nullopt;
  }
  const WriteRates rates = MeasureWriters(*server, kWriters, worlds, kSeconds);
  if (!rates.ok) {
    report.Fail(key + ": a write failed");
    return std::nullopt;
  }
  *wall_ms = rates.wall_ms;
  const double per_s = static_cast<double>(rates.revisions) / rates.seconds;
  report.Detail("  " + std::to_string(worlds) + (worlds == 1 ? " world:  " : " worlds: ") +
                Format("%.0f revisions/s, a call p50 %.2f ms, p99 %.2f ms", per_s,
                       Quantile(rates.wall_ms, 0.5), Quantile(rates.wall_ms, 0.99)));
  return per_s;
}

// The sum of a count over the states of all campaigns, or of one.
std::optional<std::int64_t> CountOf(const std::string& directory, const std::string& campaign,
                                    const std::string& what) {
  std::ifstream file(directory + "/" + campaign + ".json");
  if (!file) return std::nullopt;
  const auto state = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!state.is_object() || !state.contains("counts")) return std::nullopt;
  return state["counts"].value(what, std::int64_t{0});
}

}  // namespace

StoreBenchmarkOptions DefaultStoreBenchmarkOptions() {
  const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
  return {.directory = programs.parent_path() / "stores",
          .fault_directory = programs.parent_path() / "fault",
          .other_program = {}};
}

void MeasureDurableWriters(const StoreBenchmarkOptions& options, Report& report) {
  const StoreFolder folder(options.directory);
  report.Detail("16 writers, one change a call, durable; load of the machine " + LoadOfMachine() +
                ":");
  std::vector<double> one_ms, many_ms;
  const auto one = Load(folder, 1, "one", &one_ms, report);
  const auto many = Load(folder, kWriters, "many", &many_ms, report);
  if (!one || !many) return;
  const std::string how = "revisions that the worlds gained over " + Format("%.0f s", kSeconds) +
                          ", 16 writers over gRPC with a connection each, one change a call, "
                          "cwm-server --store sqlite:";
  report.Add(WithLimit({.key = "durable_revisions_per_s_16",
                        .value = *one,
                        .unit = "1/s",
                        .how = how + ", all in one world"},
                       5'000, "at least"));
  report.Add(WithLimit({.key = "durable_revisions_per_s_16_worlds",
                        .value = *many,
                        .unit = "1/s",
                        .how = how + ", each in a world of its own"},
                       5'000, "at least"));
  report.Add(WithLimit({.key = "durable_p99_ms",
                        .value = Quantile(one_ms, 0.99),
                        .unit = "ms",
                        .how = "p99 of a call of the 16 writers of one world"},
                       25));
}

void MeasureDurableOverhead(const StoreBenchmarkOptions& options, Report& report) {
  const StoreFolder folder(options.directory);
  const auto memory = StartServer("");
  const auto durable = StartServer(folder / "store");
  if (memory == nullptr || durable == nullptr || !PutMovableBoxes(*memory, "w", 1) ||
      !PutMovableBoxes(*durable, "w", 1)) {
    return report.Fail("the servers of the overhead do not come up");
  }
  FlushedFile file(folder / "flushed");
  std::vector<double> memory_ms, durable_ms, flush_ms;
  for (int i = 0; i < kCalls; ++i) {  // in turns, so that all meet the same machine
    const bool ok = AddTime([&] { return MoveBox(*memory, i); }, &memory_ms) &&
                    AddTime([&] { return file.Flush(); }, &flush_ms) &&
                    AddTime([&] { return MoveBox(*durable, i); }, &durable_ms);
    if (!ok) return report.Fail("a write of the overhead failed");
  }
  const double memory_p50 = Median(memory_ms), durable_p50 = Median(durable_ms);
  const double flush_p50 = Median(flush_ms);
  report.Detail("One writer, p50 (p99): durable " +
                Format("%.3f ms (%.2f)", durable_p50, Quantile(durable_ms, 0.99)) + ", in memory " +
                Format("%.3f ms (%.2f)", memory_p50, Quantile(memory_ms, 0.99)) +
                ", fdatasync of 4 KiB " +
                Format("%.3f ms (%.2f)", flush_p50, Quantile(flush_ms, 0.99)));
  report.Add(WithLimit(
      {.key = "durable_overhead_ms",
       .value = durable_p50 - memory_p50 - flush_p50,
       .unit = "ms",
       .how = "p50 of a writer's call with --store sqlite:, less p50 with memory and p50 of "
              "fdatasync of 4 KiB on the same file system; 2 000 of each in turns" +
              Format("; %.3f - %.3f - %.3f", durable_p50, memory_p50, flush_p50)},
      0.2));
}

void MeasureStoreCost(const StoreBenchmarkOptions& options, Report& report) {
  if (!options.other_program.empty()) return MeasureCostsBeside(options.other_program, report);
  const auto server = StartServer("");
  if (server == nullptr || !PutMovableBoxes(*server, "w", 200)) {
    return report.Fail("the server of the cost does not come up");
  }
  std::vector<double> write_ms, question_ms;
  const client::Connection& connection = server->connection();
  v1::GetDistancesRequest question;
  question.set_world("w");
  v1::Subject::Shapes& subject = *question.mutable_subject()->mutable_shapes();
  subject.add_shapes()->mutable_sphere()->set_radius_m(0.02);
  const double pose[7] = {0.1, 0.1, 0.1, 0, 0, 0, 1};
  subject.mutable_x_world_body()->set_data(pose, sizeof(pose));
  const auto ask = [&] {
    return connection.Call(&v1::QueryService::Stub::GetDistances, connection.queries(), question)
        .ok();
  };
  for (int i = 0; i < kCalls; ++i) {
    const bool ok =
        AddTime([&] { return MoveBox(*server, i); }, &write_ms) && AddTime(ask, &question_ms);
    if (!ok) return report.Fail("a call of the cost failed");
  }
  const std::string beside = "; --other PROGRAM measures another build in turns";
  report.Add({.key = "store_cost_question_us",
              .value = 1e3 * Median(question_ms),
              .unit = "us",
              .how = "median GetDistances of one row, 200 boxes, --store memory" + beside});
  report.Add({.key = "store_cost_publish_us",
              .value = 1e3 * Median(write_ms),
              .unit = "us",
              .how = "median ApplyChanges that moves one of 200 boxes, --store memory" + beside});
}

void MeasureReplay(const StoreBenchmarkOptions& options, Report& report) {
  const StoreFolder folder(options.directory);
  const std::string program =
      fs::read_symlink("/proc/self/exe").parent_path() / "cwm-bench-store-replay";
  const std::string store = folder / "replayed", figures = folder / "replay.json";
  report.Detail("Replay: making the store");
  const auto made = testing::RunProgram({program, "make", store});
  if (made.exit_code != 0) return report.Fail("the store cannot be made: " + made.err);
  const auto replayed = testing::RunProgram({program, "replay", store, "--json", figures});
  std::ifstream file(figures);
  const auto rows = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (replayed.exit_code != 0 || !rows.is_array()) {
    return report.Fail("the store cannot be replayed: " + replayed.err);
  }
  for (const auto& row : rows) {
    report.Add(WithLimit({.key = row.at("key"),
                          .value = row.at("value"),
                          .unit = row.at("unit"),
                          .how = row.at("how")},
                         10));
  }
}

void ReportFaults(const StoreBenchmarkOptions& options, Report& report) {
  struct Row {
    const char* key;
    const char* campaign;
    const char* count;
    double limit;
    const char* kind;
  };
  constexpr Row kRows[] = {{"kills", "kills", "kills", 5'000, "at least"},
                           {"kills_lost", "kills", "lost", 0, "at most"},
                           {"power_cuts", "cuts", "cuts", 200, "at least"},
                           {"power_cuts_lost", "cuts", "lost", 0, "at most"}};
  bool has_run = false;
  for (const Row& row : kRows) {
    const auto count = CountOf(options.fault_directory, row.campaign, row.count);
    if (!count) continue;
    has_run = true;
    report.Add(WithLimit({.key = row.key,
                          .value = static_cast<double>(*count),
                          .unit = "1",
                          .how = std::string("`./dev fault ") + row.campaign + "`, as counted in " +
                                 options.fault_directory},
                         row.limit, row.kind));
  }
  if (!has_run) return report.Detail("`./dev fault` has not run here: no counts of faults");
  std::int64_t violations = 0;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(options.fault_directory, ignored)) {
    if (entry.path().extension() != ".json") continue;
    violations += CountOf(options.fault_directory, entry.path().stem(), "violations").value_or(0);
  }
  report.Add(WithLimit({.key = "violations",
                        .value = static_cast<double>(violations),
                        .unit = "1",
                        .how = "found by the history checker in all campaigns of `./dev fault`"},
                       0));
}

void MeasureStore(Report& report) {
  const StoreBenchmarkOptions options = DefaultStoreBenchmarkOptions();
  MeasureDurableWriters(options, report);
  MeasureDurableOverhead(options, report);
  MeasureStoreCost(options, report);
  MeasureReplay(options, report);
  ReportFaults(options, report);
}

}  // namespace cwm::benchmarks
