#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/pair_rows.h"
#include "collision/query/query.h"

namespace cwm::collision {
namespace {

// Collects the contacts of a row. The deepest points of all pairs come first; further points of a
// pair only fill the remaining places, so that the corners of one pair do not displace another
// pair.
class ContactFinder : public RowFinder {
 public:
  ContactFinder(BodySearch& search, int max_count, int max_count_of_pair)
      : search_(search),
        max_count_(max_count),
        max_count_of_pair_(max_count_of_pair > 0 ? std::min(max_count, max_count_of_pair)
                                                 : max_count),
        first_(max_count),
        further_(max_count) {}

  const std::vector<FoundPair>& Find() override {
    FindAll();
    const std::vector<FoundPair>& first = first_.pairs();
    const std::vector<FoundPair>& further = further_.pairs();
    const std::size_t room = static_cast<std::size_t>(std::max(0, max_count_)) - first.size();
    const auto end = further.begin() + static_cast<std::ptrdiff_t>(std::min(room, further.size()));
    found_.clear();
    std::merge(first.begin(), first.end(), further.begin(), end, std::back_inserter(found_));
    return found_;
  }

 private:
  void FindAll() {
    first_.Clear();
    further_.Clear();
    const auto add = [&](const BodySearch::Pair& pair) { return Add(pair); };
    search_.ForEachSelfPair(BodySearch::From::kMargin, 0, QueryKind::kDistance, add);
    if (!search_.tests_world() || search_.ended()) return;
    const auto visit = [&](const Obstacle& object) {
      if (search_.Skips(object)) return true;
      search_.ForEachPair(object, BodySearch::From::kMargin, 0, QueryKind::kDistance, add);
      return !search_.ended();
    };
    search_.world().bounds().ForEachWithin(search_.body_bounds_W(),
                                           std::max(0.0, search_.max_margin_m()), visit);
  }

  // Adds the contacts of a pair and returns the reach beyond the margins, which is always 0.
  double Add(const BodySearch::Pair& pair) {
    scratch_.clear();
    pair.engine.Contacts(pair.body, pair.object, pair.margin_m, max_count_of_pair_, scratch_,
                         pair.work);
    for (std::size_t i = 0; i < scratch_.size(); ++i) {
      (i == 0 ? first_ : further_).Add({.answer = scratch_[i], .id = pair.id});
    }
    return 0;
  }

  BodySearch& search_;
  const int max_count_, max_count_of_pair_;
  BestPairs first_, further_;  // deepest point of each pair, and further points
  std::vector<FoundPair> found_;
  std::vector<PairDistance> scratch_;
};

}  // namespace

absl::StatusOr<PairColumns> GetContacts(const WorldSnapshot& world, const QueryBody& body,
                                        const BodyRows& rows, const QueryOptions& options,
                                        std::stop_token stop) {
  return FindPairs({world, body, rows, options, std::move(stop)}, options.max_contacts,
                   [&](BodySearch& search) -> std::unique_ptr<RowFinder> {
                     return std::make_unique<ContactFinder>(search, options.max_contacts,
                                                            options.max_contacts_per_pair);
                   });
}

}  // namespace cwm::collision
