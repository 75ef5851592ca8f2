#include "clients/planner/plan_report.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"

namespace cwm::planner {
namespace {

const char* NameOf(Outcome outcome) {
  switch (outcome) {
    case Outcome::kSolved:
      return "SOLVED";
    case Outcome::kStartOutOfLimits:
      return "START_OUT_OF_LIMITS";
    case Outcome::kGoalOutOfLimits:
      return "GOAL_OUT_OF_LIMITS";
    case Outcome::kStartInCollision:
      return "START_IN_COLLISION";
    case Outcome::kGoalInCollision:
      return "GOAL_IN_COLLISION";
    case Outcome::kGoalUnreachable:
      return "GOAL_UNREACHABLE";
    case Outcome::kNoPath:
      return "NO_PATH";
  }
  return "";
}

const char* InWords(Outcome outcome) {
  switch (outcome) {
    case Outcome::kSolved:
      return "solved";
    case Outcome::kStartOutOfLimits:
      return "start out of limits";
    case Outcome::kGoalOutOfLimits:
      return "goal out of limits";
    case Outcome::kStartInCollision:
      return "start in collision";
    case Outcome::kGoalInCollision:
      return "goal in collision";
    case Outcome::kGoalUnreachable:
      return "goal unreachable";
    case Outcome::kNoPath:
      return "no path";
  }
  return "";
}

void PrintPath(const PlanReport& report, std::ostream& out) {
  constexpr std::size_t kNumberWidth = 8;
  std::string header = "ROW";
  for (const Joint& joint : report.group.joints) {
    absl::StrAppend(&header, "  ",
                    absl::StrFormat("%*s", std::max(kNumberWidth, joint.name.size()), joint.name));
  }
  out << header << "\n";
  for (std::size_t k = 0; k < report.result.path.size(); ++k) {
    std::string line = absl::StrFormat("%3d", k);
    for (std::size_t j = 0; j < report.group.joints.size(); ++j) {
      const std::size_t width = std::max(kNumberWidth, report.group.joints[j].name.size());
      absl::StrAppend(&line, "  ", absl::StrFormat("%*.4f", width, report.result.path[k][j]));
    }
    out << line << "\n";
  }
}

}  // namespace

std::string Summary(const PlanReport& report) {
  const std::string words = InWords(report.result.outcome);
  return report.reason.empty() ? words : absl::StrCat(words, ": ", report.reason);
}

void PrintTable(const PlanReport& report, std::ostream& out) {
  const PlanResult& result = report.result;
  if (result.outcome == Outcome::kSolved) {
    PrintPath(report, out);
    if (!report.tool_link.empty()) {
      out << "the pose of the tool on " << report.tool_link << " has " << report.goal_count
          << (report.goal_count == 1 ? " free state" : " free states") << " that were tried\n";
    }
    out << absl::StrFormat(
        "length %.3f (%.3f before it was shortened), %.1f ms (%.1f to find, %.1f "
        "to shorten)\n",
        result.length, result.found_length, 1e3 * (result.finding_s + result.shortening_s),
        1e3 * result.finding_s, 1e3 * result.shortening_s);
  }
  if (report.certificate) {
    out << "certified: " << api::NameOf(report.certificate->verdict);
    if (report.certificate->verdict == MotionVerdict::kFree) {
      out << absl::StrFormat(", clearance at least %.1f mm", 1e3 * report.certificate->clearance_m);
    } else if (!report.certificate->contact.empty()) {
      out << " after row " << report.certificate->segment << ", " << report.certificate->contact;
    }
    out << ", trust " << api::NameOf(report.certificate->accuracy) << "\n";
  } else if (result.outcome == Outcome::kSolved) {
    out << absl::StrFormat("free at states %g apart; in between --certify asks\n", kFineStep);
  }
  out << "asked " << result.checks.states << " states in " << result.checks.batches
      << (result.checks.batches == 1 ? " batch" : " batches") << " of revision "
      << report.world.revision << "\n";
}

void PrintJson(const PlanReport& report, std::ostream& out) {
  const PlanResult& result = report.result;
  nlohmann::ordered_json json = {
      {"outcome", NameOf(result.outcome)},
      {"why", report.reason},
      {"world", report.world.name.empty() ? "default" : report.world.name},
      {"world_uid", report.world.world_uid},
      {"revision", report.world.revision},
      {"robot", report.world.robot.name()},
      {"group", report.group.name}};
  json["joints"] = nlohmann::json::array();
  for (const Joint& joint : report.group.joints) json["joints"].push_back(joint.name);
  json["path"] = result.path;
  json["length"] = result.length;
  json["found_length"] = result.found_length;
  json["finding_s"] = result.finding_s;
  json["shortening_s"] = result.shortening_s;
  json["batches"] = result.checks.batches;
  json["states"] = result.checks.states;
  if (!report.tool_link.empty()) {
    json["tool_link"] = report.tool_link;
    json["goal_states"] = report.goal_count;
  }
  if (report.certificate) {
    json["certificate"] = {{"verdict", api::NameOf(report.certificate->verdict)},
                           {"clearance_m", report.certificate->clearance_m},
                           {"segment", report.certificate->segment},
                           {"what_is_met", report.certificate->contact},
                           {"trust", api::NameOf(report.certificate->accuracy)}};
  }
  // Names may not be valid UTF-8: invalid bytes are replaced instead of throwing.
  out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
}

}  // namespace cwm::planner
