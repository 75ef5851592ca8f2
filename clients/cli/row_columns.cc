#include "clients/cli/row_columns.h"

#include <cstdint>
#include <cstring>
#include <string>

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

// Reads numbers from the bytes of a column.
template <class T>
class ColumnReader {
 public:
  explicit ColumnReader(const std::string& bytes) : bytes_(bytes) {}
  std::size_t size() const { return bytes_.size() / sizeof(T); }
  T operator[](std::size_t i) const {
    T value;
    std::memcpy(&value, bytes_.data() + i * sizeof(T), sizeof(T));
    return value;
  }

 private:
  const std::string& bytes_;
};

constexpr std::int32_t kNoObject = -1, kSelf = -2;  // special values of an object_index

absl::Status Mismatch() {
  return absl::DataLossError("the columns of the server's answer do not fit together");
}

void SetVector(const ColumnReader<double>& column, std::size_t i, pb::Vector3* vector) {
  vector->set_x(column[3 * i]);
  vector->set_y(column[3 * i + 1]);
  vector->set_z(column[3 * i + 2]);
}

// The pair of a row in the form of its message: index -2 is the subject robot itself.
struct PairAt {
  std::int32_t object, body_part, object_part;
};

// False if it names something that the answer does not have.
template <class Response, class Row>
bool SetPair(const PairAt& pair, const Response& response, Row& row) {
  const bool is_self = pair.object == kSelf;
  if (pair.object >= response.objects_size() || (pair.object < 0 && !is_self)) return false;
  if (!is_self) {
    const pb::ObjectRef& met = response.objects(pair.object);
    row.set_object(met.name());
    if (met.part_links_size() > 0) {  // the obstacle is a robot
      if (pair.object_part < 0 || pair.object_part >= met.part_links_size()) return false;
      row.set_object_link(met.part_links(pair.object_part));
    }
  }
  row.set_body_part(pair.body_part);
  row.set_object_part(pair.object_part);
  const int links = response.body_links_size();
  if (links == 0) return !is_self;
  const auto has_link = [&](std::int32_t part) { return part >= 0 && part < links; };
  if (!has_link(pair.body_part) || (is_self && !has_link(pair.object_part))) return false;
  row.set_body_link(response.body_links(pair.body_part));
  if (is_self) row.set_object_link(response.body_links(pair.object_part));
  if (response.body_objects_size() == 0) return true;  // nothing is attached
  if (response.body_objects_size() != links) return false;
  const std::string& mine = response.body_objects(pair.body_part);
  if (!mine.empty()) row.set_body_object(mine);
  if (!is_self) return true;
  const std::string& theirs = response.body_objects(pair.object_part);
  if (!theirs.empty()) row.set_object(theirs);
  return true;
}

bool Fit(const pb::PairColumns& columns, std::size_t count) {
  const std::size_t vector_bytes = 3 * sizeof(double) * count;
  return columns.distance_m().size() == sizeof(double) * count &&
         columns.point_body().size() == vector_bytes &&
         columns.point_object().size() == vector_bytes && columns.normal().size() == vector_bytes &&
         columns.object_index().size() == sizeof(std::int32_t) * count &&
         columns.body_part().size() == sizeof(std::int32_t) * count &&
         columns.object_part().size() == sizeof(std::int32_t) * count &&
         columns.trust().size() == count &&
         (columns.bound_m().empty() || columns.bound_m().size() == sizeof(double) * count);
}

// Reads the derivatives by the variables of a row. A query without gradients has none.
class GradientReader {
 public:
  GradientReader(const pb::PairColumns& columns, int width)
      : gradient_(columns.joint_gradient()),
        kink_(columns.gradient_kink()),
        width_(static_cast<std::size_t>(width)) {}

  bool Fits(std::size_t count) const {
    const bool is_absent = kink_.size() == 0 && width_ == 0;
    return gradient_.size() == width_ * count && (is_absent || kink_.size() == count);
  }
  void Set(std::size_t i, pb::PairRow& row) const {
    for (std::size_t k = 0; k < width_; ++k) row.add_joint_gradient(gradient_[i * width_ + k]);
    if (kink_.size() > 0) row.set_gradient_kink(kink_[i] != 0);
  }

