#include <utility>

#include "cwm/internal/session.h"
#include "cwm/world.h"

namespace cwm::CWM_API {

using client::Connection;
using internal::View;

Server::Server(const ConnectOptions& options) {
  auto view = std::make_shared<View>();
  view->session = std::make_shared<internal::Session>(Connection({.address = options.address}));
  view->timeout_s = options.timeout_s;
  view->connection = std::make_shared<Connection>(
      view->session->connection.WithDeadline(internal::DeadlineOf(options.timeout_s)));
  // Not repeated: it fails at once where there is no server.
  const auto info = view->connection->Call(&v1::AdminService::Stub::GetServerInfo,
                                           view->connection->admin(), v1::GetServerInfoRequest());
  if (!info.ok()) internal::Throw(info.status(), *view->connection);
  view->session->limits = info->limits();
  view_ = std::move(view);
}

const std::string& Server::address() const { return view_->connection->address(); }

ServerInfo Server::Info() const {
  const v1::GetServerInfoResponse reply =
      internal::Call(*view_, &v1::AdminService::Stub::GetServerInfo, &Connection::admin,
                     v1::GetServerInfoRequest());
  ServerInfo info{.version = reply.version(),
                  .uptime_s = reply.uptime_s(),
                  .store = reply.store(),
                  .engines = {},
                  .max_message_bytes = reply.limits().max_message_bytes(),
                  .max_batch_rows = reply.limits().max_batch_rows(),
                  .max_answers = reply.limits().max_answers()};
  for (const v1::EngineInfo& engine : reply.engines()) {
    info.engines[engine.name()] = engine.version();
  }
  return info;
}

std::vector<WorldInfo> Server::Worlds() const {
  const v1::ListWorldsResponse reply = internal::Call(*view_, &v1::WorldService::Stub::ListWorlds,
                                                      &Connection::worlds, v1::ListWorldsRequest());
  std::vector<WorldInfo> worlds;
  for (const v1::World& world : reply.worlds()) {
    worlds.push_back({.name = world.name(),
                      .uid = world.world_uid(),
                      .revision = world.revision(),
                      .object_count = world.object_count(),
                      .robot_count = world.robot_count(),
                      .oldest_exact_revision = world.oldest_exact_revision(),
                      .oldest_watch_revision = world.oldest_watch_revision()});
  }
  return worlds;
}

World Server::GetWorld(const std::string& name) const {
  auto view = std::make_shared<View>(*view_);
  view->world = name;
  return World(std::move(view));
}

void Server::DeleteWorld(const std::string& name) const {
  v1::DeleteWorldRequest request;
  request.set_world(name);
  request.set_request_id(internal::NewRequestId());
  internal::Call(*view_, &v1::WorldService::Stub::DeleteWorld, &Connection::worlds, request);
}

Server WorldView::server() const {
  auto view = std::make_shared<View>();
  view->session = view_->session;
  view->connection = view_->connection;
  view->timeout_s = view_->timeout_s;
  return Server(std::move(view));
}

World Connect(const ConnectOptions& options) { return Server(options).GetWorld(options.world); }

}  // namespace cwm::CWM_API
