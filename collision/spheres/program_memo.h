// Programs that were compiled for a robot, kept for the next question: planners ask the same robot, from
// the same base, thousands of times.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Thread safe. Refers to the model.
class ProgramMemo {
 public:
  explicit ProgramMemo(const RobotModel& model) : model_(model) {}

  // As CompileSpheres of the model, by everything that it is told; nullptr where that has nothing.
  std::shared_ptr<const SphereProgram> Find(const JointGroup& group, std::span<const double> base,
                                            const SphereSet& set, double pair_margin_m);

  const RobotModel& model() const { return model_; }

 private:
  struct Entry {
    std::vector<int> variables;  // of the group
    std::vector<double> base;    // 0 for those
    std::vector<PlacedSphere> spheres;
    std::vector<HungFrame> hung;
    std::vector<SpherePair> sphere_pairs;
    std::vector<LinkPair> link_pairs;
    double pair_margin_m = 0;
    std::shared_ptr<const SphereProgram> program;
  };
  // A robot's groups, with empty hands and with something in them. 50 kB each of an arm; of a robot
  // of spheres twice the list of its pairs.
  static constexpr std::size_t kMostKept = 8;

  std::shared_ptr<const SphereProgram> Kept(const JointGroup& group,
                                            const std::vector<double>& base, const SphereSet& set,
                                            double pair_margin_m);

  const RobotModel& model_;
  std::mutex mutex_;
  std::vector<Entry> kept_;  // the one that was asked for last first
};

}  // namespace cwm::collision
