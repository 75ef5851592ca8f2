// How fast a store is replayed: makes a store of many objects and moves, and restores its world.
// A program of its own, because a restart begins with an empty process.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/core/world.h"
#include "server/store/compaction.h"
#include "server/store/encode_entry.h"
#include "server/store/replay.h"
#include "server/store/sqlite/sqlite_store.h"
#include "tests/benchmarks/report.h"
#include "tests/benchmarks/usage.h"

namespace {

namespace fs = std::filesystem;
using namespace cwm;
using namespace cwm::server;

constexpr char kUsage[] =
    "cwm-bench-store-replay make|replay|fold DIRECTORY [--objects N] [--triangles N] [--moves N]\n"
    "                       [--json FILE]\n"
    "make writes a store into DIRECTORY, which must not exist: N objects (10,000), each a mesh of\n"
    "its own of N triangles (100), and N revisions that each move one object (100,000). replay\n"
    "restores it; the files are dropped from the page cache before. fold folds all records into a\n"
    "snapshot, as a server does with old ones.\n";

struct Words {
  std::string what, directory, json;
  int objects = 10'000, triangles = 100, moves = 100'000;
};

[[noreturn]] void Fail(const std::string& text) {
  std::fprintf(stderr, "%s\n", text.c_str());
  std::exit(1);
}

template <class T>
T Checked(absl::StatusOr<T> value) {
  if (!value.ok()) Fail(value.status().ToString());
  return *std::move(value);
}
void Check(const absl::Status& status) {
  if (!status.ok()) Fail(status.ToString());
}

// Appends a thousand entries at a time.
class BatchJournal final : public Journal {
 public:
  explicit BatchJournal(Store& store) : store_(store) {}

  void Append(const JournalEntry& entry, Done done) override {
    EncodedEntry encoded = Checked(EncodeEntry(entry, store_));
    const std::int64_t next = store_.last_sequence() + static_cast<std::int64_t>(batch_.size()) + 1;
    batch_.push_back({.sequence = next,
                      .epoch = store_.epoch(),
                      .world_uid = entry.world_uid,
                      .revision = entry.revision.value,
                      .payload = std::move(encoded.payload),
                      .blobs = std::move(encoded.blobs)});
    if (batch_.size() >= 1'000) Flush();
    done(absl::OkStatus());
  }
  void Flush() {
    if (!batch_.empty()) Checked(store_.Append(batch_, Durability::kDurable));
    batch_.clear();
    Check(store_.Maintain());
  }
  absl::Status KeepGeometry(std::span<const PreparedModelPtr>, Durability) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::string> KeepRobotFiles(const RobotFiles&) override {
    return absl::UnimplementedError("no robots");
  }

 private:
  Store& store_;
  std::vector<StoredRecord> batch_;
};

// A closed mesh, different for each number.
std::shared_ptr<const HybridModel> ModelOf(int number, int triangles) {
  TriangleMesh mesh;
  const int sides = std::max(3, triangles / 2);
  const double radius_m = 0.05 + 1e-6 * number;
  mesh.vertices = {{0, 0, radius_m}, {0, 0, -radius_m}};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.vertices.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0);
    const auto a = static_cast<std::uint32_t>(2 + i);
    const auto b = static_cast<std::uint32_t>(2 + (i + 1) % sides);
    mesh.triangles.push_back({0, a, b});
    mesh.triangles.push_back({1, b, a});
  }
  HybridModel model;
  model.shapes.push_back({.X_OS = Pose::Identity(), .shape = MakeMesh(std::move(mesh)), .fit = {}});
  return std::make_shared<const HybridModel>(std::move(model));
}

Pose PoseOf(int number, int step) {
  return MakePose({0.2 * (number % 100), 0.2 * (number / 100 % 100), 0.001 * step},
                  Quaternion(Eigen::AngleAxisd(0.01 * step, Vector3::UnitZ())));
}

void Make(const Words& words) {
  if (fs::exists(words.directory)) Fail(words.directory + " exists");
  const std::unique_ptr<Store> store = Checked(OpenSqliteStore({.path = words.directory}));
  BatchJournal journal(*store);
  const auto world =
      std::make_shared<World>("default", "00000000000000000000000000000001", Retention(),
                              Clock::now, WorldServices{.journal = &journal});
  for (int i = 0; i < words.objects; ++i) {
    const collision::Change put{
        collision::PutObject{.name = absl::StrCat("object_", i),
                             .X_WO = PoseOf(i, 0),
                             .geometry = collision::Prepare(ModelOf(i, words.triangles)),
                             .supported_by = {}},
        std::nullopt};
    Checked(world->Apply({&put, 1}, {}));
  }
  for (int i = 0; i < words.moves; ++i) {
    const int number = static_cast<int>(i * std::int64_t{7919} % words.objects);
    const collision::Change move{
        collision::MoveObject{absl::StrCat("object_", number), PoseOf(number, 1 + i)},
        std::nullopt};
    Checked(world->Apply({&move, 1}, {}));
  }
  journal.Flush();
  Check(store->Close());
}

