#include "clients/formats/pose_file.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/scalar.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {
namespace {

// chosen: rotations may be written with four digits.
constexpr double kRotationTolerance = 1e-3;

using Rotation = std::array<std::array<double, 3>, 3>;

bool IsRotation(const Rotation& r) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double product = 0;
      for (std::size_t k = 0; k < 3; ++k) product += r[i][k] * r[j][k];
      if (std::abs(product - (i == j ? 1 : 0)) > kRotationTolerance) return false;
    }
  }
  const double determinant = r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) -
                             r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0]) +
                             r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0]);
  return determinant > 0;
}

// By the largest component, so that nothing cancels.
std::array<double, 4> QuaternionOf(const Rotation& r) {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  // 4 q_i^2 of x, y, z, w.
  const std::array<double, 4> squares = {1 + 2 * r[0][0] - trace, 1 + 2 * r[1][1] - trace,
                                         1 + 2 * r[2][2] - trace, 1 + trace};
  const auto largest =
      static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());
  std::array<double, 4> q = {};  // 4 q_largest q_i
  q[largest] = squares[largest];
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    if (largest == 3) q[i] = r[k][j] - r[j][k];
    if (largest == i) q[3] = r[k][j] - r[j][k];
    if (largest == i) q[j] = r[i][j] + r[j][i];
    if (largest == i) q[k] = r[i][k] + r[k][i];
  }
  return q;
}

absl::StatusOr<std::vector<double>> FiniteNumbers(std::string_view text, const std::string& file,
                                                  const std::string& what) {
  std::vector<double> numbers;
  for (const std::string_view word : SplitWords(text)) {
    double number = 0;
    if (!ParseScalar(word, Scalar::kF64, reinterpret_cast<char*>(&number)) ||
        !std::isfinite(number)) {
      return FileError(file, {what, std::string(word), "must be finite numbers"});
    }
    numbers.push_back(number);
  }
  return numbers;
}

}  // namespace

std::optional<ScenePose> PoseFromRow(const std::array<double, 7>& row) {
  const double length = std::hypot(std::hypot(row[3], row[4]), std::hypot(row[5], row[6]));
  if (!(length > 0)) return std::nullopt;
  ScenePose pose;
  std::copy_n(row.begin(), 3, pose.position_m.begin());
  for (std::size_t i = 0; i < 4; ++i) pose.orientation_xyzw[i] = row[i + 3] / length;
  return pose;
}

absl::StatusOr<ScenePose> ParsePoseFile(std::string_view text, const std::string& file) {
  const auto parsed = FiniteNumbers(text, file, "the pose");
  if (!parsed.ok()) return parsed.status();
  const std::vector<double>& numbers = *parsed;
  if (numbers.size() == 7) {
    std::array<double, 7> row = {};
    std::copy(numbers.begin(), numbers.end(), row.begin());
    if (const auto pose = PoseFromRow(row)) return *pose;
  }
  if (numbers.size() != 16) {
    return FileError(file, {"the pose", absl::StrCat(numbers.size(), " numbers"),
                            "must be a 4 x 4 matrix or x y z qx qy qz qw"});
  }
  Rotation r = {};
  std::array<double, 7> row = {};
  for (std::size_t i = 0; i < 3; ++i) {
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(4 * i), 3, r[i].begin());
    row[i] = numbers[4 * i + 3];
  }
  const bool is_affine =
      numbers[12] == 0 && numbers[13] == 0 && numbers[14] == 0 && numbers[15] == 1;
  if (!is_affine || !IsRotation(r)) {
    return FileError(file, {"the pose", "",
                            "must be a rigid transform: an orthonormal, right-handed 3 x 3 block "
                            "and the last row 0 0 0 1"});
  }
  const std::array<double, 4> q = QuaternionOf(r);
  std::copy(q.begin(), q.end(), row.begin() + 3);
  return *PoseFromRow(row);
}

absl::StatusOr<ScenePose> ParseGravityFile(std::string_view text, const std::string& file) {
  const auto down = FiniteNumbers(text, file, "the direction of gravity");
  if (!down.ok()) return down.status();
  if (down->size() != 3 || std::hypot((*down)[0], (*down)[1], (*down)[2]) == 0) {
    return FileError(file, {"the direction of gravity", absl::StrCat(down->size(), " numbers"),
                            "must be three numbers, not all 0"});
  }
  ScenePose x_recording_world = PlaneFrame({-(*down)[0], -(*down)[1], -(*down)[2], 0});
  ScenePose x_world_recording;  // the inverse of a rotation
  for (std::size_t i = 0; i < 3; ++i) {
    x_world_recording.orientation_xyzw[i] = -x_recording_world.orientation_xyzw[i];
  }
  x_world_recording.orientation_xyzw[3] = x_recording_world.orientation_xyzw[3];
  return x_world_recording;
}

}  // namespace cwm::formats
