// cwm objects, cwm get
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "clients/cli/all_pages.h"
#include "clients/cli/commands.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/mesh_frames.h"
#include "clients/cli/number_list.h"
#include "clients/cli/object_table.h"
#include "clients/cli/one_of.h"
#include "clients/cli/progress.h"
#include "clients/cli/query_arguments.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/glb.h"
#include "clients/formats/ply.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

struct ListArguments {
  std::vector<pb::ObjectKind> kinds;
  std::string prefix, within, at_revision;
};

struct GetArguments {
  std::string name, at_revision, mesh;
};

absl::StatusOr<pb::ListObjectsRequest> ToRequest(const ListArguments& arguments,
                                                 const Session& session) {
  pb::ListObjectsRequest request;
  request.set_world(session.world);
  request.set_view(pb::OBJECT_VIEW_FULL);
  request.set_name_prefix(arguments.prefix);
  for (const pb::ObjectKind kind : arguments.kinds) request.add_kinds(kind);
  const auto revision = ParseRevision(arguments.at_revision);
  if (!revision.ok()) return revision.status();
  *request.mutable_at_revision() = *revision;
  if (arguments.within.empty()) return request;
  const auto box =
      ParseNumbers(arguments.within, {"--within", "xmin,ymin,zmin,xmax,ymax,zmax (m)", 6});
  if (!box.ok()) return box.status();
  pb::Vector3& min = *request.mutable_within()->mutable_min();
  pb::Vector3& max = *request.mutable_within()->mutable_max();
  min.set_x((*box)[0]);
  min.set_y((*box)[1]);
  min.set_z((*box)[2]);
  max.set_x((*box)[3]);
  max.set_y((*box)[4]);
  max.set_z((*box)[5]);
  return request;
}

absl::Status List(Session& session, const ListArguments& arguments) {
  const auto request = ToRequest(arguments, session);
  if (!request.ok()) return request.status();
  const auto response = ListAllPages<pb::ListObjectsResponse>(
      session, &pb::WorldService::Stub::ListObjects, session.connection().worlds(), *request);
  if (!response.ok()) return response.status();
  session.PrintList(
      *response,
      [&] {
        for (const pb::Object& object : response->objects()) session.PrintLine(object);
      },
      [&] {
        PrintObjects(response->objects(), session.table_style(), session.streams.out);
        session.streams.out << "revision " << response->revision() << "\n";
      });
  return absl::OkStatus();
}

// Writes a mesh in the format that the file name's ending selects.
using MeshFormat = std::string (*)(const formats::MeshFile&);

absl::StatusOr<MeshFormat> FormatFor(const std::string& file) {
  const std::string name = absl::AsciiStrToLower(file);
  if (absl::EndsWith(name, ".ply")) return &formats::FormatPlyMesh;
  if (absl::EndsWith(name, ".glb")) return &formats::FormatGlbMesh;
  return UsageError(absl::StrCat("--mesh: \"", file, "\" must end in .ply or .glb"));
}

absl::StatusOr<client::Surface> Fetch(Session& session, const pb::ObjectSurface& object) {
  Progress progress(session);
  progress.ShowStage("the server makes the mesh");
  return client::ReadSurface(
      session.connection(), object, [&](std::int64_t received, std::int64_t total) {
        progress.Update({.action = "receiving", .moved_bytes = received, .total_bytes = total});
      });
}

// Writes the object's surface at the revision of `shown`, in the world's frame.
absl::Status WriteMesh(Session& session, const pb::GetObjectResponse& shown,
                       const std::string& file, MeshFormat format) {
  pb::ObjectSurface object;
  object.set_world(session.world);
  object.set_world_uid(shown.world_uid());
  object.set_name(shown.object().name());
  object.mutable_at_revision()->set_exact(shown.revision());
  auto surface = Fetch(session, object);
  if (!surface.ok()) return surface.status();
  const formats::MeshFile mesh_W =
      TransformMesh(surface->header.x_world_object(), std::move(surface->mesh));
  return formats::WriteFileBytes(file, format(mesh_W));
}

absl::Status Get(Session& session, const GetArguments& arguments) {
  MeshFormat format = nullptr;
  if (!arguments.mesh.empty()) {
    const auto known = FormatFor(arguments.mesh);
    if (!known.ok()) return known.status();
    format = *known;
  }
  const client::Connection& connection = session.connection();
  pb::GetObjectRequest request;
  request.set_world(session.world);
  request.set_name(arguments.name);
  const auto revision = ParseRevision(arguments.at_revision);
  if (!revision.ok()) return revision.status();
  *request.mutable_at_revision() = *revision;
  const auto response =
      connection.Call(&pb::WorldService::Stub::GetObject, connection.worlds(), request);
  if (!response.ok()) return response.status();
  if (format != nullptr) {
    const absl::Status written = WriteMesh(session, *response, arguments.mesh, format);
    if (!written.ok()) return written;
  }
  session.Print(*response, [&] {
    PrintObjectDetails(response->object(), session.table_style(), session.streams.out);
    session.streams.out << "revision " << response->revision() << "\n";
  });
  return absl::OkStatus();
}

}  // namespace

void AddObjectCommands(CommandLine& line) {
  const auto list = std::make_shared<ListArguments>();
  CLI::App& objects = AddCommand(
      line,
      {"objects",
       "the objects of the world: shapes, coefficients, how well they fit",
       {"cwm objects", "cwm objects --kind support", "cwm objects -o ndjson | jq -r .name"}},
      [list](Session& session) { return List(session, *list); });
  objects
      .add_option("--kind", list->kinds,
                  "support, object, residual, unseen, user or mover; repeatable")
      ->transform(OneOf(ShortNames<pb::ObjectKind>()))
      ->allow_extra_args(false)
      ->type_name("KIND");
  objects.add_option("--prefix", list->prefix, "names that start so")->type_name("TEXT");
  objects.add_option("--within", list->within, "objects that touch this region (m)")
      ->type_name("XMIN,YMIN,ZMIN,XMAX,YMAX,ZMAX");
  AddRevisionOption(objects, list->at_revision);

  const auto get = std::make_shared<GetArguments>();
  CLI::App& command = AddCommand(
      line,
      {"get",
       "everything about one object",
       {"cwm get mug", "cwm get mug -o json", "cwm get mug --mesh mug.ply"},
       "--mesh writes all that the object is made of as one mesh in the world's frame: "
       "its shapes to\n"
       "within half a millimetre (more beyond a radius of 3 m), its surfaces and handles. "
       "PLY keeps double\n"
       "precision; GLB has single precision and is turned so that up is up in viewers."},
      [get](Session& session) { return Get(session, *get); });
  command.add_option("NAME", get->name, "of the object")->required();
  command.add_option("--mesh", get->mesh, "write it as a mesh to this PLY or GLB file")
      ->type_name("OUT.ply|OUT.glb");
  AddRevisionOption(command, get->at_revision);
}

}  // namespace cwm::cli
