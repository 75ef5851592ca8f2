#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <memory>
#include <random>
#include <string>
#include <thread>

#include "tests/fault/campaigns.h"
#include "tests/fault/fault_switch.h"
#include "tests/fault/loop_disk.h"
#include "tests/fault/trial.h"

namespace cwm::fault {
namespace {

using std::chrono::milliseconds;

struct Kind {
  const char* name;
  DiskFault fault;
};
constexpr std::array<Kind, 6> kKinds = {{{"sync_fails", DiskFault::kSyncFails},
                                         {"write_fails", DiskFault::kWriteFails},
                                         {"full", DiskFault::kFull},
                                         {"torn", DiskFault::kTorn},
                                         {"short", DiskFault::kShort},
                                         {"really_full", DiskFault::kNone}}};

// chosen: what a client must wait at most until a server with a full disk refuses, and until it
// takes writes again once there is room.
constexpr milliseconds kPatience(15'000);
constexpr std::int64_t kSmallDiskBytes = std::int64_t{64} << 20;

class DiskTrial {
 public:
  DiskTrial(Campaign& campaign, const Kind& kind, std::unique_ptr<LoopDisk> disk)
      : campaign_(campaign),
        kind_(kind),
        seed_(campaign.NextSeed()),
        random_(seed_),
        disk_(std::move(disk)),
        trial_(campaign, {.seed = seed_}, disk_ ? disk_->path() + "/store" : ""),
        faults_(trial_.scratch() / "faults", trial_.store()) {}

  ~DiskTrial() { trial_.server().Kill(); }

  void Run() {
    if (!trial_.Boot(faults_.environment()) || !trial_.Prepare()) return;
    trial_.workload().Start(trial_.server().address());
    std::this_thread::sleep_for(milliseconds(Draw(50, 300)));
    switch (kind_.fault) {
      case DiskFault::kSyncFails:
      case DiskFault::kWriteFails:
        FailAtOnce();
        break;
      case DiskFault::kShort:
        WriteShort();
        break;
      default:
        FillUp();
        break;
    }
    if (!trial_.is_broken()) trial_.Conclude();
    trial_.CheckHistory();
    campaign_.Add("disks");
    campaign_.Add(std::string("disks_") + kind_.name);
  }

 private:
  // The process ends, says why, and has lost nothing.
  void FailAtOnce() {
    faults_.Set(kind_.fault, Draw(0, 40));
    const std::optional<int> code = trial_.server().WaitForEnd(kPatience);
    trial_.workload().Stop();
    faults_.Clear();
    const std::string log = trial_.server().Log();
    if (!code) {
      Complain("the server goes on although its disk fails");
      trial_.server().Kill();
    } else if (*code <= 0) {
      Complain("the server ended with " + std::to_string(*code) + ", must be an exit code above 0");
    } else if (log.find("STORE_FAILED") == std::string::npos &&
               log.find("Input/output error") == std::string::npos &&
               log.find("disk I/O error") == std::string::npos) {
      Complain("the server does not say why it ended");
    }
    if (trial_.Boot()) trial_.InspectRestart();
  }

  void WriteShort() {
    faults_.Set(kind_.fault, 0);
    std::this_thread::sleep_for(milliseconds(Draw(200, 400)));
    if (faults_.hits() == 0) Complain("no write was short");
    if (Draw(0, 1) == 0) {
      trial_.server().Kill();
      trial_.workload().Stop();
      faults_.Clear();
      if (trial_.Boot()) trial_.InspectRestart();
    } else {
      faults_.Clear();
      trial_.workload().Stop();
    }
  }

  // Reads go on, writes are refused, and resume when there is room.
  void FillUp() {
    if (disk_) {
      if (const auto status = disk_->Fill(); !status.ok()) {
        std::fprintf(stderr, "disk: %s\n", status.ToString().c_str());
      }
    } else {
      faults_.Set(kind_.fault, Draw(0, 40));
    }
    const Workload::Counts before = trial_.workload().counts();
    const bool refuses = WaitFor([&] { return trial_.workload().counts().full > before.full; });
    if (!refuses) Complain("no write was refused with DISK_FULL");
    const Workload::Counts full = trial_.workload().counts();
    if (!WaitFor([&] { return trial_.workload().counts().reads > full.reads; })) {
      Complain("no read was answered while the disk was full");
    }
    if (Draw(0, 2) == 0) {
      KillWhileFull();
      return;
    }
    MakeRoom();
    const Workload::Counts room = trial_.workload().counts();
    if (!WaitFor([&] { return trial_.workload().counts().written > room.written + 3; })) {
      Complain("no write was taken after there was room again");
    }
    trial_.workload().Stop();
  }

  void KillWhileFull() {
    trial_.server().Kill();
    trial_.workload().Stop();
    MakeRoom();
    if (trial_.Boot(faults_.environment())) trial_.InspectRestart();
  }

  void MakeRoom() {
    faults_.Clear();
    if (disk_) disk_->Empty();
  }

  template <class Condition>
  bool WaitFor(const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (!condition() && std::chrono::steady_clock::now() < end && trial_.server().Running()) {
      std::this_thread::sleep_for(milliseconds(5));
    }
    return condition();
  }

  void Complain(const std::string& text) {
    trial_.Complain(std::string(kind_.name) + ": " + text + ": " + trial_.server().LogTail());
  }
  int Draw(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }

  Campaign& campaign_;
  const Kind& kind_;
  std::uint32_t seed_;
  std::mt19937 random_;
  std::unique_ptr<LoopDisk> disk_;
  Trial trial_;
  FaultSwitch faults_;
};

}  // namespace

void RunDisks(Campaign& campaign) {
  while (campaign.GoesOn("disks")) {
    const Kind& kind = kKinds[static_cast<std::size_t>(campaign.Count("disks")) % kKinds.size()];
    std::unique_ptr<LoopDisk> disk;
    if (kind.fault == DiskFault::kNone) {
      auto made = LoopDisk::Make(kSmallDiskBytes);
      if (!made.ok()) {
        std::fprintf(stderr, "disk: skipped: %s\n", made.status().ToString().c_str());
        campaign.Add("disks");
        campaign.Add("disks_skipped");
        continue;
      }
      disk = *std::move(made);
    }
    DiskTrial(campaign, kind, std::move(disk)).Run();
    campaign.Save();
    campaign.Print();
  }
}

}  // namespace cwm::fault
