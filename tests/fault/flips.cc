#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/fault/campaigns.h"
#include "tests/fault/fingerprint.h"
#include "tests/fault/trial.h"

namespace cwm::fault {
namespace {

namespace fs = std::filesystem;

// Of files up to this size every byte has a bit flipped, before places of the others are drawn.
constexpr std::uintmax_t kSmallFileBytes = 1'024;
constexpr auto kPatience = std::chrono::seconds(20);

struct Flip {
  std::string file;  // relative to the store
  std::uintmax_t byte = 0;
  int bit = 0;
};

std::vector<fs::path> FilesOf(const fs::path& directory) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(directory)) {
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), directory));
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The flips of one store: first each byte of the small files, then places in the other ones, each
// file as often as any other. `number` counts from 0.
Flip FlipOf(const fs::path& store, std::int64_t number) {
  std::mt19937 random(static_cast<std::uint32_t>(number));
  const int bit = static_cast<int>(random() % 8);
  std::vector<fs::path> large;
  for (const fs::path& file : FilesOf(store)) {
    const std::uintmax_t size = fs::file_size(store / file);
    if (size > kSmallFileBytes) {
      large.push_back(file);
    } else if (number < static_cast<std::int64_t>(size)) {
      return {file, static_cast<std::uintmax_t>(number), bit};
    } else {
      number -= static_cast<std::int64_t>(size);
    }
  }
  const fs::path& file = large[static_cast<std::size_t>(number) % large.size()];
  return {file, random() % fs::file_size(store / file), bit};
}

// Without what only takes space.
void Copy(const fs::path& store, const fs::path& to) {
  for (const fs::path& file : FilesOf(store)) {
    if (file == "ballast") continue;
    fs::create_directories((to / file).parent_path());
    fs::copy_file(store / file, to / file);
  }
}

void Apply(const Flip& flip, const fs::path& store) {
  std::fstream file(store / flip.file, std::ios::in | std::ios::out | std::ios::binary);
  file.seekg(static_cast<std::streamoff>(flip.byte));
  const int byte = file.get() ^ (1 << flip.bit);
  file.seekp(static_cast<std::streamoff>(flip.byte));
  file.put(static_cast<char>(byte));
}

// Two stores with the same kind of content: one was closed, one was killed and has its log.
class Flipper {
 public:
  explicit Flipper(Campaign& campaign)
      : campaign_(campaign), base_(campaign.settings().directory + "/flips-stores") {}

  bool Prepare() {
    if (campaign_.Count("flips") == 0) fs::remove_all(base_);
    if (!fs::exists(base_ / "killed") && !MakeStores()) return false;
    for (const std::string name : {"closed", "killed"}) {
      testing::ScratchDirectory scratch;
      Copy(base_ / name, scratch / "store");
      ServerProcess server(OptionsOf(scratch));
      if (!server.WaitUntilReady(kPatience)) {
        campaign_.Complain("flips: the server does not start on the " + name +
                           " store: " + server.LogTail());
        return false;
      }
      references_[name] =
          FingerprintOf(client::Connection({.address = server.address(), .deadline = kPatience}));
      server.Kill();
    }
    return true;
  }

  void FlipOne() {
    const std::int64_t number = campaign_.Count("flips");
    const std::string name = number % 2 == 0 ? "closed" : "killed";
    const Flip flip = FlipOf(base_ / name, number / 2);
    testing::ScratchDirectory scratch;
    Copy(base_ / name, scratch / "store");
    Apply(flip, scratch / "store");
    const std::string text = "bit " + std::to_string(flip.bit) + " of byte " +
                             std::to_string(flip.byte) + " of " + flip.file + " (" + name +
                             " store)";
    ServerProcess server(OptionsOf(scratch));
    if (server.WaitUntilReady(kPatience)) {
      Compare(text, references_[name], server);
    } else if (server.Running()) {
      campaign_.Complain(text + ": the server neither answers nor ends");
    } else {
      const auto code = server.WaitForEnd(kPatience);
      if (code.value_or(-1) <= 0) {
        campaign_.Complain(text + ": the server crashed: " + server.LogTail());
      } else if (server.Log().find("[error]") == std::string::npos) {
        campaign_.Complain(text + ": the server ended without a reason: " + server.LogTail());
      } else {
        campaign_.Add("told_at_start");
      }
    }
    if (server.Running()) server.Kill();
    campaign_.Add("flips");
  }

 private:
  // The server lives at the time when the stores were made, so that it still reads all of their
  // history.
  ServerOptions OptionsOf(const testing::ScratchDirectory& scratch) const {
    std::int64_t made_s = 0;
    std::ifstream(base_ / "made") >> made_s;
    const std::int64_t offset_s = made_s - NowSeconds();
    std::ofstream(scratch / "clock", std::ios::binary)
        .write(reinterpret_cast<const char*>(&offset_s), sizeof(offset_s));
    return {.program = campaign_.settings().server,
            .store = scratch / "store",
            .directory = scratch.path(),
            .environment = {"LD_PRELOAD=" CWM_SETTABLE_CLOCK,
                            "CWM_CLOCK_OFFSET=" + (scratch / "clock")}};
  }

  static std::int64_t NowSeconds() {
    return std::chrono::duration_cast<std::chrono::seconds>(
               std::chrono::system_clock::now().time_since_epoch())
        .count();
  }

  bool MakeStores() {
    for (const bool is_killed : {false, true}) {
      Trial trial(campaign_, {.seed = campaign_.NextSeed(), .writers = 2});
      if (!trial.Boot() || !trial.Prepare()) return false;
      trial.workload().Start(trial.server().address());
      std::this_thread::sleep_for(std::chrono::milliseconds(400));
      trial.workload().Stop();
      if (is_killed) {
        trial.server().Kill();
      } else {
        trial.server().Stop();
      }
      fs::create_directories(base_);
      Copy(trial.store(), base_ / (is_killed ? "killed" : "closed"));
    }
    std::ofstream(base_ / "made") << NowSeconds() + 2;
    return true;
  }

  void Compare(const std::string& text, const Fingerprint& reference, const ServerProcess& server) {
    const Fingerprint answers =
        FingerprintOf(client::Connection({.address = server.address(), .deadline = kPatience}));
    std::string told;  // the reason
    for (const auto& [what, expected] : reference) {
      const auto answer = answers.find(what);
      if (answer != answers.end() && answer->second == expected) continue;
      if (answer != answers.end() && answer->second.starts_with(kRefused)) {
        told = answer->second.substr(std::string(kRefused).size());
        continue;
      }
      campaign_.Complain(text + ": the server tells other " + what +
                         " without a word: " + server.LogTail());
      return;
    }
    campaign_.Add(told.empty() ? "without_effect" : "told_in_answers");
    if (!told.empty()) campaign_.Add("told_" + told);
  }

  Campaign& campaign_;
  fs::path base_;
  std::map<std::string, Fingerprint> references_;
};

}  // namespace

void RunFlips(Campaign& campaign) {
  Flipper flipper(campaign);
  if (!flipper.Prepare()) return;
  while (campaign.GoesOn("flips")) {
    flipper.FlipOne();
    if (campaign.Count("flips") % 50 == 0) {
      campaign.Save();
      campaign.Print();
    }
  }
}

}  // namespace cwm::fault
