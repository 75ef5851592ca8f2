// cwm export
#include <filesystem>
#include <map>
#include <memory>
#include <ostream>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/cli/commands.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/one_of.h"
#include "clients/cli/progress.h"
#include "clients/cli/quantity.h"
#include "clients/cli/query_arguments.h"
#include "clients/cpp/world_export.h"
#include "clients/formats/file_bytes.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct ExportArguments {
  std::string file, robot, at_revision;
  pb::ExportFormat format = pb::EXPORT_FORMAT_UNSPECIFIED;
};

const std::map<std::string, pb::ExportFormat>& Formats() {
  static const std::map<std::string, pb::ExportFormat> formats = {
      {"glb", pb::EXPORT_FORMAT_GLB},
      {"ply", pb::EXPORT_FORMAT_PLY},
      {"scene", pb::EXPORT_FORMAT_MOVEIT_SCENE},
      {"sdf", pb::EXPORT_FORMAT_SDF},
      {"urdf", pb::EXPORT_FORMAT_URDF},
      {"yaml", pb::EXPORT_FORMAT_MOVEIT_YAML}};
  return formats;
}

// The format of --format, or else by the file name's ending.
absl::StatusOr<pb::ExportFormat> FormatOf(const ExportArguments& arguments) {
  if (arguments.format != pb::EXPORT_FORMAT_UNSPECIFIED) return arguments.format;
  std::string ending =
      absl::AsciiStrToLower(std::filesystem::path(arguments.file).extension().string());
  if (ending == ".yml") ending = ".yaml";
  const auto found = ending.empty() ? Formats().end() : Formats().find(ending.substr(1));
  if (found != Formats().end()) return found->second;
  return UsageError(absl::StrCat("OUT: \"", arguments.file,
                                 "\" must end in .glb, .ply, .scene, .sdf, .urdf or .yaml, or "
                                 "--format say it"));
}

// Writes the files that the first one refers to, relative to its folder.
absl::Status WriteFilesBeside(const std::string& first,
                              const std::vector<client::ExportedFile>& files) {
  const std::filesystem::path folder = std::filesystem::path(first).parent_path();
  for (const client::ExportedFile& file : files) {
    const std::filesystem::path path = folder / file.name;
    std::error_code failed;
    std::filesystem::create_directories(path.parent_path(), failed);
    if (failed) {
      return absl::InvalidArgumentError(
          absl::StrCat(path.parent_path().string(), ": cannot be made: ", failed.message()));
    }
    const absl::Status written = formats::WriteFileBytes(path.string(), file.bytes);
    if (!written.ok()) return written;
  }
  return absl::OkStatus();
}

absl::StatusOr<client::ExportedWorld> Fetch(Session& session,
                                            const pb::ExportWorldRequest& request) {
  Progress progress(session);
  progress.ShowStage("the server makes the file");
  return client::ExportWorld(
      session.connection(), request, [&](std::int64_t received, std::int64_t total) {
        progress.Update({.action = "receiving", .moved_bytes = received, .total_bytes = total});
      });
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
  const auto exported = Fetch(session, request);
  if (!exported.ok()) return exported.status();
  for (const std::string& warning : exported->warnings) session.Warn(warning);
  if (arguments.file == "-") {
    if (!exported->files.empty()) {
      return UsageError(absl::StrCat("OUT: \"-\" has no room for the ", exported->files.size(),
                                     " meshes that lie beside the file, must be a file"));
    }
    session.streams.out << exported->bytes;
    return absl::OkStatus();
  }
  absl::Status written = WriteFilesBeside(arguments.file, exported->files);
  if (written.ok()) written = formats::WriteFileBytes(arguments.file, exported->bytes);
  if (!written.ok()) return written;
  // The reply as a single message, without the file's bytes.
  pb::ExportWorldResponse response;
  response.set_world_uid(exported->world_uid);
  response.set_revision(exported->revision);
  response.set_total_bytes(static_cast<std::int64_t>(exported->bytes.size()));
  for (const client::ExportedFile& file : exported->files) {
    pb::ExportedFile& listed = *response.add_files();
    listed.set_name(file.name);
    listed.set_byte_count(static_cast<std::int64_t>(file.bytes.size()));
  }
  response.set_done(true);
  for (const std::string& warning : exported->warnings) response.add_warnings(warning);
  session.Print(response, [&] {
    session.streams.out << "exported " << FormatBytes(static_cast<double>(exported->bytes.size()))
                        << " to " << arguments.file;
    if (!exported->files.empty()) {
      const std::size_t count = exported->files.size();
      session.streams.out << " and " << count << (count == 1 ? " mesh" : " meshes") << " beside it";
    }
    session.streams.out << ", revision " << exported->revision << "\n";
  });
  return absl::OkStatus();
}

}  // namespace

void AddExportCommand(CommandLine& line) {
  const auto arguments = std::make_shared<ExportArguments>();
  CLI::App& command = AddCommand(
      line,
      {"export",
       "the world as a file of another tool: GLB, PLY, MoveIt's scenes, URDF, SDF",
       {"cwm export kitchen.glb", "cwm export shelf.scene", "cwm export scene.yaml --robot panda",
        "cwm export kitchen.urdf", "cwm export - --format yaml | less"},
       "GLB and PLY: objects and robots as collision checking sees them, in colours; GLB has a "
       "node "
       "for each.\n"
       "YAML, a MoveIt planning scene, also has the state of the robot, what it holds and which "
       "pairs\nmay collide; .scene has objects alone and leaves out what robots hold. `cwm import` "
       "reads both.\n"
       "URDF has a link for each object, SDF a static model; their meshes are STL files in a "
       "folder beside.\n"
       "What a format cannot say, warnings do."},
      [arguments](Session& session) { return Export(session, *arguments); });
  command.add_option("OUT", arguments->file, "the file; \"-\": stdout")->required();
  command.add_option("--format", arguments->format, "of the file; default: how the name ends")
      ->transform(OneOf(Formats()))
      ->type_name("glb|ply|scene|sdf|urdf|yaml");
  command
      .add_option("--robot", arguments->robot,
                  "whose state it is; default: the only robot of the world")
      ->type_name("NAME");
  AddRevisionOption(command, arguments->at_revision);
}

}  // namespace cwm::cli
