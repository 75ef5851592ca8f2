#include "server/rpc/object_pages.h"

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/aabb.h"
#include "server/core/geometry_store.h"
#include "server/rpc/pages.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/poses.h"

namespace cwm::server {
namespace {

struct Filter {
  std::vector<collision::ObjectKind> kinds;  // empty: all
  std::string name_prefix;
  std::optional<Aabb> within_W;
};

bool MatchesFilter(const collision::WorldObject& object, const Filter& filter) {
  if (!filter.kinds.empty() &&
      std::find(filter.kinds.begin(), filter.kinds.end(), object.kind) == filter.kinds.end()) {
    return false;
  }
  if (!object.name.starts_with(filter.name_prefix)) return false;
  return !filter.within_W || filter.within_W->intersects(object.bounds_W);
}

absl::StatusOr<Aabb> BoxOf(const v1::WorldBox& box, const FieldPath& path) {
  auto min = VectorFromProto(box.min(), path.Field("min"));
  if (!min.ok()) return min.status();
  auto max = VectorFromProto(box.max(), path.Field("max"));
  if (!max.ok()) return max.status();
  if ((min->array() > max->array()).any()) {
    return path.Field("min").Error("is greater than max, must not be in any coordinate");
  }
  return Aabb(*min, *max);
}

absl::StatusOr<Filter> FilterOf(const v1::ListObjectsRequest& request) {
  constexpr std::int64_t kMaxPrefixBytes = 128;  // no name is longer
  constexpr int kMaxKinds = 32;                  // a few more than there are
  const FieldPath root;
  const FieldPath prefix = root.Field("name_prefix");
  if (auto status = CheckTextLength(request.name_prefix(), kMaxPrefixBytes, prefix); !status.ok()) {
    return status;
  }
  if (request.kinds_size() > kMaxKinds) {
    return root.Field("kinds").Error(
        absl::StrCat("holds ", request.kinds_size(), " kinds, must hold at most ", kMaxKinds));
  }
  Filter filter;
  filter.name_prefix = request.name_prefix();
  bool any_kind = request.kinds().empty();
  for (int i = 0; i < request.kinds_size(); ++i) {
    if (request.kinds(i) == v1::OBJECT_KIND_UNSPECIFIED) any_kind = true;
    auto kind = ObjectKindFromProto(request.kinds(i), collision::ObjectKind::kObject,
                                    root.Item("kinds", i));
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

// The fields of the request, besides the world, that a page token is bound to.
std::string FilterText(v1::ListObjectsRequest request) {
  request.clear_page_token();
  request.clear_page_size();
  request.clear_at_revision();
  request.clear_world_uid();
  request.clear_world();
  return request.SerializeAsString();
}

}  // namespace

absl::Status ListPage(Runtime& runtime, const v1::ListObjectsRequest& request,
                      const CallContext& call, v1::ListObjectsResponse* response) {
  auto view = ViewFromProto(request.view(), View::kShapes, FieldPath::OfRequest("view"));
  if (!view.ok()) return view.status();
  auto size = PageSizeOf(request.page_size());
  if (!size.ok()) return size.status();
  auto filter = FilterOf(request);
  if (!filter.ok()) return filter.status();
  auto source = FindPage(runtime,
                         {.world = request.world(),
                          .world_uid = request.world_uid(),
                          .at_revision = request.at_revision(),
                          .page_token = request.page_token(),
                          .filter = FilterText(request)},
                         call);
  if (!source.ok()) return source.status();
  const World& world = *source->at.world;
  const collision::WorldSnapshot& snapshot = *source->at.snapshot;
  response->set_world_uid(world.uid());
  response->set_revision(snapshot.revision().value);
  std::size_t bytes = 0;
  for (const collision::WorldObjectPtr& object : snapshot.objects()) {
    if (object->name <= source->after) continue;
    if (!MatchesFilter(*object, *filter)) continue;
    const auto count = static_cast<std::size_t>(response->objects_size());
    if (count == *size || bytes >= kPageBytes) {
      const std::string& last = response->objects(response->objects_size() - 1).name();
      response->set_next_page_token(NextToken(*source, last));
      break;
    }
    v1::Object* proto = response->add_objects();
    *proto = ObjectToProto(*object, *view, world.observations().Get(object->name),
                           runtime.application.geometry);
    bytes += proto->ByteSizeLong();
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
