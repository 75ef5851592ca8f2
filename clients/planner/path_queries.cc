#include "clients/planner/path_queries.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "clients/cpp/call_error.h"

namespace cwm::planner {
namespace {

// The pair of a row or a motion in words; empty if none is named.
template <class Result>
std::string ContactText(const Result& result, Eigen::Index i) {
  const NamedPairOfParts pair = result.pair(i);
  const std::string& who = pair.body_object.empty() ? pair.body_link : pair.body_object;
  if (result.object_index[i] == kItself) {
    return absl::StrCat(who, " meets ", pair.object_link, " of the robot itself");
  }
  if (pair.object.empty()) return "";
  const std::string of_robot = pair.object_link.empty() ? "" : absl::StrCat(":", pair.object_link);
  return absl::StrCat(who, " meets ", pair.object, of_robot);
}

}  // namespace

absl::StatusOr<std::string> DescribeCollision(const StateQuery& query, const Row& row) {
  try {
    const CheckResult checked = query.world.Check(query.robot, row, query.options);
    if (!checked.complete()) return absl::DataLossError("the server answered no row of 1");
    const Verdict verdict = checked.verdict[0];
    const bool names_pair = verdict == Verdict::kCollision || verdict == Verdict::kUndecided;
    const std::string contact = names_pair ? ContactText(checked, 0) : "";
    return contact.empty() ? absl::StrCat("the verdict is ", NameOf(verdict)) : contact;
  } catch (const Error& error) {
    return client::StatusFromError(error);
  }
}

absl::StatusOr<Certificate> CertifyPath(const StateQuery& query, const std::vector<Row>& path) {
  Eigen::MatrixXd states(path.empty() ? 0 : path.front().size(), path.size());
  for (std::size_t k = 0; k < path.size(); ++k) {
    std::copy(path[k].begin(), path[k].end(), states.col(static_cast<Eigen::Index>(k)).begin());
  }
  try {
    const MotionResult motion = query.world.Path(query.robot, states, query.options);
    if (!motion.complete()) return absl::DataLossError("the server answered no motion of 1");
    return Certificate{.verdict = motion.verdict[0],
                       .clearance_m = motion.clearance_m[0],
                       .segment = std::max(0, motion.segment[0]),
                       .contact = ContactText(motion, 0),
                       .accuracy = motion.trust[0]};
  } catch (const Error& error) {
    return client::StatusFromError(error);
  }
}

}  // namespace cwm::planner
