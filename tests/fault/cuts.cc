#include <chrono>
#include <cstdio>
#include <random>
#include <string>
#include <utility>

#include "tests/fault/campaigns.h"
#include "tests/fault/fault_switch.h"
#include "tests/fault/loop_disk.h"
#include "tests/fault/trial.h"

namespace cwm::fault {
namespace {

constexpr std::int64_t kDiskBytes = std::int64_t{256} << 20;
constexpr int kCutsOfAStore = 10;
// chosen: so that the empty store is on the disk before flushes do nothing.
constexpr std::int64_t kTrueCalls = 400;

// False if the disk failed, which says nothing of the server.
bool CutOnce(Campaign& campaign, LoopDisk& disk, Trial& trial, std::chrono::milliseconds after) {
  trial.workload().Start(trial.server().address());
  const bool ended = trial.server().WaitForEnd(after).has_value();
  if (ended) trial.Complain("the server ended by itself: " + trial.server().LogTail());
  Operation cut{.kind = Operation::Kind::kCut, .invoke_ns = NowNs()};
  absl::Status status = disk.Cut();
  trial.server().Kill();
  trial.workload().Stop();
  if (status.ok()) status = disk.Remount();
  if (!status.ok()) {
    std::fprintf(stderr, "cuts: %s\n", status.ToString().c_str());
    return false;
  }
  cut.return_ns = NowNs();
  trial.workload().recorder().Add(cut);
  trial.workload().ForgetInspected();
  campaign.Add("cuts");
  return true;
}

// False if the disk failed.
bool CutStore(Campaign& campaign, LoopDisk& disk) {
  const std::uint32_t seed = campaign.NextSeed();
  std::mt19937 random(seed);
  Trial trial(campaign, {.seed = seed}, disk.path() + "/store");
  FaultSwitch faults(trial.scratch() / "faults", trial.store());
  if (campaign.settings().syncs_lie) {
    trial.SetEnvironment(faults.environment());
    faults.Set(DiskFault::kSyncLies, kTrueCalls);
  }
  if (!trial.Boot() || !trial.Prepare()) return true;
  for (int i = 0; i < kCutsOfAStore && campaign.GoesOn("cuts") && !trial.is_broken(); ++i) {
    const std::chrono::milliseconds after(std::uniform_int_distribution<int>(20, 400)(random));
    if (!CutOnce(campaign, disk, trial, after)) return false;
    if (!trial.Boot() || !trial.InspectRestart()) break;
    if (random() % 3 != 0) continue;
    trial.server().Kill();  // what the restart decided must be durable itself
    if (!trial.Boot() || !trial.InspectRestart()) break;
  }
  if (!trial.is_broken()) trial.Conclude();
  trial.server().Kill();
  trial.CheckHistory();
  campaign.Save();
  campaign.Print();
  return true;
}

}  // namespace

bool RunCuts(Campaign& campaign) {
  while (campaign.GoesOn("cuts")) {
    const auto disk = LoopDisk::Make(kDiskBytes);
    if (!disk.ok()) {
      std::fprintf(stderr, "cuts: %s\n", disk.status().ToString().c_str());
      return false;
    }
    if (!CutStore(campaign, **disk)) return false;
  }
  return true;
}

}  // namespace cwm::fault
