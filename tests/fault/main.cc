// cwm-fault: breaks servers and their stores, and checks what their clients saw. `./dev fault`
// calls it; README.md describes the campaigns.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/fault/campaigns.h"

namespace {

using cwm::fault::Campaign;
using cwm::fault::Settings;

struct Options {
  std::string name;
  std::string file;  // of `check`
  std::int64_t count = 0;
  std::int64_t seconds = 0;
  bool fresh = false;
  bool in_memory = false;
  bool syncs_lie = false;
};

// What a whole campaign reaches, and the share of it in CI, with the time that it may take there: 6
// min in all.
struct Entry {
  const char* name;
  std::int64_t count;
  std::int64_t ci_count;
  std::chrono::seconds ci_time;
};
constexpr Entry kEntries[] = {{"kills", 5'000, 50, std::chrono::seconds(80)},
                              {"cuts", 200, 5, std::chrono::seconds(30)},
                              {"disk", 120, 6, std::chrono::seconds(40)},
                              {"flips", 3'000, 60, std::chrono::seconds(20)},
                              {"histories", 1'000, 50, std::chrono::seconds(180)}};

// False if it cannot be run here.
bool RunOne(Campaign& campaign, const std::string& name) {
  if (name == "cuts") return cwm::fault::RunCuts(campaign);
  if (name == "kills") cwm::fault::RunKills(campaign);
  if (name == "disk") cwm::fault::RunDisks(campaign);
  if (name == "flips") cwm::fault::RunFlips(campaign);
  if (name == "histories") cwm::fault::RunHistories(campaign);
  return true;
}

// The exit code: 1 for violations.
int RunEntry(const Entry& entry, const Settings& given, bool fresh, const std::string& state_name) {
  Settings settings = given;
  if (settings.count == 0) settings.count = entry.count;
  Campaign campaign(state_name, settings, fresh);
  const bool ran = RunOne(campaign, entry.name);
  campaign.Save();
  campaign.Print();
  if (!ran) std::printf("%s: skipped, see above\n", entry.name);
  return campaign.has_violations() ? 1 : 0;
}

int RunCi(const Settings& settings) {
  int code = 0;
  for (const Entry& entry : kEntries) {
    Settings share = settings;
    share.count = entry.ci_count;
    share.time = entry.ci_time;
    code |= RunEntry(entry, share, /*fresh=*/true, std::string("ci-") + entry.name);
  }
  return code;
}

int CheckFile(const std::string& path) {
  std::ifstream file(path);
  if (!file) {
    std::fprintf(stderr, "cannot read %s\n", path.c_str());
    return 2;
  }
  const cwm::fault::Report report = cwm::fault::Check(cwm::fault::ReadHistory(file));
  for (const auto& violation : report.violations) {
    std::printf("%s: %s\n", violation.rule.c_str(), violation.text.c_str());
  }
  std::printf("%zu violations\n", report.violations.size());
  return report.violations.empty() ? 0 : 1;
}

int Run(const Options& options) {
  if (options.name == "check") return CheckFile(options.file);
  const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  Settings settings{.server = folder / "cwm-server",
                    .directory = folder.parent_path() / "fault",
                    .count = options.count,
                    .syncs_lie = options.syncs_lie,
                    .in_memory = options.in_memory};
  if (options.seconds > 0) settings.time = std::chrono::seconds(options.seconds);
  if (options.name == "ci") return RunCi(settings);
  int code = 0;
  for (const Entry& entry : kEntries) {
    if (options.name != "all" && options.name != entry.name) continue;
    code |= RunEntry(entry, settings, options.fresh, entry.name);
  }
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Breaks servers and their stores, and checks what their clients saw.", "cwm-fault");
  Options options;
  app.add_option("name", options.name, "all, ci, check, or one campaign")
      ->check(CLI::IsMember({"all", "ci", "check", "kills", "cuts", "disk", "flips", "histories"}))
      ->default_val("all");
  app.add_option("file", options.file, "the history that `check` reads");
  app.add_option("--count", options.count, "what all runs of the campaign together shall reach")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--seconds", options.seconds, "end this run earlier")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--fresh", options.fresh, "forget earlier runs of the campaign");
  app.add_flag("--memory", options.in_memory,
               "histories without a store, and without kills: for work on the checker");
  app.add_flag("--syncs-lie", options.syncs_lie,
               "cuts of a server whose flushes do nothing: they must find lost writes");
  CLI11_PARSE(app, argc, argv);
  return Run(options);
}
