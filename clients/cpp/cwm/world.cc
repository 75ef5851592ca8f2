#include "cwm/world.h"

#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/robot_upload.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/robot_files.h"
#include "cwm/internal/query_batches.h"
#include "cwm/internal/session.h"
#include "cwm/internal/world_messages.h"

namespace cwm::CWM_API {
namespace {

using client::Connection;

// chosen: far above what a URDF, an SRDF or a mesh has; the server has limits of its own.
constexpr std::int64_t kMaxFileBytes = 1 << 30;

std::string ReadFile(const std::string& path) {
  auto bytes = formats::ReadFileBytes(path, kMaxFileBytes);
  if (!bytes.ok()) throw client::ErrorFromStatus(bytes.status());
  return *std::move(bytes);
}

bool IsText(const std::string& source) {
  const std::size_t first = source.find_first_not_of(" \t\r\n");
  return first != std::string::npos && source[first] == '<';
}

std::string TextOf(const std::string& source) { return IsText(source) ? source : ReadFile(source); }

std::vector<client::RobotFile> MeshesOf(const std::string& urdf, const RobotFiles& files) {
  const formats::RobotFolders folders{
      .urdf_folder = IsText(files.urdf)
                         ? std::filesystem::current_path().string()
                         : std::filesystem::absolute(files.urdf).parent_path().string(),
      .package_folders = files.package_folders};
  std::vector<client::RobotFile> meshes;
  for (const std::string& uri : formats::CollisionMeshUris(urdf)) {
    const auto path = formats::FindMeshFile(uri, folders);
    if (!path.ok()) throw client::ErrorFromStatus(path.status());
    meshes.push_back({uri, ReadFile(*path)});
  }
  return meshes;
}

}  // namespace

std::int64_t World::Apply(std::span<const Change> changes,
                          std::optional<std::int64_t> expected_revision) const {
  v1::ApplyChangesRequest request;
  request.set_world(view().world);
  request.set_request_id(internal::NewRequestId());
  if (expected_revision) request.set_expected_revision(*expected_revision);
  std::vector<internal::MeshBlob> meshes;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    *request.add_changes() =
        internal::ToMessage(changes[i], absl::StrCat("changes[", i, "]"), meshes);
  }
  return internal::WithMeshes(view(), meshes,
                              [&] {
                                return internal::Repeat(view(), [&](const Connection& connection) {
                                  return connection.Call(&v1::WorldService::Stub::ApplyChanges,
                                                         connection.worlds(), request);
                                });
                              })
      .revision();
}

std::int64_t World::Put(const std::string& name, const Body& body,
                        const Eigen::Isometry3d& X_WO) const {
  return Apply({api::Put{.name = name, .body = body, .X_WO = X_WO}});
}

std::int64_t World::Move(const std::string& name, const Eigen::Isometry3d& X_WO) const {
  return Apply({api::Move{.name = name, .X_WO = X_WO}});
}

std::int64_t World::Remove(const std::string& name) const {
  return Apply({api::Remove{.name = name}});
}

std::int64_t World::Attach(const std::string& name, const std::string& robot,
                           const std::string& link, const std::vector<std::string>& touch_links,
                           const std::optional<Eigen::Isometry3d>& X_LO) const {
  return Apply({api::Attach{
      .name = name, .robot = robot, .link = link, .X_LO = X_LO, .touch_links = touch_links}});
}

std::int64_t World::Detach(const std::string& name) const {
  return Apply({api::Detach{.name = name}});
}

std::int64_t World::Allow(const NamedThing& a, const NamedThing& b,
                          std::optional<double> expires_after_s) const {
  return Apply({api::Allow{.a = a, .b = b, .expires_after_s = expires_after_s}});
}

std::int64_t World::Disallow(const NamedThing& a, const NamedThing& b) const {
  return Apply({api::Allow{.a = a, .b = b, .withdraw = true}});
}

std::int64_t World::SetMargin(const NamedThing& a, const NamedThing& b,
                              std::optional<double> margin_m) const {
  return Apply({Margin{.a = a, .b = b, .margin_m = margin_m}});
}

std::int64_t World::SetRobotState(const std::string& robot, const JointState& joints,
                                  const std::optional<Eigen::Isometry3d>& X_WB) const {
  return Apply({SetState{.robot = robot, .joints = joints, .X_WB = X_WB}});
}

LoadedRobot World::LoadRobot(const RobotFiles& files, const LoadOptions& options) const {
  v1::LoadRobotHeader header;
  header.set_world(view().world);
  header.set_name(options.name);
  header.set_request_id(internal::NewRequestId());
  header.set_urdf(TextOf(files.urdf));
  if (!files.srdf.empty()) header.set_srdf(TextOf(files.srdf));
  if (!files.spheres.empty()) header.set_spheres(TextOf(files.spheres));
  if (options.X_WB) {
    *header.mutable_x_world_base() = internal::ToMessage(*options.X_WB, "options.X_WB");
  }
  *header.mutable_initial_state() = internal::ToMessage(options.initial_state);
  for (const LinkPadding& padding : options.link_padding) {
    *header.add_link_padding() = internal::ToMessage(padding);
  }
  for (const LinkScale& scale : options.link_scale) {
    v1::LinkScale& added = *header.add_link_scale();
    added.set_link(scale.link);
    added.set_scale(scale.scale);
  }
  for (std::size_t i = 0; i < options.tools.size(); ++i) {
    *header.add_tools() =
        internal::ToMessage(options.tools[i], absl::StrCat("options.tools[", i, "]"));
  }
  const std::vector<client::RobotFile> meshes = MeshesOf(header.urdf(), files);
  const v1::LoadRobotResponse reply = internal::RepeatOrThrow(
      view(),
      [&](const Connection& connection) { return client::LoadRobot(connection, header, meshes); });
  LoadedRobot loaded{.robot = internal::FromMessage(reply.robot()),
                     .warnings = {reply.warnings().begin(), reply.warnings().end()}};
  // A repeated call is answered without the robot if that revision is no longer kept.
  if (!reply.has_robot() && !options.name.empty()) loaded.robot = GetRobot(options.name);
  return loaded;
}

std::int64_t World::DeleteRobot(const std::string& name) const {
  v1::DeleteRobotRequest request;
  request.set_world(view().world);
  request.set_name(name);
  request.set_request_id(internal::NewRequestId());
  return internal::Call(view(), &v1::RobotService::Stub::DeleteRobot, &Connection::robots, request)
      .revision();
}

}  // namespace cwm::CWM_API
