// cwm export
#include <map>
#include <memory>
#include <ostream>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/one_of.h"
#include "clients/cli/quantity.h"
#include "clients/cli/question_arguments.h"
#include "clients/cpp/world_export.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct ExportArguments {
  std::string file, robot, at_revision;
  pb::ExportFormat format = pb::EXPORT_FORMAT_UNSPECIFIED;
};

// What --format says, else how the name ends.
absl::StatusOr<pb::ExportFormat> FormatOf(const ExportArguments& arguments) {
  if (arguments.format != pb::EXPORT_FORMAT_UNSPECIFIED) return arguments.format;
  const std::string name = absl::AsciiStrToLower(arguments.file);
  if (absl::EndsWith(name, ".scene")) return pb::EXPORT_FORMAT_MOVEIT_SCENE;
  if (absl::EndsWith(name, ".yaml") || absl::EndsWith(name, ".yml")) {
    return pb::EXPORT_FORMAT_MOVEIT_YAML;
  }
  return UsageError(absl::StrCat("OUT: \"", arguments.file,
                                 "\" must end in .scene or .yaml, or --format say it"));
}

absl::Status Export(Session& session, const ExportArguments& arguments) {
  const auto format = FormatOf(arguments);
  if (!format.ok()) return format.status();
  const auto revision = ParseRevision(arguments.at_revision);
  if (!revision.ok()) return revision.status();
  pb::ExportWorldRequest request;
  request.set_world(session.world);
  *request.mutable_at_revision() = *revision;
  request.set_format(*format);
  request.set_robot(arguments.robot);
  const auto exported = client::ExportWorld(session.connection(), request);
  if (!exported.ok()) return exported.status();
  for (const std::string& warning : exported->warnings) session.Warn(warning);
  if (arguments.file == "-") {
    session.streams.out << exported->bytes;
    return absl::OkStatus();
  }
  const absl::Status written = formats::WriteFileBytes(arguments.file, exported->bytes);
  if (!written.ok()) return written;
  // The reply as one message, without the file's bytes.
  pb::ExportWorldResponse response;
  response.set_world_uid(exported->world_uid);
  response.set_revision(exported->revision);
  response.set_total_bytes(static_cast<std::int64_t>(exported->bytes.size()));
  response.set_done(true);
  for (const std::string& warning : exported->warnings) response.add_warnings(warning);
  session.Print(response, [&] {
    session.streams.out << "exported " << Bytes(static_cast<double>(exported->bytes.size()))
                        << " to " << arguments.file << ", revision " << exported->revision << "\n";
  });
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CommandLine& line) {
  static const std::map<std::string, pb::ExportFormat> kFormats = {
      {"scene", pb::EXPORT_FORMAT_MOVEIT_SCENE}, {"yaml", pb::EXPORT_FORMAT_MOVEIT_YAML}};
  const auto arguments = std::make_shared<ExportArguments>();
  CLI::App& command = AddCommand(
      line,
      {"export",
       "the world as a MoveIt planning scene (YAML or .scene)",
       {"cwm export shelf.scene", "cwm export scene.yaml --robot panda --at-revision 7",
        "cwm export - --format yaml | less"},
       "YAML also has the state of the robot, what it holds and which pairs may collide; .scene\n"
       "has objects alone and leaves out what robots hold. Shapes that MoveIt does not know\n"
       "become meshes, which warnings say. `cwm import` reads both."},
      [arguments](Session& session) { return Export(session, *arguments); });
  command.add_option("OUT", arguments->file, "the file; \"-\": stdout")->required();
  command.add_option("--format", arguments->format, "scene or yaml; default: how the name ends")
      ->transform(OneOf(kFormats))
      ->type_name("FORMAT");
  command
      .add_option("--robot", arguments->robot,
                  "whose state it is; default: the only robot of the world")
      ->type_name("NAME");
  AddRevisionOption(command, arguments->at_revision);
}

}  // namespace cwm::cli
