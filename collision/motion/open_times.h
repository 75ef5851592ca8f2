// The times of an edge at which pairs are not known to keep clear.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <optional>

#include "collision/query/body_search.h"

namespace cwm::collision {

// An interval of fractions of an edge.
struct TimeSpan {
  double from = 0, to = 1;
  double width() const { return to - from; }
  double middle() const { return 0.5 * (from + to); }
};

// By tag (UnresolvedTags): one interval that contains all open times of its pairs. Begins with the
// whole edge for every pair.
class OpenTimes {
 public:
  OpenTimes() = default;
  static OpenTimes None() {
    OpenTimes none;
    none.tags_ = {};
    return none;
  }

  void Add(const UnresolvedTags& tags, const TimeSpan& span) {
    AddTo(tags.worlds, tags_.worlds, worlds_, span);
    AddTo(tags.pairs, tags_.pairs, pairs_, span);
  }

  // Removes what is later.
  void ClipAt(double end) {
    const auto clip = [end](std::uint64_t& known, Spans& spans) {
      for (std::uint64_t tags = known; tags != 0; tags &= tags - 1) {
        const auto tag = static_cast<std::size_t>(std::countr_zero(tags));
        spans[tag].to = std::min(spans[tag].to, end);
        if (spans[tag].from > end) known &= ~(std::uint64_t{1} << tag);
      }
    };
    clip(tags_.worlds, worlds_);
    clip(tags_.pairs, pairs_);
  }

  // One interval that contains all open times.
  TimeSpan Whole() const { return *Of(tags_); }

  bool empty() const { return (tags_.worlds | tags_.pairs) == 0; }
  // All tags that are open at some time.
  const UnresolvedTags& tags() const { return tags_; }
  // The open times of a pair with these tags; empty if there are none.
  std::optional<TimeSpan> Of(const UnresolvedTags& pair) const {
    const std::uint64_t worlds = pair.worlds & tags_.worlds, pairs = pair.pairs & tags_.pairs;
    if ((worlds | pairs) == 0) return std::nullopt;
    TimeSpan span{1, 0};
    Extend(worlds, worlds_, span);
    Extend(pairs, pairs_, span);
    return span;
  }

 private:
  using Spans = std::array<TimeSpan, kTags>;

  static void AddTo(std::uint64_t tags, std::uint64_t& known, Spans& spans, const TimeSpan& span) {
    for (; tags != 0; tags &= tags - 1) {
      const auto tag = static_cast<std::size_t>(std::countr_zero(tags));
      const bool is_known = (known >> tag & 1) != 0;
      spans[tag] = is_known ? TimeSpan{std::min(spans[tag].from, span.from),
                                       std::max(spans[tag].to, span.to)}
                            : span;
      known |= std::uint64_t{1} << tag;
    }
  }
  static void Extend(std::uint64_t tags, const Spans& spans, TimeSpan& span) {
    for (; tags != 0; tags &= tags - 1) {
      const TimeSpan& of_tag = spans[static_cast<std::size_t>(std::countr_zero(tags))];
      span = {std::min(span.from, of_tag.from), std::max(span.to, of_tag.to)};
    }
  }

  UnresolvedTags tags_ = BodySearch::kAllUnresolved;
  Spans worlds_, pairs_;
};

}  // namespace cwm::collision
