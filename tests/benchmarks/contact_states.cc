#include "tests/benchmarks/contact_states.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include "collision/query/robot_body.h"
#include "collision/robot/kinematics.h"

namespace cwm::benchmarks {
namespace {

using namespace collision;

class Arm {
 public:
  Arm(const PandaProblems& all, const PandaProblem& problem)
      : all_(all),
        problem_(problem),
        body_(BodyFromRobot(*all.robot, RobotScope::kBoth)),
        base_(DefaultVariables(*all.robot->model)),
        X_WL_(all.robot->model->links.size()) {}

  std::size_t width() const { return all_.arm->variables.size(); }

  std::vector<Verdict> VerdictsOf(const std::vector<double>& rows) const {
    return CheckCollisions(*problem_.world, body_, RowsOf(rows), {})->verdict;
  }

  // The largest distance that a point of the arm moves between two states. The point of a box that
  // a rigid motion moves farthest is a corner.
  double Motion_m(const std::vector<double>& from, const std::vector<double>& to) {
    const std::vector<Vector3> before = Corners(from), after = Corners(to);
    double widest_m2 = 0;
    for (std::size_t k = 0; k < before.size(); ++k) {
      widest_m2 = std::max(widest_m2, (after[k] - before[k]).squaredNorm());
    }
    return std::sqrt(widest_m2);
  }

 private:
  JointRows RowsOf(const std::vector<double>& rows) const {
    return {*all_.robot->model, *all_.arm, {.base = base_, .rows = rows}};
  }

  std::vector<Vector3> Corners(const std::vector<double>& row) {
    RowsOf(row).Place(0, X_WL_);
    std::vector<Vector3> corners;
    for (std::size_t part = 0; part < body_.geometry->parts.size(); ++part) {
      const Pose& X_WL = X_WL_[static_cast<std::size_t>(body_.frame_of_part[part])];
      const Aabb& bounds = body_.geometry->parts[part].bounds_O;
      for (int k = 0; k < 8; ++k) {
        corners.push_back(X_WL * bounds.corner(static_cast<Aabb::CornerType>(k)));
      }
    }
    return corners;
  }

  const PandaProblems& all_;
  const PandaProblem& problem_;
  const QueryBody body_;
  const std::vector<double> base_;
  std::vector<Pose> X_WL_;
};

using Row = std::vector<double>;

Row Between(const Row& a, const Row& b, double share) {
  Row row(a.size());
  for (std::size_t k = 0; k < row.size(); ++k) row[k] = a[k] + share * (b[k] - a[k]);
  return row;
}

// A line in joint space from a free state to one in collision; the verdict changes between `low`
// and `high`.
struct Line {
  Row free, colliding;
  double low = 0, high = 1;
};

// Bisects all lines together, because batches are faster.
void Bisect(const Arm& arm, std::vector<Line>& lines) {
  constexpr int kHalvings = 24;  // of a line of some radians: to 1e-7 rad
  std::vector<double> rows;
  for (int k = 0; k < kHalvings; ++k) {
    rows.clear();
    for (const Line& line : lines) {
      const Row middle = Between(line.free, line.colliding, 0.5 * (line.low + line.high));
      rows.insert(rows.end(), middle.begin(), middle.end());
    }
    const std::vector<Verdict> verdicts = arm.VerdictsOf(rows);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      double& end = verdicts[i] == Verdict::kCollision ? lines[i].high : lines[i].low;
      end = 0.5 * (lines[i].low + lines[i].high);
    }
  }
}

// A state at a random share of kNextToContact_m from the change of verdict.
Row NextToContact(Arm& arm, const Line& line, std::mt19937_64& random) {
  const double middle = 0.5 * (line.low + line.high);
  const Row at_contact = Between(line.free, line.colliding, middle);
  constexpr double kStep = 1e-4;
  const double speed_m =
      arm.Motion_m(at_contact, Between(line.free, line.colliding, middle + kStep)) / kStep;
  const double share = std::uniform_real_distribution<double>(-1, 1)(random);
  double away = share * kNextToContact_m / std::max(speed_m, kNextToContact_m);
  Row row;
  do {
    row = Between(line.free, line.colliding, std::clamp(middle + away, 0.0, 1.0));
    away *= 0.5;
  } while (arm.Motion_m(at_contact, row) > kNextToContact_m);
  return row;
}

}  // namespace

ContactStates StatesAboutContact(const PandaProblems& all, const PandaProblem& problem,
                                 std::size_t count, std::uint64_t seed) {
  constexpr std::uint64_t kMaxDraws = 16;  // of `count` states each
  std::mt19937_64 random(seed);
  Arm arm(all, problem);
  const std::size_t near_count = count / 4, of_each = (count - near_count) / 2;
  ContactStates states;
  std::vector<Row> free, colliding;
  for (std::uint64_t k = 0; k < kMaxDraws; ++k) {
    if (free.size() >= of_each && colliding.size() >= of_each) break;
    const Row drawn = RandomStates(all, problem, count, random());
    const std::vector<Verdict> verdicts = arm.VerdictsOf(drawn);
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<Row>& like = verdicts[i] == Verdict::kCollision ? colliding : free;
      if (like.size() >= of_each) continue;
      const std::span<const double> row = std::span(drawn).subspan(i * arm.width(), arm.width());
      like.emplace_back(row.begin(), row.end());
    }
  }
  const auto add = [&](const Row& row, bool is_near) {
    states.rows.insert(states.rows.end(), row.begin(), row.end());
    states.is_near.push_back(is_near ? 1 : 0);
  };
  for (const Row& row : free) add(row, false);
  for (const Row& row : colliding) add(row, false);
  if (free.empty() || colliding.empty()) return states;
  std::vector<Line> lines;
  for (std::size_t k = 0; k < near_count; ++k) {
    lines.push_back({.free = free[random() % free.size()],
                     .colliding = colliding[random() % colliding.size()]});
  }
  Bisect(arm, lines);
  for (const Line& line : lines) add(NextToContact(arm, line, random), true);
  return states;
}

}  // namespace cwm::benchmarks