 private:
  ColumnReader<double> gradient_;
  ColumnReader<char> kink_;
  std::size_t width_;
};

int VariableCount(const pb::GetDistancesResponse& response) { return response.variables_size(); }
int VariableCount(const pb::GetContactsResponse&) { return 0; }

template <class Response>
absl::Status ExpandPairs(Response& response) {
  if (!response.has_columns()) return absl::OkStatus();
  const pb::PairColumns& columns = response.columns();
  const ColumnReader<std::uint32_t> row_begin(columns.row_begin());
  const std::size_t rows = row_begin.size() == 0 ? 0 : row_begin.size() - 1;
  const std::size_t count = rows == 0 ? 0 : row_begin[rows];
  const GradientReader gradients(columns, VariableCount(response));
  if (!Fit(columns, count) || !gradients.Fits(count)) return Mismatch();
  const ColumnReader<double> distance(columns.distance_m()), body(columns.point_body()),
      object(columns.point_object()), normal(columns.normal()), bound(columns.bound_m());
  const ColumnReader<std::int32_t> index(columns.object_index()), body_part(columns.body_part()),
      object_part(columns.object_part());
  for (std::size_t row = 0; row < rows; ++row) {
    pb::PairRows& answers = *response.add_rows();
    if (row_begin[row] > row_begin[row + 1] || row_begin[row + 1] > count) return Mismatch();
    for (std::size_t i = row_begin[row]; i < row_begin[row + 1]; ++i) {
      pb::PairRow& pair = *answers.add_answers();
      pair.set_distance_m(distance[i]);
      SetVector(body, i, pair.mutable_point_body());
      SetVector(object, i, pair.mutable_point_object());
      SetVector(normal, i, pair.mutable_normal());
      if (!SetPair({index[i], body_part[i], object_part[i]}, response, pair)) return Mismatch();
      pair.set_trust(static_cast<pb::Trust>(columns.trust()[i]));
      const bool has_bound =
          pair.trust() == pb::TRUST_BOUNDED || pair.trust() == pb::TRUST_SURFACE_ONLY;
      if (bound.size() > 0 && has_bound) pair.set_bound_m(bound[i]);
      gradients.Set(i, pair);
    }
  }
  response.clear_columns();
  return absl::OkStatus();
}

}  // namespace

absl::Status ExpandRows(pb::GetDistancesResponse& response) { return ExpandPairs(response); }
absl::Status ExpandRows(pb::GetContactsResponse& response) { return ExpandPairs(response); }

absl::Status ExpandRows(pb::CheckCollisionsResponse& response) {
  const std::size_t rows = response.verdicts().size();
  const ColumnReader<std::int32_t> index(response.object_index()), body_part(response.body_part()),
      object_part(response.object_part());
  // The column is empty if all rows are within limits.
  const ColumnReader<std::int32_t> variable(response.variable_index());
  if (index.size() != rows || body_part.size() != rows || object_part.size() != rows ||
      response.trust().size() != rows || (variable.size() != rows && variable.size() != 0)) {
    return Mismatch();
  }
  for (std::size_t row = 0; row < rows; ++row) {
    pb::CollisionRow& answer = *response.add_rows();
    answer.set_verdict(static_cast<pb::Verdict>(response.verdicts()[row]));
    answer.set_trust(static_cast<pb::Trust>(response.trust()[row]));
    if (variable.size() > 0 && variable[row] != kNoObject) {
      if (variable[row] < 0 || variable[row] >= response.variables_size()) return Mismatch();
      answer.set_variable(response.variables(variable[row]));
    }
    if (index[row] == kNoObject) continue;
    if (!SetPair({index[row], body_part[row], object_part[row]}, response, answer)) {
      return Mismatch();
    }
  }
  response.clear_verdicts();
  response.clear_object_index();
  response.clear_body_part();
  response.clear_object_part();
  response.clear_trust();
  response.clear_variable_index();
  response.clear_variables();
  return absl::OkStatus();
}

}  // namespace cwm::cli
