#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

// All contacts of the body with one object, `scratch` being a buffer of the caller's.
void AddContacts(BodySearch& search, const WorldObject& object, double margin_m, int max_count,
                 std::vector<PairDistance>& scratch, BestPairs& best) {
  const double reach_m = std::max(0.0, margin_m);
  search.ForEachPair(object, reach_m, Question::kDistance, [&](const BodySearch::Pair& pair) {
    scratch.clear();
    pair.engine.Contacts(pair.body, pair.object, margin_m, max_count, scratch);
    for (const PairDistance& contact : scratch) best.Add({.answer = contact, .id = pair.id});
    return reach_m;
  });
}

}  // namespace

absl::StatusOr<PairColumns> GetContacts(const WorldSnapshot& world, const QueryBody& body,
                                        std::span<const Pose> X_WB, const QueryOptions& options,
                                        std::stop_token stop) {
  BodySearch search(world, body, options, std::move(stop));
  const double own_margin_m = body.margin_m + options.margin_m;
  const double widest_margin_m = std::max(0.0, world.objects().widest_margin_m() + own_margin_m);

  BestPairs best(options.max_contacts);
  ObjectRanks ranks(world);
  std::vector<PairDistance> scratch;
  PairColumns columns;
  Reserve(columns, X_WB.size(), std::max(0, options.max_contacts));
  for (const Pose& X : X_WB) {
    if (search.MustEnd()) break;
    search.PlaceBody(X);
    best.Clear();
    const auto visit = [&](const WorldObject& object) {
      const double margin_m = object.margin_m + own_margin_m;
      if (!search.Skips(object)) {
        AddContacts(search, object, margin_m, options.max_contacts, scratch, best);
      }
      return !search.ended();
    };
    world.bounds().ForEachWithin(search.body_bounds_W(), widest_margin_m, visit);
    if (search.ended()) break;
    AppendRow(columns, best.pairs(), ranks);
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  return columns;
}

}  // namespace cwm::collision
