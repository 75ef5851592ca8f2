#include "clients/planner/server_checker.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cpp/call_error.h"

namespace cwm::planner {

ServerChecker::ServerChecker(StateQuery query) : query_(std::move(query)) {
  query_.options.verdicts_only = true;
}

absl::StatusOr<std::vector<std::uint8_t>> ServerChecker::Evaluate(std::span<const double> rows,
                                                                  std::size_t width) {
  const auto dof = static_cast<Eigen::Index>(width);
  const Eigen::Map<const Eigen::MatrixXd> states(rows.data(), dof,
                                                 static_cast<Eigen::Index>(rows.size()) / dof);
  try {
    const CheckResult checked = query_.world.Check(query_.robot, states, query_.options);
    if (!checked.complete()) {
      return absl::DataLossError(absl::StrCat("the server answered ", checked.completed_count,
                                              " of ", checked.row_count, " states"));
    }
    std::vector<std::uint8_t> free;
    free.reserve(checked.verdict.size());
    for (const Verdict verdict : checked.verdict) free.push_back(verdict == Verdict::kFree ? 1 : 0);
    return free;
  } catch (const Error& error) {
    return client::StatusFromError(error);
  }
}

}  // namespace cwm::planner
