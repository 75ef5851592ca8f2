#include "collision/inverse_kinematics/solve_poses.h"

#include <algorithm>
#include <memory>
#include <numbers>
#include <utility>

#include "collision/query/interrupt.h"
#include "collision/query/row_chunks.h"
#include "collision/query/time_limit.h"

namespace cwm::collision {
namespace {

// chosen: a pose takes some microseconds, one out of reach a millisecond.
constexpr std::size_t kPosesPerChunk = 16;
// chosen: solutions of a pose that are tested for collisions, at first and if all of them collide.
constexpr int kFewCandidates = 4, kManyCandidates = 64;
// chosen: steps of the search beyond the limits, which only explains why a pose is not reached.
constexpr int kStepsBeyondLimits = 200;

// The chain with joints that may turn a whole turn beyond their limits.
IkChain BeyondLimits(IkChain chain) {
  for (IkVariable& variable : chain.variables) {
    variable.lower -= 2 * std::numbers::pi;
    variable.upper += 2 * std::numbers::pi;
  }
  return chain;
}

// The answer about one pose.
struct SolvedPose {
  PoseStatus status = PoseStatus::kNotComputed;
  std::vector<PoseSolution> rows;
};

// One call of SolvePoses.
struct Batch {
  const IkChain& chain;
  const IkChain beyond_limits;
  const std::size_t width;
  const PoseBatch& poses;
  std::stop_token stop;
  TimeLimit limit;
  std::vector<SolvedPose> solved;

  std::span<const double> SeedOf(std::size_t pose) const {
    const bool is_shared = poses.seeds.size() == width;
    return poses.seeds.subspan(is_shared ? 0 : pose * width, width);
  }

  PoseRequest RequestOf(std::size_t pose) const {
    return {.X_BT = poses.X_WB.inverse(Eigen::Isometry) * poses.X_WT[pose],
            .position_tolerance_m = poses.position_tolerance_m,
            .rotation_tolerance_rad = poses.rotation_tolerance_rad,
            .seed = SeedOf(pose),
            .max_solutions = poses.max_solutions,
            .same_branch = poses.same_branch,
            .max_steps = poses.max_steps};
  }
};

// Solves poses without regard to collisions.
class Solver : public ChunkWorker {
 public:
  // Solves the poses at `which`, each with up to `max_solutions` solutions.
  Solver(Batch& batch, std::span<const std::size_t> which, int max_solutions)
      : batch_(batch),
        which_(which),
        max_solutions_(max_solutions),
        solver_(batch.chain),
        beyond_limits_(batch.beyond_limits),
        interrupt_(batch.stop, batch.limit) {}

  ChunkResult Process(const RowChunk& chunk) override {
    std::size_t k = 0;
    for (; k < chunk.count; ++k) {
      if (interrupt_.CountWork(kWorkOfPose)) break;
      batch_.solved[which_[chunk.first + k]] = Solve(which_[chunk.first + k]);
    }
    if (interrupt_.reason() != Interrupt::Reason::kStopped) return {k};
    return {k, absl::CancelledError("the question was cancelled")};
  }

 private:
  static constexpr int kWorkOfPose = 100;  // in units of Interrupt, about a microsecond

  SolvedPose Solve(std::size_t pose) {
    PoseRequest request = batch_.RequestOf(pose);
    request.max_solutions = max_solutions_;
    PoseAnswer answer = solver_.Solve(request);
    if (!answer.solutions.empty()) return {PoseStatus::kSolved, std::move(answer.solutions)};
    request.max_solutions = 1;
    request.max_steps = std::min(request.max_steps, kStepsBeyondLimits);
    PoseAnswer beyond = beyond_limits_.Solve(request);
    if (!beyond.solutions.empty()) return {PoseStatus::kOutOfLimits, std::move(beyond.solutions)};
    return {PoseStatus::kUnreachable, {std::move(answer.nearest)}};
  }

