#include <filesystem>
#include <fstream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/geometry_transfer.h"
#include "clients/cpp/world_export.h"
#include "cwm/internal/query_batches.h"
#include "cwm/internal/session.h"
#include "cwm/internal/world_messages.h"
#include "cwm/world.h"

namespace cwm::CWM_API {
namespace {

using client::Connection;
using internal::View;

v1::GetWorldResponse State(const View& view) {
  v1::GetWorldRequest request;
  request.set_world(view.world);
  return internal::Call(view, &v1::WorldService::Stub::GetWorld, &Connection::worlds, request);
}

void WriteFile(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream file(path, std::ios::binary);
  file << bytes;
  if (!file.flush()) throw Error(ErrorCode::kUnknown, path.string() + " cannot be written");
}

}  // namespace

WorldView internal::MakeView(std::shared_ptr<const View> view) {
  return WorldView(std::move(view));
}

const std::string& WorldView::name() const { return view().world; }

std::int64_t WorldView::revision() const {
  return view().pinned ? *view().pinned : State(view()).revision();
}

std::string WorldView::uid() const {
  return view().uid.empty() ? State(view()).world_uid() : view().uid;
}

WorldView WorldView::At(std::optional<std::int64_t> revision) const {
  const v1::GetWorldResponse state = State(view());
  auto pinned = std::make_shared<View>(view());
  pinned->pinned = revision.value_or(state.revision());
  pinned->uid = state.world_uid();
  return WorldView(std::move(pinned));
}

WorldView WorldView::Within(std::optional<double> timeout_s) const {
  if (timeout_s && !(*timeout_s > 0)) {
    internal::ThrowBadArgument("timeout_s", absl::StrCat("is ", *timeout_s, ", must be above 0"));
  }
  auto within = std::make_shared<View>(view());
  within->timeout_s = timeout_s;
  within->connection = std::make_shared<Connection>(
      view().session->connection.WithDeadline(internal::DeadlineOf(timeout_s)));
  return WorldView(std::move(within));
}

WorldView WorldView::WhatIf(std::vector<Change> changes) const {
  auto supposing = std::make_shared<View>(view());
  for (Change& change : changes) supposing->supposed.push_back(std::move(change));
  return WorldView(std::move(supposing));
}

WorldView WorldView::Stream() const {
  auto streamed = std::make_shared<View>(view());
  streamed->stream = std::make_shared<client::QueryStream>(view().session->connection);
  if (streamed->supposed.empty()) return WorldView(std::move(streamed));
  v1::StreamQueriesRequest request;
  request.mutable_overlay()->set_world(view().world);
  std::vector<internal::MeshBlob> meshes;
  for (std::size_t i = 0; i < streamed->supposed.size(); ++i) {
    *request.mutable_overlay()->add_changes() =
        internal::ToMessage(streamed->supposed[i], absl::StrCat("WhatIf.changes[", i, "]"), meshes);
  }
  internal::WithMeshes(view(), meshes, [&] { return streamed->stream->Evaluate(request); });
  streamed->supposed.clear();
  return WorldView(std::move(streamed));
}

std::vector<Object> WorldView::Objects(const ObjectFilter& filter) const {
  v1::ListObjectsRequest request;
  request.set_world(view().world);
  internal::SetRevision(view(), request);
  for (const ObjectKind kind : filter.kinds) {
    request.add_kinds(static_cast<v1::ObjectKind>(kind));
  }
  request.set_name_prefix(filter.prefix);
  request.set_view(static_cast<v1::ObjectView>(filter.view));
  if (filter.within) {
    internal::SetVector(filter.within->min(), *request.mutable_within()->mutable_min());
    internal::SetVector(filter.within->max(), *request.mutable_within()->mutable_max());
  }
  std::vector<Object> objects;
  do {
    const v1::ListObjectsResponse page =
        internal::Call(view(), &v1::WorldService::Stub::ListObjects, &Connection::worlds, request);
    for (const v1::Object& object : page.objects()) {
      objects.push_back(internal::FromMessage(object));
    }
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return objects;
}

Object WorldView::Get(const std::string& name) const {
  v1::GetObjectRequest request;
  request.set_world(view().world);
  request.set_name(name);
  internal::SetRevision(view(), request);
  return internal::FromMessage(
      internal::Call(view(), &v1::WorldService::Stub::GetObject, &Connection::worlds, request)
          .object());
}

Mesh WorldView::ReadSurface(const std::string& name) const {
  v1::ObjectSurface surface;
  surface.set_world(view().world);
  surface.set_name(name);
  internal::SetRevision(view(), surface);
  const auto read = internal::RepeatOrThrow(view(), [&](const Connection& connection) {
    return client::ReadSurface(connection, surface);
  });
  return internal::MeshFrom(read.mesh);
}

Mesh WorldView::ReadMesh(const std::string& hash) const {
  const auto blob = internal::RepeatOrThrow(
      view(), [&](const Connection& connection) { return client::ReadGeometry(connection, hash); });
  const auto decoded = client::DecodeMesh(blob.bytes);
  if (!decoded.ok()) throw client::ErrorFromStatus(decoded.status());
  Mesh mesh = internal::MeshFrom(*decoded);
  mesh.hash = hash;
  return mesh;
}

Mesh WorldView::WriteMesh(const Mesh& mesh) const {
  internal::MeshBlob blob = internal::EncodeMesh(mesh);
  internal::SendMeshes(view(), {blob}, /*again=*/true);
  return {.vertices = {}, .triangles = {}, .hash = std::move(blob.hash)};
}

std::vector<Robot> WorldView::Robots() const {
  v1::ListRobotsRequest request;
  request.set_world(view().world);
  internal::SetRevision(view(), request);
  std::vector<Robot> robots;
  do {
    const v1::ListRobotsResponse page =
        internal::Call(view(), &v1::RobotService::Stub::ListRobots, &Connection::robots, request);
    for (const v1::Robot& robot : page.robots()) robots.push_back(internal::FromMessage(robot));
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
  return robots;
}

Robot WorldView::GetRobot(const std::string& name) const {
  if (name.empty()) internal::ThrowBadArgument("name", "is empty, must be that of a robot");
  v1::ListRobotsRequest request;
  request.set_world(view().world);
  request.set_name(name);
  internal::SetRevision(view(), request);
  return internal::FromMessage(
      internal::Call(view(), &v1::RobotService::Stub::ListRobots, &Connection::robots, request)
          .robots(0));
}

std::vector<PairRule> WorldView::Rules() const {
  const v1::GetWorldResponse state = State(view());
  std::vector<PairRule> rules;
  for (const v1::PairRule& rule : state.pair_rules()) {
    rules.push_back(internal::FromMessage(rule));
  }
  return rules;
}

ExportResult WorldView::Export(ExportFormat format, const std::string& robot) const {
  v1::ExportWorldRequest request;
  request.set_world(view().world);
  request.set_format(static_cast<v1::ExportFormat>(format));
  request.set_robot(robot);
  internal::SetRevision(view(), request);
  auto exported = internal::RepeatOrThrow(view(), [&](const Connection& connection) {
    return client::ExportWorld(connection, request);
  });
  ExportResult result{.world_uid = std::move(exported.world_uid),
                      .revision = exported.revision,
                      .bytes = std::move(exported.bytes),
                      .files = {},
                      .warnings = std::move(exported.warnings)};
  for (client::ExportedFile& file : exported.files) {
    result.files.push_back({std::move(file.name), std::move(file.bytes)});
  }
  return result;
}

void ExportResult::Save(const std::string& path) const {
  const std::filesystem::path first(path);
  for (const ExportedFile& file : files) {
    const std::filesystem::path beside = first.parent_path() / file.name;
    std::filesystem::create_directories(beside.parent_path());
    WriteFile(beside, file.bytes);
  }
  WriteFile(first, bytes);
}

}  // namespace cwm::CWM_API
