#include "clients/cli/number_list.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "clients/cli/exit_code.h"
#include "clients/formats/scalar.h"

namespace cwm::cli {
namespace {

constexpr char kPoseForm[] = "x,y,z or x,y,z,qx,qy,qz,qw (m)";

absl::StatusOr<double> ParseNumber(const std::string& word, const std::string& name,
                                   const std::string& form) {
  char bytes[sizeof(double)];
  if (formats::ParseScalar(word, formats::Scalar::kF64, bytes)) {
    return formats::ToDouble(bytes, formats::Scalar::kF64);
  }
  return UsageError(absl::StrCat(name, ": \"", word, "\" is no number, must be ", form));
}

}  // namespace

bool StartsWithNumber(const std::string& text) {
  char bytes[sizeof(double)];
  return formats::ParseScalar(text.substr(0, text.find(',')), formats::Scalar::kF64, bytes);
}

absl::StatusOr<std::vector<double>> ParseNumbers(const std::string& text, const std::string& name,
                                                 const std::string& form) {
  std::vector<double> numbers;
  for (const absl::string_view word : absl::StrSplit(text, ',')) {
    const auto number = ParseNumber(std::string(word), name, form);
    if (!number.ok()) return number.status();
    numbers.push_back(*number);
  }
  return numbers;
}

absl::StatusOr<std::vector<double>> ParseNumbers(const std::string& text, const NumberSpec& spec) {
  auto numbers = ParseNumbers(text, spec.name, spec.form);
  if (numbers.ok() && numbers->size() != spec.count) {
    return UsageError(absl::StrCat(spec.name, ": \"", text, "\" has ", numbers->size(),
                                   " numbers, must be ", spec.form));
  }
  return numbers;
}

absl::StatusOr<client::PoseRow> PoseFromNumbers(const std::vector<double>& numbers,
                                                const std::string& name) {
  if (numbers.size() != 3 && numbers.size() != 7) {
    return absl::InvalidArgumentError(
        absl::StrCat(name, " has ", numbers.size(), " numbers, must be ", kPoseForm));
  }
  client::PoseRow pose = {0, 0, 0, 0, 0, 0, 1};
  std::copy(numbers.begin(), numbers.end(), pose.begin());
  return pose;
}

absl::StatusOr<client::PoseRow> ParsePose(const std::string& text, const std::string& option) {
  const auto numbers = ParseNumbers(text, option, kPoseForm);
  if (!numbers.ok()) return numbers.status();
  auto pose = PoseFromNumbers(*numbers, option);
  if (!pose.ok()) return UsageError(std::string(pose.status().message()));
  return pose;
}

absl::StatusOr<cwm::v1::Vector3> ParseVector(const std::string& text, const std::string& option) {
  const auto numbers = ParseNumbers(text, {option, "x,y,z", 3});
  if (!numbers.ok()) return numbers.status();
  cwm::v1::Vector3 vector;
  vector.set_x((*numbers)[0]);
  vector.set_y((*numbers)[1]);
  vector.set_z((*numbers)[2]);
  return vector;
}

cwm::v1::Pose PoseToProto(const client::PoseRow& pose) {
  cwm::v1::Pose proto;
  proto.set_tx_m(pose[0]);
  proto.set_ty_m(pose[1]);
  proto.set_tz_m(pose[2]);
  proto.set_qx(pose[3]);
  proto.set_qy(pose[4]);
  proto.set_qz(pose[5]);
  proto.set_qw(pose[6]);
  return proto;
}

client::PoseRow PoseFromProto(const cwm::v1::Pose& pose) {
  return {pose.tx_m(), pose.ty_m(), pose.tz_m(), pose.qx(), pose.qy(), pose.qz(), pose.qw()};
}

}  // namespace cwm::cli
