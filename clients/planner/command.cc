#include "clients/planner/command.h"

#include <ompl/util/Console.h>

#include <CLI/CLI.hpp>
#include <map>
#include <optional>
#include <ostream>
#include <sstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"
#include "clients/cli/one_of.h"
#include "clients/cli/pose_argument.h"
#include "clients/cli/session.h"
#include "clients/cpp/connection.h"
#include "clients/planner/path_queries.h"
#include "clients/planner/plan_motion.h"
#include "clients/planner/plan_report.h"
#include "clients/planner/plan_task.h"
#include "clients/planner/server_checker.h"
#include "manual/manual_page.h"

namespace cwm::planner {
namespace {

using cli::UsageError;

constexpr char kDescription[] =
    "cwm-plan: a motion of a robot that the server has, free of collision\n\n"
    "Examples:\n"
    "  cwm-plan --robot panda --problem scene0001.yaml request0001.yaml\n"
    "  cwm-plan --robot panda --group panda_arm --start extended --goal ready\n"
    "  cwm-plan --group panda_arm --start ready --goal=-1.2,0.3,0,-1.9,0,1.6,0.8 -o json\n"
    "  cwm-plan --group panda_arm --goal-at 0.4,0,0.5,1,0,0,0 --x-link-tool 0,0,0.1034\n"
    "  cwm-plan request.yaml --certify\n\n"
    "Without a start, from where the robot stands; options go before what the request says. The\n"
    "world is not changed: a scene given with --problem is laid over the questions.\n\n"
    "Exit codes: 0 solved, 1 usage, 2 unavailable, 3 not found, 4 revision conflict, 5 deadline,\n"
    "6 permission, 7 resource exhausted, 8 bad input, 10 start in collision, 11 goal in "
    "collision,\n"
    "12 start out of limits, 13 goal out of limits, 14 no path in the time given, 15 path not\n"
    "certified (with --certify), 16 goal unreachable (with --goal-at), 70 anything else.";

constexpr double kMaxPlanTime_s = 86'400;

enum class Form { kTable = 1, kJson };

// The goal as a pose of the tool, as typed.
struct PoseArguments {
  std::string at, x_link_tool;
  PoseGoal goal = {};
};

struct Arguments {
  TaskArguments task;
  PoseArguments pose;
  std::string address;
  Form form = Form::kTable;
  bool certify = false;
};

// The words of `cwm solve`, whose --at is the pose of the tool.
void AddPoseOptions(CLI::App& app, PoseArguments& pose) {
  CLI::Option* const at =
      app.add_option("--goal-at", pose.at,
                     "in place of --goal: the pose of the tool in the world (m); the path ends in "
                     "any free state in which it is there")
          ->type_name(cli::kPoseArgumentForm)
          ->excludes("--goal");
  CLI::Option* const tool =
      app.add_option("--tool", pose.goal.tool,
                     "a tool that the robot was loaded with; default: that of the group")
          ->type_name("NAME")
          ->needs(at);
  app.add_option("--tool-link", pose.goal.tool_link,
                 "the link that carries the tool; default: that of the group's end effector")
      ->type_name("LINK")
      ->needs(at)
      ->excludes(tool);
  app.add_option("--x-link-tool", pose.x_link_tool, "the tool in that link's frame (m)")
      ->type_name("X,Y,Z[,QX,QY,QZ,QW]")
      ->needs(at)
      ->excludes(tool);
  app.add_option("--position-tolerance", pose.goal.position_tolerance_m,
                 "largest error of the pose (m); default: 1e-6")
      ->type_name("M")
      ->needs(at);
  app.add_option("--rotation-tolerance", pose.goal.rotation_tolerance_rad,
                 "largest error of the pose (rad); default: 1e-6")
      ->type_name("RAD")
      ->needs(at);
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  static const std::map<std::string, Form> kForms = {{"table", Form::kTable},
                                                     {"json", Form::kJson}};
  app.add_option("REQUEST", arguments.task.request, "a MoveIt motion plan request (YAML)");
  app.add_option(
         "--problem", arguments.task.problem,
         "a MoveIt planning scene (YAML or .scene) to plan in, instead of what the world has")
      ->type_name("SCENE");
  app.add_option("--robot", arguments.task.robot, "a robot of the world; default: the only one")
      ->type_name("NAME");
  app.add_option("--group", arguments.task.group,
                 "the joints that move; default: the request's, else all of the robot's")
      ->type_name("NAME");
  app.add_option("--start", arguments.task.start,
                 "rad, m (--start=-1,... where it begins with a minus), or a state that the SRDF "
                 "names; default: the request's, else as the robot stands")
      ->type_name("V,V,...|STATE");
  app.add_option("--goal", arguments.task.goal, "likewise; default: the request's")
      ->type_name("V,V,...|STATE");
  AddPoseOptions(app, arguments.pose);
  app.add_option("--time", arguments.task.time_s,
                 "seconds to look for a path; default: the request's, else 5")
      ->type_name("S");
  app.add_option("--range", arguments.task.options.connect.range,
                 "the longest motion that the search grows by; default: 1 (rad, m)")
      ->type_name("D");
  app.add_option("--seed", arguments.task.options.seed, "the same seed plans the same; default: 1")
      ->type_name("N");
  app.add_flag("--certify", arguments.certify,
               "ask the server about the path between its states as well, some 100 ms more, and "
               "plan anew with the next seed where it is not free");
  app.add_option(
         "--addr", arguments.address,
         std::string("unix:PATH or HOST:PORT of the server; default ") + kDefaultAddressRule)
      ->type_name("ADDR");
  app.add_option("-w,--world", arguments.task.world, "the world; default: \"default\"")
      ->type_name("NAME");
  app.add_option("-o,--output", arguments.form, "table (default) or json")
      ->transform(cli::OneOf(kForms))
      ->type_name("FORM");
}

absl::Status CheckArguments(const Arguments& arguments) {
  const TaskArguments& task = arguments.task;
  if (task.goal.empty() && arguments.pose.at.empty() && task.request.empty()) {
    return UsageError("--goal or --goal-at, or a request with a goal, must be given");
  }
  if (arguments.task.time_s &&
      !(*arguments.task.time_s > 0 && *arguments.task.time_s <= kMaxPlanTime_s)) {
    return UsageError(absl::StrCat("--time is ", *arguments.task.time_s,
                                   ", must be more than 0 and at most ", kMaxPlanTime_s, " s"));
  }
  const double range = arguments.task.options.connect.range;
  if (!(range >= kCoarseStep && range <= 1e6)) {
    return UsageError(
        absl::StrCat("--range is ", range, ", must be at least ", kCoarseStep, " and at most 1e6"));
  }
  return absl::OkStatus();
}

PlanExit ExitOf(const PlanReport& report) {
  switch (report.result.outcome) {
    case Outcome::kSolved:
      break;
    case Outcome::kStartOutOfLimits:
      return PlanExit::kStartOutOfLimits;
    case Outcome::kGoalOutOfLimits:
      return PlanExit::kGoalOutOfLimits;
    case Outcome::kStartInCollision:
      return PlanExit::kStartInCollision;
    case Outcome::kGoalInCollision:
      return PlanExit::kGoalInCollision;
    case Outcome::kGoalUnreachable:
      return PlanExit::kGoalUnreachable;
    case Outcome::kNoPath:
      return PlanExit::kNoPath;
  }
  const bool doubted = report.certificate && report.certificate->verdict != MotionVerdict::kFree;
  return doubted ? PlanExit::kNotCertified : PlanExit::kSolved;
}

// The explanation of an outcome besides its name.
absl::StatusOr<std::string> Reason(const Task& task, const PlanResult& result,
                                   const SolvedGoal& solved) {
  switch (result.outcome) {
    case Outcome::kSolved:
      return "";
    case Outcome::kNoPath:
      return absl::StrCat("none was found in ", task.options.time_limit_s,
                          " s (--time); there may be none");
    case Outcome::kStartInCollision:
      return DescribeCollision(*task.query, task.problem.start);
    case Outcome::kGoalInCollision:
      return DescribeCollision(*task.query, task.problem.goals.front());
    case Outcome::kGoalUnreachable:
      return absl::StrFormat(
          "%s is %.1f mm and %.3f rad off in the nearest state that was met; there may be others",
          solved.tool_link, 1e3 * solved.position_error_m, solved.rotation_error_rad);
    case Outcome::kStartOutOfLimits:
    case Outcome::kGoalOutOfLimits:
      break;
  }
  const bool is_start = result.outcome == Outcome::kStartOutOfLimits;
  const Joint& joint = task.problem.joints[*result.joint];
  return absl::StrCat(joint.name, " is ",
                      (is_start ? task.problem.start : task.problem.goals.front())[*result.joint],
                      ", must be ", joint.lower, " to ", joint.upper);
}

struct Planned {
  PlanResult result;
  std::optional<Certificate> certificate = {};
};

// The arguments with the pose of --goal-at, for which the server is asked if it names an object.
absl::StatusOr<TaskArguments> ReadPose(const Arguments& arguments, std::ostream& out,
                                       std::ostream& err) {
  TaskArguments task = arguments.task;
  const PoseArguments& given = arguments.pose;
  if (given.at.empty()) return task;
  if (!task.problem.empty() && !cli::StartsWithNumber(given.at)) {
    return UsageError("--goal-at: with --problem it must be numbers, X,Y,Z[,QX,QY,QZ,QW] (m)");
  }
  std::istringstream none;
  cli::Session session({.in = none, .out = out, .err = err});
  session.address = arguments.address.empty() ? DefaultAddress() : arguments.address;
  session.world = task.world;
  const auto at = cli::ParsePoseArgument(session, given.at, "--goal-at");
  if (!at.ok()) return at.status();
  task.pose = given.goal;
  task.pose->x_world_tool = *at;
  if (given.x_link_tool.empty()) return task;
  const auto tool = cli::ParsePose(given.x_link_tool, "--x-link-tool");
  if (!tool.ok()) return tool.status();
  task.pose->x_link_tool = *tool;
  return task;
}

// chosen: 7 paths of 700 problems of MotionBenchMaker have contact between their states: a second
// try fails rarely, a third hardly ever.
constexpr int kMaxTries = 5;

absl::StatusOr<Planned> PlanCertified(const Task& task, bool certify) {
  ServerChecker checker(*task.query);
  PlanOptions options = task.options;
  Planned planned;
  for (int tried = 0; tried < kMaxTries; ++tried, ++options.seed) {
    auto result = PlanMotion(task.problem, checker, options);
    if (!result.ok()) return result.status();
    // An uncertified path is better than none.
    if (result->outcome != Outcome::kSolved && planned.certificate) break;
    planned.result = *std::move(result);
    if (!certify || planned.result.outcome != Outcome::kSolved) break;
    auto certificate = CertifyPath(*task.query, planned.result.path);
    if (!certificate.ok()) return certificate.status();
    planned.certificate = *std::move(certificate);
    if (planned.certificate->verdict == MotionVerdict::kFree) break;
  }
  return planned;
}

absl::StatusOr<PlanExit> Plan(const Arguments& arguments, std::ostream& out, std::ostream& err) {
  if (absl::Status status = CheckArguments(arguments); !status.ok()) return status;
  client::ConnectOptions options;
  if (!arguments.address.empty()) options.address = arguments.address;
  const client::Connection connection(options);
  const auto asked = ReadPose(arguments, out, err);
  if (!asked.ok()) return asked.status();
  std::vector<std::string> warnings;
  auto task = ReadTask(connection, *asked, warnings);
  for (const std::string& warning : warnings) err << "cwm-plan: warning: " << warning << "\n";
  if (!task.ok()) return task.status();
  SolvedGoal solved;
  if (task->pose) {
    auto goal = SolveGoal(*task->query, task->problem.start, *task->pose);
    if (!goal.ok()) return goal.status();
    solved = *std::move(goal);
    task->problem.goals = solved.rows;
  }
  absl::StatusOr<Planned> planned = Planned{.result = {.outcome = Outcome::kGoalUnreachable}};
  if (solved.status != PoseStatus::kUnreachable) {
    planned = PlanCertified(*task, arguments.certify);
  }
  if (!planned.ok()) return planned.status();
  const PlanResult& result = planned->result;
  auto reason = Reason(*task, result, solved);
  if (!reason.ok()) return reason.status();
  const bool has_no_state = task->pose && solved.status != PoseStatus::kSolved;
  const std::size_t goal_count = has_no_state ? 0 : task->problem.goals.size();
  const PlanReport report{.world = task->world,
                          .group = task->group,
                          .result = result,
                          .reason = *std::move(reason),
                          .certificate = planned->certificate,
                          .goal_count = goal_count,
                          .tool_link = solved.tool_link};
  if (arguments.form == Form::kJson) {
    PrintJson(report, out);
  } else {
    PrintTable(report, out);
  }
  if (result.outcome != Outcome::kSolved) err << "cwm-plan: " << Summary(report) << "\n";
  return ExitOf(report);
}

int Explain(const absl::Status& status, const std::string& address, std::ostream& err) {
  const client::ErrorDetails details = client::DetailsOf(status);
  err << "cwm-plan: " << status.message() << "\n";
  for (const auto& [field, description] : details.fields) {
    const std::string line = absl::StrCat(field, ": ", description);
    if (line != status.message()) err << "  " << line << "\n";
  }
  if (absl::IsUnavailable(status)) {
    err << "hint: tried " << address
        << "; start `cwm-server`, or name another with --addr or CWM_ADDR\n";
  } else if (cli::IsUsageError(status)) {
    err << "hint: `cwm-plan --help` shows examples and units\n";
  }
  return static_cast<int>(cli::ExitCodeOf(status));
}

}  // namespace

int Run(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  ompl::msg::noOutputHandler();  // its messages are in the answers
  Arguments parsed;
  CLI::App app(kDescription, "cwm-plan");
  app.set_version_flag("--version", "cwm-plan " CWM_VERSION);
  manual::AddManualPage(
      app, {.version = CWM_VERSION,
            .environment = {{"CWM_ADDR", "where the server is, when --addr does not say it"}}});
  AddOptions(app, parsed);
  try {  // CLI11 reports errors by exceptions, which are handled here
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
      return app.exit(error, out, err);
    }
    return Explain(UsageError(error.what()), "", err);
  }
  const auto exit = Plan(parsed, out, err);
  out.flush();
  if (!exit.ok()) {
    return Explain(exit.status(), parsed.address.empty() ? DefaultAddress() : parsed.address, err);
  }
  if (!out) return Explain(absl::InternalError("stdout cannot be written"), "", err);
  return static_cast<int>(*exit);
}

}  // namespace cwm::planner
