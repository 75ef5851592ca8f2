#include "tests/benchmarks/kdl_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <numbers>
#include <random>

namespace cwm::benchmarks {
namespace {

KDL::Frame FrameOf(const Pose& X) {
  const Matrix3 r = X.linear();
  const Vector3& p = X.translation();
  return {KDL::Rotation(r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1),
                        r(2, 2)),
          KDL::Vector(p.x(), p.y(), p.z())};
}

// The chain's joints turn about z at the ends of their constant transforms.
KDL::Chain ChainOf(const collision::IkChain& chain) {
  KDL::Chain kdl;
  for (std::size_t j = 0; j < chain.joints.size(); ++j) {
    kdl.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), FrameOf(chain.joints[j].X_PJ)));
    const bool is_last = j + 1 == chain.joints.size();
    kdl.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ),
                                is_last ? FrameOf(chain.X_JT) : KDL::Frame::Identity()));
  }
  return kdl;
}

// The weights of position and rotation that our own search has, and the weighted error at which KDL
// stops, small enough for both tolerances.
constexpr double kEpsilon = 1e-6;
Eigen::Matrix<double, 6, 1> Weights() {
  Eigen::Matrix<double, 6, 1> weights;
  weights << 1, 1, 1, 0.4, 0.4, 0.4;
  return weights;
}

}  // namespace

struct KdlSolver::Robot {
  explicit Robot(const collision::IkChain& of)
      : chain(of), kdl(ChainOf(of)), fk(kdl), ik(kdl, Weights(), kEpsilon) {}
  const collision::IkChain& chain;
  KDL::Chain kdl;
  KDL::ChainFkSolverPos_recursive fk;
  KDL::ChainIkSolverPos_LMA ik;
  std::mt19937 random{7};
};

KdlSolver::KdlSolver(const collision::IkChain& chain) : robot_(std::make_unique<Robot>(chain)) {}
KdlSolver::~KdlSolver() = default;

std::vector<double> KdlSolver::Solve(const Pose& X_BT, std::span<const double> seed,
                                     double budget_s) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(budget_s);
  const std::size_t count = robot_->chain.variables.size();
  const KDL::Frame target = FrameOf(X_BT);
  KDL::JntArray start(static_cast<unsigned>(count)), found(static_cast<unsigned>(count));
  for (std::size_t v = 0; v < count; ++v) start(static_cast<unsigned>(v)) = seed[v];
  constexpr double kTolerance = 1e-5;
  do {
    robot_->ik.CartToJnt(start, target, found);
    KDL::Frame reached;
    robot_->fk.JntToCart(found, reached);
    const KDL::Twist error = KDL::diff(reached, target);
    bool is_good = error.vel.Norm() < kTolerance && error.rot.Norm() < kTolerance;
    std::vector<double> row(count);
    for (std::size_t v = 0; v < count; ++v) {
      const collision::IkVariable& variable = robot_->chain.variables[v];
      double value = std::remainder(found(static_cast<unsigned>(v)), 2 * std::numbers::pi);
      if (value < variable.lower) value += 2 * std::numbers::pi;
      if (value > variable.upper) value -= 2 * std::numbers::pi;
      is_good = is_good && value >= variable.lower && value <= variable.upper;
      row[v] = value;
      std::uniform_real_distribution<double> draw(variable.lower, variable.upper);
      start(static_cast<unsigned>(v)) = draw(robot_->random);
    }
    if (is_good) return row;
  } while (Clock::now() < end);
  return {};
}

}  // namespace cwm::benchmarks
