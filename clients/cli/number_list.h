// Numbers as they are written on the command line: "0.1,0.2,0.3".
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/row_bytes.h"
#include "cwm/v1/geometry.pb.h"

namespace cwm::cli {

// Where numbers were written, and what they are: {"--box", "x,y,z (m)"}.
struct NumberSpec {
  std::string name;
  std::string form;
  std::size_t count = 1;
};

// Exactly `count` numbers, "nan" and "inf" among them (the server refuses those and names its
// field). A usage error naming the option, the text and the form otherwise.
absl::StatusOr<std::vector<double>> ParseNumbers(const std::string& text, const NumberSpec& spec);

// The same of any count but 0.
absl::StatusOr<std::vector<double>> ParseNumbers(const std::string& text, const std::string& name,
                                                 const std::string& form);
// Whether it is numbers rather than a name.
bool StartsWithNumber(const std::string& text);

// "x,y,z" or "x,y,z,qx,qy,qz,qw" in metres; the quaternion is passed on as it is (the server checks
// its length).
absl::StatusOr<client::PoseRow> ParsePose(const std::string& text, const std::string& option);
// The same from numbers that were read elsewhere.
absl::StatusOr<client::PoseRow> PoseFromNumbers(const std::vector<double>& numbers,
                                                const std::string& name);

absl::StatusOr<cwm::v1::Vector3> ParseVector(const std::string& text, const std::string& option);

cwm::v1::Pose ToProto(const client::PoseRow& pose);
client::PoseRow FromProto(const cwm::v1::Pose& pose);

}  // namespace cwm::cli
