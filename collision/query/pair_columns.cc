#include "collision/query/pair_columns.h"

namespace cwm::collision {
namespace {

void Append(std::vector<double>& column, const Vector3& v) {
  column.insert(column.end(), {v.x(), v.y(), v.z()});
}

}  // namespace

void Reserve(PairColumns& columns, std::size_t rows, std::size_t pairs_per_row) {
  // Contacts are rarely as many as allowed: room for one pair a row, then growth by doubling.
  const std::size_t pairs = rows * std::min<std::size_t>(pairs_per_row, 2);
  columns.row_begin.reserve(rows + 1);
  columns.row_begin.push_back(0);
  columns.distance_m.reserve(pairs);
  columns.point_body.reserve(3 * pairs);
  columns.point_object.reserve(3 * pairs);
  columns.normal.reserve(3 * pairs);
  columns.object.reserve(pairs);
  columns.body_part.reserve(pairs);
  columns.object_part.reserve(pairs);
  columns.trust.reserve(pairs);
  columns.bound_m.reserve(pairs);
}

void LimitTrust(PairColumns& columns, Trust best) {
  for (Trust& trust : columns.trust) trust = std::max(trust, best);
}

void AppendRow(PairColumns& columns, const std::vector<FoundPair>& pairs, ObjectRanks& ranks) {
  for (const FoundPair& pair : pairs) {
    columns.distance_m.push_back(pair.answer.distance_m);
    Append(columns.point_body, pair.answer.point_a);
    Append(columns.point_object, pair.answer.point_b);
    Append(columns.normal, pair.answer.normal);
    columns.object.push_back(pair.id.IsOfItself() ? kItself : ranks.Of(pair.id.object));
    columns.body_part.push_back(pair.id.body_part);
    columns.object_part.push_back(pair.id.object_part);
    columns.trust.push_back(pair.answer.trust);
    columns.bound_m.push_back(pair.answer.bound_m);
  }
  columns.row_begin.push_back(static_cast<std::uint32_t>(columns.distance_m.size()));
  ++columns.completed;
}

}  // namespace cwm::collision
