#include "server/rpc/object_pages.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "collision/geometry/aabb.h"
#include "proto/transfer/sha256.h"
#include "server/core/geometry_store.h"
#include "server/rpc/at_revision.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"
#include "server/wire/questions.h"

namespace cwm::server {
namespace {

constexpr int kDefaultPageSize = 1'000;
constexpr int kMaxPageSize = 10'000;
// The default receive limit of gRPC's clients is 4 MiB; one large object may still follow.
constexpr std::size_t kPageBytes = 2 << 20;

struct Filter {
  std::vector<collision::ObjectKind> kinds;  // empty: all
  std::string name_prefix;
  std::optional<Aabb> within_W;
};

struct Position {
  collision::Revision revision;
  std::string after;  // name of the last object sent
};

bool Passes(const collision::WorldObject& object, const Filter& filter) {
  if (!filter.kinds.empty() &&
      std::find(filter.kinds.begin(), filter.kinds.end(), object.kind) == filter.kinds.end()) {
    return false;
  }
  if (!object.name.starts_with(filter.name_prefix)) return false;
  return !filter.within_W || filter.within_W->intersects(object.bounds_W);
}

absl::StatusOr<Aabb> BoxOf(const v1::WorldBox& box, const FieldPath& path) {
  auto min = FromProto(box.min(), path.Field("min"));
  if (!min.ok()) return min.status();
  auto max = FromProto(box.max(), path.Field("max"));
  if (!max.ok()) return max.status();
  if ((min->array() > max->array()).any()) {
    return path.Field("min").Error("is greater than max, must not be in any coordinate");
  }
  return Aabb(*min, *max);
}

absl::StatusOr<Filter> FilterOf(const v1::ListObjectsRequest& request) {
  const FieldPath root;
  Filter filter;
  filter.name_prefix = request.name_prefix();
  bool any_kind = request.kinds().empty();
  for (int i = 0; i < request.kinds_size(); ++i) {
    if (request.kinds(i) == v1::OBJECT_KIND_UNSPECIFIED) any_kind = true;
    auto kind = FromProto(request.kinds(i), collision::ObjectKind::kObject, root.Item("kinds", i));
    if (!kind.ok()) return kind.status();
    filter.kinds.push_back(*kind);
  }
  if (any_kind) filter.kinds.clear();
  if (request.has_within()) {
    auto box = BoxOf(request.within(), root.Field("within"));
    if (!box.ok()) return box.status();
    filter.within_W = *box;
  }
  return filter;
}

// What a token is bound to.
std::string FilterDigest(v1::ListObjectsRequest request, const World& world) {
  constexpr std::size_t kDigestChars = 16;
  request.clear_page_token();
  request.clear_page_size();
  request.clear_at_revision();
  request.clear_world_uid();
  request.set_world(world.uid());
  return Sha256Hex(request.SerializeAsString()).substr(0, kDigestChars);
}

// Digest, revision and name, in letters that survive a command line.
std::string MakeToken(const std::string& digest, const Position& position) {
  return absl::WebSafeBase64Escape(
      absl::StrCat(digest, " ", position.revision.value, " ", position.after));
}

absl::StatusOr<Position> ReadToken(const std::string& token, const std::string& digest) {
  const absl::Status foreign =
      FieldPath().Field("page_token").Error("must be next_page_token of the same world and filter");
  std::string text;
  if (!absl::WebSafeBase64Unescape(token, &text)) return foreign;
  const std::size_t first = text.find(' ');
  const std::size_t second = first == std::string::npos ? first : text.find(' ', first + 1);
  if (second == std::string::npos || text.substr(0, first) != digest) return foreign;
  Position position;
  if (!absl::SimpleAtoi(text.substr(first + 1, second - first - 1), &position.revision.value)) {
    return foreign;
  }
  position.after = text.substr(second + 1);
  return position;
}

// What the page shows: the revision of the token, if there is one.
struct PageSource {
  WorldAtRevision at;
  std::string digest;  // of the filter
  std::string after;   // name of the last object that was sent
};
absl::StatusOr<PageSource> SourceOf(const Runtime& runtime, const v1::ListObjectsRequest& request,
                                    const CallContext& call) {
  auto rule = FromProto(request.at_revision(), FieldPath().Field("at_revision"));
  if (!rule.ok()) return rule.status();
  auto world = runtime.application.worlds.Find(request.world(), request.world_uid());
  if (!world.ok()) return world.status();
  PageSource source{.at = {}, .digest = FilterDigest(request, **world), .after = {}};
  if (!request.page_token().empty()) {
    auto position = ReadToken(request.page_token(), source.digest);
    if (!position.ok()) return position.status();
    *rule = Exactly{position->revision};
    source.after = std::move(position->after);
  }
  auto at = FindWorldAt(runtime, request.world(), request.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  source.at = *std::move(at);
  return source;
}

struct PageOptions {
  View view = View::kShapes;
  std::size_t size = kDefaultPageSize;
};
absl::StatusOr<PageOptions> PageOptionsOf(const v1::ListObjectsRequest& request) {
  const FieldPath root;
  auto view = FromProto(request.view(), View::kShapes, root.Field("view"));
  if (!view.ok()) return view.status();
  auto status = CheckRange(request.page_size(), {0, kMaxPageSize}, root.Field("page_size"));
  if (!status.ok()) return status;
  const int size = request.page_size() == 0 ? kDefaultPageSize : request.page_size();
  return PageOptions{*view, static_cast<std::size_t>(size)};
}

}  // namespace

absl::Status ListPage(Runtime& runtime, const v1::ListObjectsRequest& request,
                      const CallContext& call, v1::ListObjectsResponse* response) {
  auto options = PageOptionsOf(request);
  if (!options.ok()) return options.status();
  auto filter = FilterOf(request);
  if (!filter.ok()) return filter.status();
  auto source = SourceOf(runtime, request, call);
  if (!source.ok()) return source.status();
  const World& world = *source->at.world;
  const collision::WorldSnapshot& snapshot = *source->at.snapshot;
  response->set_world_uid(world.uid());
  response->set_revision(snapshot.revision().value);
  std::size_t bytes = 0;
  for (const collision::WorldObjectPtr& object : snapshot.objects()) {
    if (object->name <= source->after) continue;
    if (!Passes(*object, *filter)) continue;
    const auto count = static_cast<std::size_t>(response->objects_size());
    if (count == options->size || bytes >= kPageBytes) {
      const std::string& last = response->objects(response->objects_size() - 1).name();
      response->set_next_page_token(MakeToken(source->digest, {snapshot.revision(), last}));
      break;
    }
    v1::Object* proto = response->add_objects();
    *proto = ToProto(*object, options->view, world.observations().Of(object->name),
                     runtime.application.geometry);
    bytes += proto->ByteSizeLong();
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
