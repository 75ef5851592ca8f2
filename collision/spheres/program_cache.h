// Keeps programs that were compiled for a robot for later queries: planners query the same robot,
// from the same base, thousands of times.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Thread safe. Refers to the model.
class ProgramCache {
 public:
  explicit ProgramCache(const RobotModel& model) : model_(model) {}

  // The program that CompileSpheres returns for the model and these arguments, compiled only if it
  // is not kept; nullptr if CompileSpheres returns none.
  std::shared_ptr<const SphereProgram> Find(const JointGroup& group, std::span<const double> base,
                                            const SphereSet& set);

  const RobotModel& model() const { return model_; }

 private:
  struct Entry {
    std::vector<int> variables;  // of the group
    std::vector<double> base;    // with 0 for the group's variables
    std::vector<PlacedSphere> spheres;
    std::vector<FixedFrame> fixed_frames;
    std::vector<SpherePair> sphere_pairs;
    std::vector<SphereLinkPair> link_pairs;
    std::shared_ptr<const SphereProgram> program;
  };
  // chosen: enough for the groups of a robot, with and without attached objects. A program takes 50
  // kB for an arm, and for a robot of spheres twice the size of its list of pairs.
  static constexpr std::size_t kMaxCachedPrograms = 8;

  std::shared_ptr<const SphereProgram> FindCached(const JointGroup& group,
                                                  const std::vector<double>& base,
                                                  const SphereSet& set);

  const RobotModel& model_;
  std::mutex mutex_;
  std::vector<Entry> cached_;  // the most recently used first
};

}  // namespace cwm::collision
