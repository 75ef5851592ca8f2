#include <algorithm>
#include <utility>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

// Gathers the contacts of a row, with a buffer for those of a pair.
class ContactFinder {
 public:
  ContactFinder(BodySearch& search, int max_count)
      : search_(search), max_count_(max_count), best_(max_count) {}

  void FindAll() {
    best_.Clear();
    const auto add = [&](const BodySearch::Pair& pair) { return Add(pair); };
    search_.ForEachSelfPair(BodySearch::From::kMargin, 0, Question::kDistance, add);
    if (!search_.asks_world() || search_.ended()) return;
    const auto visit = [&](const Obstacle& object) {
      if (search_.Skips(object)) return true;
      search_.ForEachPair(object, BodySearch::From::kMargin, 0, Question::kDistance, add);
      return !search_.ended();
    };
    search_.world().bounds().ForEachWithin(search_.body_bounds_W(),
                                           std::max(0.0, search_.widest_margin_m()), visit);
  }

  const std::vector<FoundPair>& contacts() const { return best_.pairs(); }

 private:
  // The reach beyond the margins that still matters.
  double Add(const BodySearch::Pair& pair) {
    scratch_.clear();
    pair.engine.Contacts(pair.body, pair.object, pair.margin_m, max_count_, scratch_);
    for (const PairDistance& contact : scratch_) best_.Add({.answer = contact, .id = pair.id});
    return 0;
  }

  BodySearch& search_;
  const int max_count_;
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
    finder.FindAll();
    if (search.ended()) break;
    AppendRow(columns, finder.contacts(), ranks);
  }
  if (absl::Status status = search.Finish(); !status.ok()) return status;
  LimitTrust(columns, body.best_trust);
  return columns;
}

}  // namespace cwm::collision
