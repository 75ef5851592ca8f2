#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

// Gathers the contacts of a row, with a buffer for those of a pair.
class ContactFinder {
 public:
  ContactFinder(BodySearch& search, int max_count) : search_(search), best_(max_count) {}

  void FindAll(const QueryOptions& options, double own_margin_m) {
    best_.Clear();
    search_.ForEachSelfPair(Reach_m(options.margin_m), Question::kDistance,
                            [&](const BodySearch::Pair& pair) {
                              return Add(pair, options.margin_m, options.max_contacts);
                            });
    if (!search_.asks_world() || search_.ended()) return;
    const auto visit = [&](const WorldObject& object) {
      if (search_.Skips(object)) return true;
      const double margin_m = object.margin_m + own_margin_m;
      search_.ForEachPair(
          object, Reach_m(margin_m), Question::kDistance,
          [&](const BodySearch::Pair& pair) { return Add(pair, margin_m, options.max_contacts); });
      return !search_.ended();
    };
    const WorldSnapshot& world = search_.world();
    world.bounds().ForEachWithin(search_.body_bounds_W(),
                                 Reach_m(world.objects().widest_margin_m() + own_margin_m), visit);
  }

  const std::vector<FoundPair>& contacts() const { return best_.pairs(); }

 private:
  static double Reach_m(double margin_m) { return std::max(0.0, margin_m); }

  double Add(const BodySearch::Pair& pair, double margin_m, int max_count) {
    scratch_.clear();
    pair.engine.Contacts(pair.body, pair.object, margin_m, max_count, scratch_);
    for (const PairDistance& contact : scratch_) best_.Add({.answer = contact, .id = pair.id});
    return Reach_m(margin_m);
  }

  BodySearch& search_;
  BestPairs best_;
  std::vector<PairDistance> scratch_;
};

}  // namespace

absl::StatusOr<PairColumns> GetContacts(const WorldSnapshot& world, const QueryBody& body,
                                        const BodyRows& rows, const QueryOptions& options,
                                        std::stop_token stop) {
  BodySearch search(world, body, options, std::move(stop));
  ContactFinder finder(search, options.max_contacts);
  ObjectRanks ranks(world);
  PairColumns columns;
  Reserve(columns, rows.size(), std::max(0, options.max_contacts));
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (search.MustEnd()) break;
    search.PlaceBody(rows, row);
    finder.FindAll(options, body.margin_m + options.margin_m);
    if (search.ended()) break;
    AppendRow(columns, finder.contacts(), ranks);
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  LimitTrust(columns, body.best_trust);
  return columns;
}

}  // namespace cwm::collision
