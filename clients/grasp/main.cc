// cwm-grasp: plans how a parallel gripper can grasp the objects of a world.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "clients/cli/error_report.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/natural_order.h"
#include "clients/cli/number_list.h"
#include "clients/cli/quantity.h"
#include "clients/cli/table.h"
#include "clients/cpp/call_error.h"
#include "clients/formats/file_bytes.h"
#include "clients/grasp/plan_grasps.h"
#include "clients/grasp/plan_report.h"
#include "manual/manual_page.h"
#include "proto/transfer/default_address.h"

namespace {

namespace cli = cwm::cli;
namespace grasp = cwm::grasp;

struct Arguments {
  grasp::PlanRequest request;
  std::string address;  // empty: the default address
  std::string world = "default";
  std::string palm, json;
  bool json_on_stdout = false;
};

void AddOptions(CLI::App& app, Arguments& arguments, std::string& form) {
  grasp::PlanRequest& request = arguments.request;
  grasp::Gripper& gripper = request.gripper;
  app.add_option("OBJECT", request.objects, "names; default: all that can be taken");
  app.add_option("--top", request.top, "grasps of each object; default 5")->type_name("N");
  app.add_option("--json", arguments.json, "write the grasps to this file, which the viewer draws")
      ->type_name("FILE");
  app.add_option("-o,--output", form, "table (default) or json")
      ->check(CLI::IsMember({"table", "json"}).description(""))
      ->type_name("FORM");
  app.add_option("--addr", arguments.address,
                 std::string("unix:PATH or HOST:PORT; default ") + cwm::kDefaultAddressRule)
      ->type_name("ADDR");
  app.add_option("-w,--world", arguments.world, "the world; default: \"default\"")
      ->type_name("NAME");
  app.add_option("--opening", gripper.opening_m, "between the open pads; default 0.08")
      ->type_name("M");
  app.add_option("--finger-length", gripper.finger_length_m, "palm to tips; default 0.045")
      ->type_name("M");
  app.add_option("--finger-width", gripper.finger_width_m, "default 0.02")->type_name("M");
  app.add_option("--finger-thickness", gripper.finger_thickness_m,
                 "along the closing; default 0.01")
      ->type_name("M");
  app.add_option("--pad-length", gripper.pad_length_m, "from the tips back; default 0.02")
      ->type_name("M");
  app.add_option("--palm", arguments.palm,
                 "size along x, y, z of the grasp; default 0.204,0.063,0.066")
      ->type_name("X,Y,Z");
  app.add_option("--friction", request.friction, "coefficient; default 0.4")->type_name("MU");
  app.add_option("--approach", request.approach_m, "the straight way to the grasp; default 0.1")
      ->type_name("M");
  app.add_option("--clearance", request.clearance_m, "kept on that way; default 0.002")
      ->type_name("M");
}

// `json`: the file that also has the grasps; empty: none.
void Print(const grasp::Plan& plan, const std::string& json) {
  const bool color = ::isatty(STDOUT_FILENO) != 0 && std::getenv("NO_COLOR") == nullptr;
  std::vector<const grasp::ObjectPlan*> objects;
  for (const grasp::ObjectPlan& object : plan.objects) objects.push_back(&object);
  std::sort(objects.begin(), objects.end(),
            [](const grasp::ObjectPlan* a, const grasp::ObjectPlan* b) {
              return cli::NaturalLess(a->object.name, b->object.name);
            });
  std::vector<cli::TableRow> rows;
  for (const grasp::ObjectPlan* planned : objects) {
    const grasp::ObjectPlan& object = *planned;
    if (object.grasps.empty()) {
      rows.push_back({{object.object.name, "-", "", "", "", "", "", ""}, object.failure_reason});
    }
    for (const grasp::Grasp& found : object.grasps) {
      const Eigen::Vector3d p = found.candidate.X_FG.translation();
      const Eigen::Vector3d x = found.candidate.X_FG.linear().col(0);
      const Eigen::Vector3d z = found.candidate.X_FG.linear().col(2);
      const auto text = [](const Eigen::Vector3d& v) {
        return cli::FormatFixed(v.x(), 3) + " " + cli::FormatFixed(v.y(), 3) + " " +
               cli::FormatFixed(v.z(), 3);
      };
      rows.push_back(
          {{object.object.name, found.candidate.strategy, cli::FormatFixed(found.score, 2),
            cli::FormatLength(found.assessment.width_m),
            cli::FormatLength(found.assessment.clearance_m), text(p), text(z), text(x)}});
    }
  }
  cli::PrintTable({{"OBJECT"},
                   {"GRASP"},
                   {"SCORE", cli::Align::kRight},
                   {"WIDTH", cli::Align::kRight},
                   {"CLEARANCE", cli::Align::kRight},
                   {"POSITION m"},
                   {"APPROACH"},
                   {"CLOSING"}},
                  rows, color ? cli::TableStyle::kColor : cli::TableStyle::kPlain, std::cout);
  std::cout << "revision " << plan.revision << "\n"
            << (json.empty() ? "to see them: add --json FILE, then drop FILE on the viewer's page\n"
                             : "to see them: drop " + json + " on the viewer's page\n");
}

absl::StatusOr<grasp::Plan> PlanGrasps(const Arguments& arguments) {
  try {
    return grasp::PlanGrasps(cwm::Connect({.address = arguments.address, .world = arguments.world}),
                             arguments.request);
  } catch (const cwm::Error& error) {
    return cwm::client::StatusFromError(error);
  }
}

absl::Status Run(Arguments& arguments) {
  if (!arguments.palm.empty()) {
    const auto palm = cli::ParseNumbers(arguments.palm, {"--palm", "x,y,z (m)", 3});
    if (!palm.ok()) return palm.status();
    arguments.request.gripper.palm_size_m = {(*palm)[0], (*palm)[1], (*palm)[2]};
  }
  const absl::Status valid = Validate(arguments.request);
  if (!valid.ok()) return cli::UsageError(std::string(valid.message()));
  const auto plan = PlanGrasps(arguments);
  if (!plan.ok()) return plan.status();
  const std::string json = grasp::PlanJson(*plan, arguments.request);
  if (!arguments.json.empty()) {
    const absl::Status written = cwm::formats::WriteFileBytes(arguments.json, json);
    if (!written.ok()) return written;
  }
  if (arguments.json_on_stdout) {
    std::cout << json;
  } else {
    Print(*plan, arguments.json);
  }
  return absl::OkStatus();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "cwm-grasp: how a parallel gripper can take what stands in a world\n\nExamples:\n"
      "  cwm-grasp                                  the best grasps of every object\n"
      "  cwm-grasp object_3 --top 1 -o json         one grasp for a program\n"
      "  cwm-grasp --opening 0.11 --json grasps.json\n\n"
      "Lengths are metres. Exit codes are those of cwm; an object without a grasp is no error.",
      "cwm-grasp");
  Arguments arguments;
  std::string form = "table";
  cwm::manual::AddManualPage(
      app, {.version = CWM_VERSION,
            .environment = {{"CWM_ADDR", "where the server is, when --addr does not say it"}}});
  AddOptions(app, arguments, form);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(cli::ExitCode::kUsage);
  }
  arguments.json_on_stdout = form == "json";
  const absl::Status status = Run(arguments);
  if (status.ok()) return 0;
  cli::ReportError(
      status,
      {.name = "",
       .address = arguments.address.empty() ? cwm::DefaultAddress() : arguments.address,
       .program = "cwm-grasp"},
      std::cerr);
  return static_cast<int>(cli::ExitCodeOf(status));
}
