#include "tests/benchmarks/live/world_bytes.h"

#include <grpcpp/client_context.h>

#include <algorithm>
#include <chrono>

#include "cwm/v1/world.pb.h"

namespace cwm::benchmarks {
namespace {

constexpr auto kPatience = std::chrono::seconds(20);

// False if the events of all revisions up to this one are no longer kept.
bool ReadEvents(const client::Connection& connection, const std::string& world,
                std::int64_t revision, std::vector<std::string>& events) {
  grpc::ClientContext context;
  context.set_deadline(std::chrono::system_clock::now() + kPatience);
  v1::WatchWorldRequest request;
  request.set_world(world);
  request.set_from_revision(0);
  const auto watch = connection.worlds().WatchWorld(&context, request);
  bool is_complete = false;
  for (v1::WatchWorldResponse message; !is_complete && watch->Read(&message);) {
    for (v1::ObjectEvent& event : *message.mutable_events()->mutable_events()) {
      if (event.has_put()) event.mutable_put()->clear_uid();
      events.push_back(event.SerializeAsString());
    }
    is_complete = message.revision() >= revision && !message.events().more();
  }
  context.TryCancel();
  static_cast<void>(watch->Finish());  // it ends by being cancelled
  return is_complete;
}

template <class Message>
std::string DifferenceOf(const std::vector<std::string>& a, const std::vector<std::string>& b,
                         const std::string& what) {
  const auto [in_a, in_b] = std::ranges::mismatch(a, b);
  if (in_a == a.end() && in_b == b.end()) return {};
  const auto text = [](auto at, auto end) -> std::string {
    Message message;
    if (at == end) return "nothing";
    return message.ParseFromString(*at) ? message.ShortDebugString() : "other bytes";
  };
  return what + " " + std::to_string(in_a - a.begin()) + ": " + text(in_a, a.end()) + " for " +
         text(in_b, b.end());
}

}  // namespace

std::optional<WorldBytes> BytesOf(const client::Connection& connection, const std::string& world) {
  v1::ListObjectsRequest request;
  request.set_world(world);
  request.set_view(v1::OBJECT_VIEW_FULL);
  const auto list =
      connection.Call(&v1::WorldService::Stub::ListObjects, connection.worlds(), request);
  if (!list.ok() || !list->next_page_token().empty() || list->objects().empty()) {
    return std::nullopt;
  }
  WorldBytes bytes{.revision = std::to_string(list->revision()), .objects = {}, .events = {}};
  for (v1::Object object : list->objects()) {
    object.clear_uid();
    bytes.objects.push_back(object.SerializeAsString());
  }
  if (!ReadEvents(connection, world, list->revision(), bytes.events)) return std::nullopt;
  return bytes;
}

std::string FirstDifference(const WorldBytes& a, const WorldBytes& b) {
  if (const auto text = DifferenceOf<v1::ObjectEvent>(a.events, b.events, "event"); !text.empty()) {
    return text;
  }
  if (const auto text = DifferenceOf<v1::Object>(a.objects, b.objects, "object"); !text.empty()) {
    return text;
  }
  return "revision " + a.revision + " for " + b.revision;
}

}  // namespace cwm::benchmarks
