#include "tests/fault/campaign.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

namespace cwm::fault {
namespace {

constexpr std::size_t kMaxViolations = 100;
constexpr std::int64_t kMaxKeptHistories = 10;

}  // namespace

Campaign::Campaign(std::string name, const Settings& settings, bool fresh)
    : name_(std::move(name)), settings_(settings) {
  std::filesystem::create_directories(settings_.directory);
  if (fresh) return;
  std::ifstream file(PathOf(name_ + ".json"));
  const auto state = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (state.is_discarded()) return;
  counts_ = state.at("counts").get<std::map<std::string, std::int64_t>>();
  violations_ = state.at("violations").get<std::vector<std::string>>();
}

std::string Campaign::PathOf(const std::string& file) const {
  return settings_.directory + "/" + file;
}

std::int64_t Campaign::Count(const std::string& what) const {
  const auto found = counts_.find(what);
  return found == counts_.end() ? 0 : found->second;
}

void Campaign::AddReport(const Report& report, const Report& before) {
  Add("acknowledged", report.acknowledged - before.acknowledged);
  Add("refused", report.refused - before.refused);
  Add("unknown", report.unknown - before.unknown);
  Add("unknown_applied", report.unknown_applied - before.unknown_applied);
  Add("lost", report.lost - before.lost);
  Add("lost_observed", report.lost_observed - before.lost_observed);
  Add("revisions", report.revisions - before.revisions);
  Add("unchecked_revisions", report.unchecked_revisions - before.unchecked_revisions);
  Add("reads", report.reads - before.reads);
  Add("watch_events", report.watch_events - before.watch_events);
}

bool Campaign::GoesOn(const std::string& what) const {
  return Count(what) < settings_.count &&
         std::chrono::steady_clock::now() - start_ < settings_.time;
}

std::uint32_t Campaign::NextSeed() {
  Add("trials");
  return static_cast<std::uint32_t>(Count("trials"));
}

void Campaign::Complain(const std::string& text) {
  Add("violations");
  std::fprintf(stderr, "%s: %s\n", name_.c_str(), text.c_str());
  if (violations_.size() < kMaxViolations) violations_.push_back(text);
  Save();
}

void Campaign::Complain(const std::string& text, const History& history, std::uint32_t seed,
                        const std::string& store) {
  if (seed != kept_seed_ && Count("kept_histories") < kMaxKeptHistories) {
    kept_seed_ = seed;
    Add("kept_histories");
    const std::string stem = PathOf(name_ + "-" + std::to_string(seed));
    std::ofstream file(stem + ".history.jsonl");
    Write(history, file);
    std::error_code ignored;
    std::filesystem::copy(store, stem + ".store", std::filesystem::copy_options::recursive,
                          ignored);
  }
  Complain(text);
}

void Campaign::Save() const {
  const std::string path = PathOf(name_ + ".json");
  {
    std::ofstream file(path + ".new");
    file << nlohmann::json{{"counts", counts_}, {"violations", violations_}}.dump(2) << "\n";
  }
  std::filesystem::rename(path + ".new", path);
}

std::string Campaign::Summary() const {
  std::string text = name_ + ":";
  for (const auto& [what, count] : counts_) text += " " + what + " " + std::to_string(count);
  if (Count("violations") == 0) text += " violations 0";
  return text;
}

void Campaign::Print() {
  std::string summary = Summary();
  if (summary == printed_) return;
  printed_ = std::move(summary);
  std::printf("%s\n", printed_.c_str());
  std::fflush(stdout);
}

}  // namespace cwm::fault
