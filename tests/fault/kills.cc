#include <array>
#include <chrono>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/fault/campaigns.h"
#include "tests/fault/trial.h"

namespace cwm::fault {
namespace {

using std::chrono::milliseconds;

constexpr int kKillsOfAStore = 200;  // a store that grows takes longer to replay
constexpr int kKillsOfACheck = 25;   // so that an interrupted run loses few of them

// Where the server kills itself, and the most passes before it does: rare ones at the first.
struct Failpoint {
  const char* name;
  int max_pass;
};
constexpr std::array<Failpoint, 6> kFailpoints = {{{"before-record", 60},
                                                   {"after-commit", 60},
                                                   {"after-publish", 60},
                                                   {"blob-renamed", 3},
                                                   {"checkpoint", 2},
                                                   {"backup", 2}}};
// derived: 16 MiB of old records make a compaction due, at 60 KB each.
constexpr int kMeshesOfACompaction = 300;
// The watch window is 5 min, and what is kept for retries 10 min.
constexpr std::int64_t kClockAhead_s = 660;
constexpr int kMaxCompactionKills = 12;
// chosen: a server comes to most places within a tenth of it.
constexpr milliseconds kFailpointTime(600);

class KillTrial {
 public:
  explicit KillTrial(Campaign& campaign)
      : campaign_(campaign),
        seed_(campaign.NextSeed()),
        random_(seed_),
        trial_(campaign, {.seed = seed_}) {}

  void Run() {
    if (!trial_.Boot() || !trial_.Prepare()) return;
    trial_.server().Kill();
    for (int i = 0; i < kKillsOfAStore && campaign_.GoesOn("kills") && !trial_.is_broken(); ++i) {
      if (i % 2 == 0) {
        KillAtRandom();
      } else {
        const Failpoint& failpoint = kFailpoints[static_cast<std::size_t>(i / 2) % 6];
        KillAt(failpoint.name, Draw(1, failpoint.max_pass));
      }
      if (i % kKillsOfACheck == kKillsOfACheck - 1) Keep();
    }
    if (trial_.is_broken()) return;
    if (trial_.Boot() && trial_.InspectRestart()) trial_.Conclude();
    if (campaign_.GoesOn("kills") && !trial_.is_broken()) KillCompactions();
    Keep();
  }

 private:
  void KillAtRandom() {
    if (!trial_.Boot() || !trial_.InspectRestart()) return;
    trial_.workload().Start(trial_.server().address());
    if (trial_.server().WaitForEnd(milliseconds(Draw(10, 250)))) {
      trial_.Complain("the server ended by itself: " + trial_.server().LogTail());
    }
    trial_.server().Kill();
    trial_.workload().Stop();
    campaign_.Add("kills");
    campaign_.Add("kills_at_random");
  }

  // True if the server came to that pass of the place; else it is killed after a while.
  bool KillAt(const std::string& name, int pass) {
    const std::vector<std::string> environment = {"CWM_FAILPOINT=" + name + ":" +
                                                  std::to_string(pass)};
    bool is_reached = true;
    if (trial_.Boot(environment, /*may_end=*/true) &&
        trial_.InspectRestart(/*whole=*/false, /*may_end=*/true)) {
      trial_.workload().Start(trial_.server().address());
      std::thread backup;
      if (name == "backup") backup = std::thread([this] { trial_.BackUp(); });
      is_reached = trial_.server().WaitForEnd(kFailpointTime).has_value();
      if (!is_reached) trial_.server().Kill();
      trial_.workload().Stop();
      if (backup.joinable()) backup.join();
    }
    if (trial_.is_broken()) return false;
    campaign_.Add("kills");
    campaign_.Add((is_reached ? "kills_at_" : "not_reached_") + name);
    return is_reached;
  }

  // Lets much of the log become old, and kills the server at each step of folding it.
  void KillCompactions() {
    if (!trial_.workload().PutMeshes(trial_.server().address(), kMeshesOfACompaction)) {
      trial_.Complain("the meshes could not be put: " + trial_.server().LogTail());
      return;
    }
    trial_.server().Kill();
    trial_.workload().SetClockAhead();
    const std::string file = trial_.scratch() / "clock";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(&kClockAhead_s), sizeof(kClockAhead_s));
    trial_.SetEnvironment({"LD_PRELOAD=" CWM_SETTABLE_CLOCK, "CWM_CLOCK_OFFSET=" + file});
    for (int pass = 1; pass <= kMaxCompactionKills; ++pass) {
      if (!KillAt("compaction", pass)) break;
    }
    if (!trial_.is_broken() && trial_.Boot() && trial_.InspectRestart()) trial_.Conclude();
  }

  void Keep() {
    trial_.CheckHistory();
    campaign_.Save();
    campaign_.Print();
  }

  int Draw(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }

  Campaign& campaign_;
  std::uint32_t seed_;
  std::mt19937 random_;
  Trial trial_;
};

}  // namespace

void RunKills(Campaign& campaign) {
  while (campaign.GoesOn("kills")) KillTrial(campaign).Run();
}

}  // namespace cwm::fault
