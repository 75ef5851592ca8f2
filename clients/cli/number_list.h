// Parses numbers on the command line: "0.1,0.2,0.3".
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/row_bytes.h"
#include "cwm/v1/geometry.pb.h"

namespace cwm::cli {

// The option that has the numbers and their form: {"--box", "x,y,z (m)"}.
struct NumberSpec {
  std::string name;
  std::string form;
  std::size_t count = 1;
};

// Exactly `count` numbers. "nan" and "inf" are accepted here: the server refuses them with the
// field's name. Otherwise a usage error with the option, the text and the form.
absl::StatusOr<std::vector<double>> ParseNumbers(const std::string& text, const NumberSpec& spec);

// The same for any count but 0.
absl::StatusOr<std::vector<double>> ParseNumbers(const std::string& text, const std::string& name,
                                                 const std::string& form);
// True if the text is numbers rather than a name.
bool StartsWithNumber(const std::string& text);

// "x,y,z" or "x,y,z,qx,qy,qz,qw" in metres. The quaternion is passed on unchanged; the server
// checks its length.
absl::StatusOr<client::PoseRow> ParsePose(const std::string& text, const std::string& option);
// The same from numbers.
absl::StatusOr<client::PoseRow> PoseFromNumbers(const std::vector<double>& numbers,
                                                const std::string& name);

absl::StatusOr<cwm::v1::Vector3> ParseVector(const std::string& text, const std::string& option);

cwm::v1::Pose PoseToProto(const client::PoseRow& pose);
client::PoseRow PoseFromProto(const cwm::v1::Pose& pose);

}  // namespace cwm::cli