// The files must be on the disk: the page cache keeps pages that are not.
std::int64_t DropFromCache(const std::string& directory) {
  std::int64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (!entry.is_regular_file()) continue;
    bytes += static_cast<std::int64_t>(entry.file_size());
    const int fd = open(entry.path().c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) continue;
    fsync(fd);
    posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
    close(fd);
  }
  return bytes;
}

void RunReplay(const Words& words, benchmarks::Report& report) {
  using Seconds = std::chrono::duration<double>;
  const std::int64_t bytes = DropFromCache(words.directory);
  const auto begin = std::chrono::steady_clock::now();
  const std::unique_ptr<Store> store = Checked(OpenSqliteStore({.path = words.directory}));
  const double open_s = Seconds(std::chrono::steady_clock::now() - begin).count();
  Replayed replayed = Checked(Replay(*store, {}));
  const double total_s = Seconds(std::chrono::steady_clock::now() - begin).count();
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  if (replayed.worlds.empty()) Fail("the store has no world");
  const WorldImage& image = replayed.worlds.front();
  const auto& latest = image.steps.empty() ? image.base : image.steps.back().next;
  const double cpu_s = static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
                       1e-6 * static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
  report.Add({.key = "replay_s",
              .value = total_s,
              .unit = "s",
              .how = absl::StrCat(
                  "open the store (", open_s, " s) and replay it: ", replayed.record_count,
                  " records, ", latest->objects().size(), " objects, ", replayed.geometry_count,
                  " distinct geometries, ", image.earlier.size() + image.steps.size(),
                  " kept revisions, ", bytes / 1'000'000, " MB of files, not in the page cache; ",
                  cpu_s, " s of CPU, at most ", usage.ru_maxrss / 1'000, " MB of memory")});
  Check(store->Close());
}

// The journal appends nothing while a step is taken.
void RunFold(const Words& words, benchmarks::Report& report) {
  const std::unique_ptr<Store> store = Checked(OpenSqliteStore({.path = words.directory}));
  const std::vector<StoredRecord> last = Checked(store->Follow("", store->last_sequence() - 1, 1));
  if (last.empty()) Fail("the store has no records");
  Compaction compaction(last.front().world_uid, last.front().sequence, {});
  double total_ms = 0;
  std::vector<double> steps_ms;
  while (!compaction.done()) {
    const auto begin = std::chrono::steady_clock::now();
    Check(compaction.Step(*store));
    const std::chrono::duration<double, std::milli> step = std::chrono::steady_clock::now() - begin;
    steps_ms.push_back(step.count());
    total_ms += step.count();
  }
  report.Add(
      {.key = "fold_step_ms",
       .value = benchmarks::Quantile(steps_ms, 1),
       .unit = "ms",
       .how = absl::StrCat("the longest of ", steps_ms.size(), " steps that fold ",
                           last.front().sequence, " records; the last one, which writes ",
                           "the snapshot, took ", steps_ms.back(), " ms, all together ", total_ms,
                           " ms, the median ", benchmarks::Median(steps_ms), " ms")});
  Check(store->Close());
}

}  // namespace

int main(int argc, char** argv) {
  if (benchmarks::PrintsUsage(argc, argv, kUsage)) return 0;
  Words words;
  std::vector<std::string*> texts = {&words.what, &words.directory};
  std::size_t given = 0;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word.starts_with("--") && i + 1 < argc) {
      const std::string value = argv[++i];
      if (word == "--json") words.json = value;
      if (word == "--objects") words.objects = std::atoi(value.c_str());
      if (word == "--triangles") words.triangles = std::atoi(value.c_str());
      if (word == "--moves") words.moves = std::atoi(value.c_str());
    } else if (given < texts.size()) {
      *texts[given++] = word;
    }
  }
  if (words.directory.empty() || words.objects < 1) Fail(kUsage);
  if (words.what == "make") {
    Make(words);
    return 0;
  }
  if (words.what != "replay" && words.what != "fold") Fail(kUsage);
  benchmarks::Report report;
  words.what == "replay" ? RunReplay(words, report) : RunFold(words, report);
  report.Print();
  if (!words.json.empty()) report.WriteJson(words.json);
  return report.failed() ? 1 : 0;
}
