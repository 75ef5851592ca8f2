// The quality of perception without a server: quick to build while working on perception. Prints
// the same figures as ./dev bench perception.
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/benchmarks/benchmarks.h"
#include "tests/benchmarks/usage.h"

namespace cwm::benchmarks {
namespace {

struct SeededPart {
  Seeds seeds;
  void (*measure)(const Seeds&, Report&);
};

const std::map<std::string, void (*)(Report&)>& Parts() {
  static const std::map<std::string, void (*)(Report&)> parts = {
      {"quick", MeasureShapesQuickly},
      {"shapes", MeasureShapes},
      {"handles", MeasureHandles},
      {"claims", MeasureClaims},
      {"families", MeasureFamilies},
      {"ablate", MeasureAblation},
      {"labelled", MeasureLabelledScans},
      {"up", MeasureUp},
      {"cost", MeasureCost},
      {"hidden", MeasureHidden},
      {"lists", MeasureLists},
      {"thin", MeasureThin},
  };
  return parts;
}

const std::map<std::string, SeededPart>& SeededParts() {
  static const std::map<std::string, SeededPart> parts = {
      {"quick", {kSeedsOfShapesQuickly, MeasureShapesOn}},
      {"shapes", {kSeedsOfShapes, MeasureShapesOn}},
      {"handles", {kSeedsOfHandles, MeasureHandlesOn}},
      {"up", {kSeedsOfUp, MeasureUpOn}},
      {"hidden", {kSeedsOfHidden, MeasureHiddenOn}},
      {"lists", {kSeedsOfLists, MeasureListsOn}},
      {"thin", {kSeedsOfThin, MeasureThinOn}},
  };
  return parts;
}

struct Call {
  std::vector<std::string> words;
  std::string json;
  std::string first_seed, seeds;  // empty: those of the figures
};

Call Parse(int argc, char** argv) {
  Call call;
  const std::map<std::string, std::string*> options = {
      {"--json", &call.json}, {"--first-seed", &call.first_seed}, {"--seeds", &call.seeds}};
  for (int i = 1; i < argc; ++i) {
    const auto option = options.find(argv[i]);
    if (option != options.end() && i + 1 < argc) {
      *option->second = argv[++i];
    } else {
      call.words.emplace_back(argv[i]);
    }
  }
  if (call.words.empty()) call.words.emplace_back("quick");
  return call;
}

Seeds SeedsOf(const Call& call, Seeds seeds) {
  if (!call.first_seed.empty()) seeds.first = std::strtoull(call.first_seed.c_str(), nullptr, 10);
  if (!call.seeds.empty()) seeds.count = std::atoi(call.seeds.c_str());
  return seeds;
}

void Run(const Call& call, Report& report) {
  const std::vector<std::string>& words = call.words;
  const bool other_seeds = !call.first_seed.empty() || !call.seeds.empty();
  const auto part = Parts().find(words[0]);
  const auto seeded = SeededParts().find(words[0]);
  if (other_seeds && seeded != SeededParts().end()) {
    seeded->second.measure(SeedsOf(call, seeded->second.seeds), report);
  } else if (!other_seeds && words.size() == 1 && part != Parts().end()) {
    part->second(report);
  } else if (words[0] == "sensors" && words.size() <= 2) {
    MeasureOtherSensorsOn(SeedsOf(call, kSeedsOfSensors), words.size() == 2 ? words[1] : "",
                          report);
  } else if (words[0] == "families" && words.size() <= 2) {
    MeasureFamiliesOn(SeedsOf(call, kSeedsOfFamilies), words.size() == 2 ? words[1] : "", report);
  } else if (words[0] == "ablate" && words.size() <= 2) {
    MeasureAblationOn(SeedsOf(call, kSeedsOfAblation), words.size() == 2 ? words[1] : "", report);
  } else if (!other_seeds && words[0] == "scene" && (words.size() == 3 || words.size() == 4)) {
    ReplayScene(words[1], std::strtoull(words[2].c_str(), nullptr, 10),
                words.size() == 4 ? words[3] : "", report);
  } else {
    report.Fail(
        "takes quick, shapes, sensors [SENSOR], families [FAMILY], ablate [FAMILY], handles, "
        "up, hidden, lists, thin, cost, claims, labelled, or scene FAMILY SEED [SENSOR]; seeds "
        "with all "
        "but "
        "cost, claims, labelled and scene");
  }
}

}  // namespace
}  // namespace cwm::benchmarks

int main(int argc, char** argv) {
  // Rules tuned on some scenes count only if they hold on scenes that were never looked at.
  constexpr char kUsage[] =
      "cwm-bench-quality [quick|shapes|sensors [SENSOR]|families [FAMILY]|ablate [FAMILY]|\n"
      "                   handles|up|hidden|lists|thin|cost|claims|labelled|scene FAMILY SEED "
      "[SENSOR]]\n"
      "                  [--json FILE] [--first-seed N] [--seeds N]\n"
      "The last two, of all but cost, claims, labelled and scene, take other random scenes than\n"
      "those of the figures.\n";
  if (cwm::benchmarks::PrintsUsage(argc, argv, kUsage)) return 0;
  const cwm::benchmarks::Call call = cwm::benchmarks::Parse(argc, argv);
  cwm::benchmarks::Report report;
  cwm::benchmarks::Run(call, report);
  report.Print();
  if (!call.json.empty()) report.WriteJson(call.json);
  return report.failed() ? 1 : 0;
}
