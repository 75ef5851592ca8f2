#include <chrono>
#include <random>
#include <string>
#include <thread>

#include <signal.h>

#include "tests/fault/campaigns.h"
#include "tests/fault/fault_switch.h"
#include "tests/fault/trial.h"

namespace cwm::fault {
namespace {

using std::chrono::milliseconds;

class HistoryTrial {
 public:
  explicit HistoryTrial(Campaign& campaign)
      : campaign_(campaign),
        seed_(campaign.NextSeed()),
        random_(seed_),
        trial_(campaign, OptionsOf(seed_)),
        faults_(trial_.scratch() / "faults", trial_.store()) {}

  void Run() {
    if (!trial_.Boot(faults_.environment()) || !trial_.Prepare()) return;
    const int rounds = Draw(2, 4);
    for (int i = 0; i < rounds && !trial_.is_broken(); ++i) Round();
    if (!trial_.is_broken()) trial_.Conclude();
    trial_.server().Kill();
    trial_.CheckHistory();
    campaign_.Add("histories");
    campaign_.Save();
  }

 private:
  // Some clients, some load, some answers that are given up too early.
  static WorkloadOptions OptionsOf(std::uint32_t seed) {
    WorkloadOptions options{.seed = seed};
    options.writers = 1 + static_cast<int>(seed % 4);
    options.has_states = seed % 3 != 0;
    options.pause = std::chrono::microseconds(seed % 2 == 0 ? 200 : 2'000);
    if (seed % 5 == 0) options.deadline = milliseconds(800);  // shorter than a pause of the server
    return options;
  }

  void Round() {
    trial_.workload().Start(trial_.server().address());
    std::this_thread::sleep_for(milliseconds(Draw(50, 700)));
    const int fault = campaign_.settings().in_memory ? Draw(2, 3) : Draw(0, 6);
    switch (fault) {
      case 0:
      case 1:
        campaign_.Add("with_kill");
        trial_.server().Kill();
        BringBack();
        return;
      case 2:
        campaign_.Add("with_pause");
        trial_.server().Signal(SIGSTOP);
        std::this_thread::sleep_for(milliseconds(1'000));
        trial_.server().Signal(SIGCONT);
        break;
      case 3:
        break;
      case 4:
      case 5:
        campaign_.Add("with_full_disk");
        faults_.Set(Draw(0, 1) == 0 ? DiskFault::kFull : DiskFault::kTorn, Draw(0, 40));
        std::this_thread::sleep_for(milliseconds(Draw(100, 400)));
        if (Draw(0, 2) == 0) {
          campaign_.Add("with_kill_when_full");
          trial_.server().Kill();
          faults_.Clear();
          BringBack();
          return;
        }
        faults_.Clear();
        break;
      default:
        campaign_.Add("with_restart");
        if (const int code = trial_.server().Stop(); code != 0) {
          trial_.Complain("the server ended with " + std::to_string(code) +
                          " after SIGTERM: " + trial_.server().LogTail());
        }
        BringBack();
        return;
    }
    std::this_thread::sleep_for(milliseconds(Draw(50, 300)));
    trial_.workload().Stop();
  }

  void BringBack() {
    trial_.workload().Stop();
    if (trial_.Boot(faults_.environment())) trial_.InspectRestart();
  }

  int Draw(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }

  Campaign& campaign_;
  std::uint32_t seed_;
  std::mt19937 random_;
  Trial trial_;
  FaultSwitch faults_;
};

}  // namespace

void RunHistories(Campaign& campaign) {
  while (campaign.GoesOn("histories")) {
    HistoryTrial(campaign).Run();
    if (campaign.Count("histories") % 10 == 0) campaign.Print();
  }
}

}  // namespace cwm::fault