  Batch& batch_;
  std::span<const std::size_t> which_;
  const int max_solutions_;
  PoseSolver solver_, beyond_limits_;
  Interrupt interrupt_;
};

absl::StatusOr<std::size_t> SolveThese(Batch& batch, std::span<const std::size_t> which,
                                       int max_solutions, int threads) {
  return ProcessChunks(EqualChunks(which.size(), kPosesPerChunk), threads,
                       [&] { return std::make_unique<Solver>(batch, which, max_solutions); });
}

// Keeps the free solutions of the poses at `which`, at most as many as are asked for. A pose all of
// whose solutions collide keeps the first. Returns the poses that were tested completely.
absl::StatusOr<std::size_t> KeepFree(const WorldSnapshot& world, const QueryBody& body,
                                     const JointRows& states, const QueryOptions& options,
                                     std::span<const std::size_t> which, Batch& batch) {
  std::vector<double> rows;
  for (const std::size_t pose : which) {
    if (batch.solved[pose].status != PoseStatus::kSolved) continue;
    for (const PoseSolution& solution : batch.solved[pose].rows) {
      rows.insert(rows.end(), solution.row.begin(), solution.row.end());
    }
  }
  if (rows.empty()) return which.size();
  const JointRows candidates(
      states.model(), states.group(),
      {.X_WB = states.states().X_WB, .base = states.states().base, .rows = rows});
  QueryOptions verdicts = options;
  verdicts.naming = Naming::kWhereTested;
  const auto found = CheckCollisions(world, body, candidates, verdicts, batch.stop);
  if (!found.ok()) return found.status();
  std::size_t next = 0;
  for (std::size_t k = 0; k < which.size(); ++k) {
    SolvedPose& solved = batch.solved[which[k]];
    if (solved.status != PoseStatus::kSolved) continue;
    if (next + solved.rows.size() > found->completed) return k;
    std::vector<PoseSolution> free;
    for (PoseSolution& solution : solved.rows) {
      const bool is_free = found->verdict[next++] == Verdict::kFree;
      const bool is_wanted = std::ssize(free) < std::max(1, batch.poses.max_solutions);
      if (is_free && is_wanted) free.push_back(std::move(solution));
    }
    if (free.empty()) {
      solved.status = PoseStatus::kInCollision;
      solved.rows.resize(1);
    } else {
      solved.rows = std::move(free);
    }
  }
  return which.size();
}

void Append(const SolvedPose& solved, PoseColumns& columns) {
  columns.status.push_back(solved.status);
  for (const PoseSolution& solution : solved.rows) {
    columns.rows.insert(columns.rows.end(), solution.row.begin(), solution.row.end());
    columns.position_error_m.push_back(solution.position_error_m);
    columns.rotation_error_rad.push_back(solution.rotation_error_rad);
  }
  columns.row_begin.push_back(static_cast<std::uint32_t>(columns.position_error_m.size()));
}

}  // namespace

absl::StatusOr<PoseColumns> SolvePoses(const WorldSnapshot& world, const QueryBody& body,
                                       const IkChain& chain, const JointRows& states,
                                       const PoseBatch& batch, const QueryOptions& options,
                                       std::stop_token stop) {
  Batch all{.chain = chain,
            .beyond_limits = BeyondLimits(chain),
            .width = states.group().variables.size(),
            .poses = batch,
            .stop = stop,
            .limit = TimeLimit(options),
            .solved = std::vector<SolvedPose>(batch.X_WT.size())};
  std::vector<std::size_t> which(batch.X_WT.size());
  for (std::size_t k = 0; k < which.size(); ++k) which[k] = k;
  const int asked = std::max(1, batch.max_solutions);
  const bool has_alternatives = batch.avoid_collision && !batch.same_branch;
  auto completed = SolveThese(
      all, which, has_alternatives ? std::max(asked, kFewCandidates) : asked, options.threads);
  if (!completed.ok()) return completed.status();
  which.resize(*completed);
  if (batch.avoid_collision) {
    auto tested = KeepFree(world, body, states, options, which, all);
    if (!tested.ok()) return tested.status();
    completed = *tested;
  }
  if (has_alternatives && *completed == which.size()) {
    std::erase_if(which, [&](std::size_t pose) {
      return all.solved[pose].status != PoseStatus::kInCollision;
    });
    const auto again = SolveThese(all, which, kManyCandidates, options.threads);
    if (!again.ok()) return again.status();
    if (*again < which.size()) completed = which[*again];
    which.resize(*again);
    const auto tested = KeepFree(world, body, states, options, which, all);
    if (!tested.ok()) return tested.status();
    if (*tested < which.size()) completed = which[*tested];
  }
  PoseColumns columns;
  columns.row_begin.push_back(0);
  for (std::size_t k = 0; k < batch.X_WT.size(); ++k) {
    Append(k < *completed ? all.solved[k] : SolvedPose(), columns);
  }
  columns.completed = *completed;
  return columns;
}

}  // namespace cwm::collision
