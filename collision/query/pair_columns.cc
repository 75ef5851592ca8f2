#include "collision/query/pair_columns.h"

#include <utility>

namespace cwm::collision {
namespace {

void Append(std::vector<double>& column, const Vector3& v) {
  column.insert(column.end(), {v.x(), v.y(), v.z()});
}

template <class Value>
void Append(std::vector<Value>& column, const std::vector<Value>& more) {
  column.insert(column.end(), more.begin(), more.end());
}

void Append(PairColumns& columns, const PairColumns& more) {
  const std::uint32_t begin = columns.row_begin.back();
  for (std::size_t row = 1; row <= more.completed; ++row) {
    columns.row_begin.push_back(begin + more.row_begin[row]);
  }
  Append(columns.distance_m, more.distance_m);
  Append(columns.point_body, more.point_body);
  Append(columns.point_object, more.point_object);
  Append(columns.normal, more.normal);
  Append(columns.object, more.object);
  Append(columns.body_part, more.body_part);
  Append(columns.object_part, more.object_part);
  Append(columns.accuracy, more.accuracy);
  Append(columns.bound_m, more.bound_m);
  Append(columns.joint_gradient, more.joint_gradient);
  Append(columns.gradient_kink, more.gradient_kink);
  columns.completed += more.completed;
}

}  // namespace

void Reserve(PairColumns& columns, std::size_t rows, std::size_t pairs_per_row) {
  // Rows rarely have as many contacts as allowed, so at most two pairs per row are reserved; the
  // columns then grow by doubling.
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
  columns.accuracy.reserve(pairs);
  columns.bound_m.reserve(pairs);
}

void LimitAccuracy(PairColumns& columns, Accuracy best) {
  for (Accuracy& accuracy : columns.accuracy) accuracy = std::max(accuracy, best);
}

void AppendRow(PairColumns& columns, const std::vector<FoundPair>& pairs, ObjectRanks& ranks) {
  for (const FoundPair& pair : pairs) {
    columns.distance_m.push_back(pair.answer.distance_m);
    Append(columns.point_body, pair.answer.point_a);
    Append(columns.point_object, pair.answer.point_b);
    Append(columns.normal, pair.answer.normal);
    columns.object.push_back(pair.id.IsSelfPair() ? kSelfObject : ranks.IndexOf(pair.id.object));
    columns.body_part.push_back(pair.id.body_part);
    columns.object_part.push_back(pair.id.object_part);
    columns.accuracy.push_back(pair.answer.accuracy);
    columns.bound_m.push_back(pair.answer.bound_m);
  }
  columns.row_begin.push_back(static_cast<std::uint32_t>(columns.distance_m.size()));
  ++columns.completed;
}

PairColumns Joined(std::vector<PairColumns> pieces, std::size_t completed) {
  if (!pieces.empty() && pieces.front().completed == completed) return std::move(pieces.front());
  PairColumns columns;
  Reserve(columns, completed, 1);
  for (PairColumns& piece : pieces) {
    if (columns.completed == completed) break;
    Append(columns, std::exchange(piece, {}));
  }
  return columns;
}

}  // namespace cwm::collision
