#include "clients/planner/server_checker.h"

#include <algorithm>
#include <cstring>

#include "absl/strings/str_cat.h"

namespace cwm::planner {
namespace {

// chosen: far below the limit of a message; thousands of states of any robot.
constexpr std::size_t kMaxNumbers = 1 << 18;

}  // namespace

ServerChecker::ServerChecker(client::QueryStream& stream, v1::CheckCollisionsRequest query)
    : stream_(stream) {
  *request_.mutable_check_collisions() = std::move(query);
  request_.mutable_check_collisions()->mutable_options()->set_verdicts_only(true);
}

absl::StatusOr<std::vector<std::uint8_t>> ServerChecker::Evaluate(std::span<const double> rows,
                                                                  std::size_t width) {
  std::vector<std::uint8_t> free;
  const std::size_t part = std::max<std::size_t>(1, kMaxNumbers / width) * width;
  for (std::size_t begin = 0; begin < rows.size(); begin += part) {
    const auto status =
        EvaluatePart(rows.subspan(begin, std::min(part, rows.size() - begin)), width, free);
    if (!status.ok()) return status;
  }
  if (free.size() * width != rows.size()) {
    return absl::DataLossError(
        absl::StrCat("the server answered ", free.size(), " of ", rows.size() / width, " states"));
  }
  return free;
}

absl::Status ServerChecker::EvaluatePart(std::span<const double> rows, std::size_t width,
                                         std::vector<std::uint8_t>& free) {
  v1::JointRows& joint_rows =
      *request_.mutable_check_collisions()->mutable_subject()->mutable_robot()->mutable_rows();
  joint_rows.set_scalar(v1::SCALAR_F64);
  joint_rows.set_width(static_cast<std::int32_t>(width));
  std::string& data = *joint_rows.mutable_data();
  data.resize(rows.size_bytes());
  std::memcpy(data.data(), rows.data(), data.size());
  const auto response = stream_.Evaluate(request_);
  if (!response.ok()) return response.status();
  for (const char verdict : response->check_collisions().verdicts()) {
    free.push_back(verdict == static_cast<char>(v1::VERDICT_FREE) ? 1 : 0);
  }
  return absl::OkStatus();
}

}  // namespace cwm::planner
