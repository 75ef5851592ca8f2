// A point in the plane, with x and y from -1 to 1, among discs, so that free space has a closed
// form.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "clients/planner/joint_space.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

struct Disc {
  double x, y, radius;
};

class FlatWorld : public StateChecker {
 public:
  explicit FlatWorld(std::vector<Disc> discs) : discs_(std::move(discs)) {}

  // The distance from the nearest disc; negative inside.
  double Clearance(double x, double y) const {
    double min_clearance = std::numeric_limits<double>::infinity();
    for (const Disc& disc : discs_) {
      min_clearance = std::min(min_clearance, std::hypot(x - disc.x, y - disc.y) - disc.radius);
    }
    return min_clearance;
  }

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Evaluate(std::span<const double> rows,
                                                     std::size_t width) override {
    std::vector<std::uint8_t> free;
    for (std::size_t k = 0; k < rows.size(); k += width) {
      free.push_back(Clearance(rows[k], rows[k + 1]) >= 0 ? 1 : 0);
    }
    return free;
  }

  std::vector<Disc> discs_;
};

inline std::vector<Joint> Flat() {
  return {{.name = "x", .kind = Joint::Kind::kLimited, .lower = -1, .upper = 1},
          {.name = "y", .kind = Joint::Kind::kLimited, .lower = -1, .upper = 1}};
}

// The smallest clearance along the path, in steps of 1e-4.
inline double MinClearance(const FlatWorld& world, const std::vector<Row>& path) {
  double min_clearance = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < path.size(); ++k) {
    const Row &a = path[k - 1], &b = path[k];
    const int steps = 1 + static_cast<int>(std::hypot(b[0] - a[0], b[1] - a[1]) / 1e-4);
    for (int i = 0; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      min_clearance = std::min(min_clearance,
                               world.Clearance(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])));
    }
  }
  return min_clearance;
}

// The largest depth of a line between two free states `step` apart in a disc of `radius`: its
// sagitta.
inline double MaxDepthBetween(double step, double radius) {
  return radius - std::sqrt(radius * radius - step * step / 4);
}

}  // namespace cwm::planner
