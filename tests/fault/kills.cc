#include <algorithm>
#include <array>
#include <chrono>
#include <random>
#include <string>
#include <thread>

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
constexpr std::array<Failpoint, 8> kFailpoints = {{{"before-record", 60},
                                                   {"after-commit", 60},
                                                   {"after-publish", 60},
                                                   {"blob-renamed", 3},
                                                   {"checkpoint", 2},
                                                   {"compaction", 1},
                                                   {"migration", 1},
                                                   {"backup", 2}}};

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
      // Every other kill comes at a random time.
      KillOnce(i % 2 == 0 ? nullptr : &kFailpoints[static_cast<std::size_t>(i / 2) % 8]);
      if (i % kKillsOfACheck == kKillsOfACheck - 1) Keep();
    }
    if (trial_.is_broken()) return;
    if (trial_.Boot() && trial_.InspectRestart()) trial_.Conclude();
    Keep();
  }

 private:
  void KillOnce(const Failpoint* failpoint) {
    std::vector<std::string> environment;
    if (failpoint != nullptr) {
      const int pass = Draw(1, failpoint->max_pass);
      environment = {"CWM_FAILPOINT=" + std::string(failpoint->name) + ":" + std::to_string(pass)};
    }
    const bool may_end = failpoint != nullptr;
    bool was_killed = false;
    if (trial_.Boot(environment, may_end) && trial_.InspectRestart(false, may_end)) {
      trial_.workload().Start(trial_.server().address());
      std::thread backup;
      if (failpoint != nullptr && failpoint->name == std::string("backup")) {
        backup = std::thread([this] { trial_.BackUp(); });
      }
      const milliseconds time(failpoint != nullptr ? 600 : Draw(10, 250));
      was_killed = !trial_.server().WaitForEnd(time).has_value();
      if (was_killed) trial_.server().Kill();
      trial_.workload().Stop();
      if (backup.joinable()) backup.join();
    }
    if (trial_.is_broken()) return;
    campaign_.Add("kills");
    if (failpoint == nullptr) {
      campaign_.Add("kills_at_random");
      if (!was_killed) trial_.Complain("the server ended by itself: " + trial_.server().LogTail());
    } else {
      campaign_.Add((was_killed ? "not_reached_" : "kills_at_") + std::string(failpoint->name));
    }
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
