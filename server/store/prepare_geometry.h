// Prepares the geometry of restored worlds for queries: each distinct one once, on all cores.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_limits.h"
#include "collision/world/world_robot.h"
#include "server/core/memory_budget.h"
#include "server/store/store.h"
#include "server/store/world_fold.h"

namespace cwm::server {

// Calls body(i) for each i in [0, count), on at most `threads` threads, in ranges of `range_size`.
void ParallelFor(std::size_t count, std::size_t range_size, int threads,
                 const std::function<void(std::size_t i)>& body);

// The content that may be missing: what it belongs to is lost. What else is missing is damage.
struct AcceptedLosses {
  bool observed = false;  // blobs that an observed record brought: a power cut takes them
  bool all = false;       // missing and damaged content of every object and robot
};

// Equal models give one geometry, equal meshes one mesh, so that a restored world needs no more
// memory than it did before.
class GeometryPreparation {
 public:
  // `memory` may be null.
  GeometryPreparation(const Store& store, const collision::RobotLimits& robot_limits,
                      const AcceptedLosses& accepted, std::shared_ptr<MemoryBudget> memory)
      : store_(store),
        robot_limits_(robot_limits),
        accepted_(accepted),
        memory_(std::move(memory)) {}

  struct Owner {
    std::string place = {};          // for errors
    MemoryBudget::Payer payer = {};  // charged for as long as anything refers to the geometry
  };
  // Adds a model, which must live until Run has ended. The first owner of equal ones counts.
  void Add(const std::shared_ptr<const FoldedModel>& model, const Owner& owner);
  void AddRobot(const std::string& files_hash, const Owner& owner);

  // Prepares all that was added. `progress` gets the share that is done, from 0 to 1, from any
  // thread, one at a time. DataLoss STORE_DAMAGED for a model or robot that cannot be read, unless
  // the loss is accepted; the errors of Store::GetBlob.
  absl::Status Run(int threads, const std::function<void(double share)>& progress);

  // After Run; nullptr for what is lost.
  std::shared_ptr<const collision::PreparedModel> Find(const FoldedModel& model) const;
  std::shared_ptr<const collision::RobotGeometry> FindRobot(const std::string& files_hash) const;
  std::int64_t count() const { return static_cast<std::int64_t>(tasks_.size()); }

 private:
  struct Task {
    const FoldedModel* model = nullptr;  // nullptr: a robot
    std::string files_hash = {};
    Owner owner = {};
    std::shared_ptr<const collision::PreparedModel> prepared = {};
    std::shared_ptr<const collision::RobotGeometry> robot = {};
    absl::Status status = {};
  };
  class Meshes;

  void Do(Task& task, Meshes& meshes) const;
  void DoRobot(Task& task) const;
  bool IsAcceptedLoss(const absl::Status& status, bool is_observed) const;
  template <class T>
  std::shared_ptr<const T> Charged(std::shared_ptr<const T> geometry, std::int64_t bytes,
                                   const Owner& owner) const;

  const Store& store_;
  const collision::RobotLimits robot_limits_;
  const AcceptedLosses accepted_;
  const std::shared_ptr<MemoryBudget> memory_;
  std::vector<Task> tasks_;
  std::unordered_map<const FoldedModel*, std::size_t> task_of_model_;
  std::unordered_map<std::string, std::size_t> task_of_content_;  // by the message's bytes
  std::unordered_map<std::string, std::size_t> task_of_robot_;    // by the hash of its files
};

}  // namespace cwm::server
