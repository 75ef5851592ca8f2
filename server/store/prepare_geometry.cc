#include "server/store/prepare_geometry.h"

#include <algorithm>
#include <limits>
#include <mutex>
#include <numeric>
#include <stop_token>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/thread_pool/thread_pool.h"
#include "proto/transfer/sha256.h"
#include "server/core/approximate_bytes.h"
#include "server/core/error.h"
#include "server/core/load_robot.h"
#include "server/store/decode_fault.h"
#include "server/store/decode_values.h"
#include "server/store/keep_blobs.h"

namespace cwm::server {

void ParallelFor(std::size_t count, std::size_t range_size, int threads,
                 const std::function<void(std::size_t i)>& body) {
  const std::function<int()> may_run = [threads] { return threads; };
  const ParallelLoop::Body ranges = [&body](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  };
  ParallelLoop(count, range_size, may_run, ranges).Run();
}

namespace {

// True if content is missing, or is not as it was written.
bool IsLoss(const absl::Status& status) {
  return absl::IsNotFound(status) || absl::IsDataLoss(status);
}

}  // namespace

// The meshes of the models, each once. Thread safe.
class GeometryPreparation::Meshes {
 public:
  explicit Meshes(const Store& store) : store_(store) {}

  absl::StatusOr<std::shared_ptr<const TriangleMesh>> ContentOf(const store::v1::Mesh& mesh) {
    const std::string hash = mesh.has_blob() ? mesh.blob().sha256() : Sha256Hex(mesh.mesh_f64());
    {
      std::lock_guard lock(mutex_);
      const auto found = by_hash_.find(hash);
      if (found != by_hash_.end()) return found->second;
    }
    auto decoded = mesh.has_blob() ? ReadBlob(hash) : DecodeContent(mesh.mesh_f64());
    if (!decoded.ok()) return decoded;
    std::lock_guard lock(mutex_);
    return by_hash_.emplace(hash, *std::move(decoded)).first->second;
  }

 private:
  absl::StatusOr<std::shared_ptr<const TriangleMesh>> ReadBlob(const std::string& hash) const {
    const absl::StatusOr<std::string> bytes = store_.GetBlob(hash);
    return bytes.ok() ? DecodeContent(*bytes) : bytes.status();
  }

  const Store& store_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::shared_ptr<const TriangleMesh>> by_hash_;
};

void GeometryPreparation::Add(const std::shared_ptr<const FoldedModel>& model, const Owner& owner) {
  if (task_of_model_.contains(model.get())) return;
  // The record that brought the model decides whether a missing blob is an error.
  std::string content = model->model.SerializeAsString();
  content.push_back(model->observed ? '\1' : '\0');
  const auto [known, is_new] = task_of_content_.emplace(std::move(content), tasks_.size());
  if (is_new) {
    tasks_.emplace_back();
    tasks_.back().model = model.get();
    tasks_.back().owner = owner;
  }
  task_of_model_.emplace(model.get(), known->second);
}

void GeometryPreparation::AddRobot(const std::string& files_hash, const Owner& owner) {
  if (!task_of_robot_.emplace(files_hash, tasks_.size()).second) return;
  tasks_.emplace_back();
  tasks_.back().files_hash = files_hash;
  tasks_.back().owner = owner;
}

bool GeometryPreparation::IsAcceptedLoss(const absl::Status& status, bool is_observed) const {
  if (accepted_.all) return IsLoss(status);
  return accepted_.observed && is_observed && absl::IsNotFound(status);
}

void GeometryPreparation::DoRobot(Task& task) const {
  absl::StatusOr<RobotFiles> files = ReadRobotFiles(store_, task.files_hash);
  if (IsAcceptedLoss(files.status(), false)) return;
  task.status = files.status();
  if (!files.ok()) return;
  auto robot = ReadRobot(*std::move(files), robot_limits_, std::stop_token());
  task.status = robot.status();
  if (!robot.ok()) return;
  const std::int64_t bytes = ApproximateBytes(**robot);
  task.robot = Charged(*std::move(robot), bytes, task.owner);
}

void GeometryPreparation::Do(Task& task, Meshes& meshes) const {
  if (task.model == nullptr) return DoRobot(task);
  const auto model = DecodeModel(
      task.model->model, [&](const store::v1::Mesh& mesh) { return meshes.ContentOf(mesh); });
  const bool is_lost = IsAcceptedLoss(model.status(), task.model->observed);
  task.status = is_lost ? absl::OkStatus() : model.status();
  if (!model.ok()) return;
  collision::PutObject put;
  put.geometry = collision::Prepare(*model);
  task.prepared = Charged(put.geometry, ApproximateBytes(put), task.owner);
}

// A world that was there before is there again, however little memory is left.
template <class T>
std::shared_ptr<const T> GeometryPreparation::Charged(std::shared_ptr<const T> geometry,
                                                      std::int64_t bytes,
                                                      const Owner& owner) const {
  if (memory_ == nullptr) return geometry;
  MemoryCharge charge = MemoryCharge::Empty(memory_, owner.payer);
  charge.ForceResize(bytes);
  return WithCharge(std::move(geometry), std::move(charge));
}

absl::Status GeometryPreparation::Run(int threads,
                                      const std::function<void(double share)>& progress) {
  task_of_content_.clear();  // frees the messages' bytes
  // The largest first, robots before all, so that no core waits for another's large one at the end.
  std::vector<std::size_t> order(tasks_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater<>(), [&](std::size_t i) {
    const FoldedModel* const model = tasks_[i].model;
    return model == nullptr ? std::numeric_limits<std::int64_t>::max() : model->prepared_bytes;
  });
  Meshes meshes(store_);
  std::mutex mutex;
  std::size_t done = 0;
  ParallelFor(order.size(), 1, threads, [&](std::size_t i) {
    Do(tasks_[order[i]], meshes);
    std::lock_guard lock(mutex);
    ++done;
    if (progress) progress(static_cast<double>(done) / static_cast<double>(order.size()));
  });
  for (const Task& task : tasks_) {
    if (task.status.ok()) continue;
    if (absl::IsUnavailable(task.status)) return task.status;
    constexpr char kWhatToDo[] =
        "; restore a backup into another directory, or accept the loss (--store-accept-loss)";
    return Damaged(task.owner.place, absl::StrCat(std::string(task.status.message()),
                                                  IsLoss(task.status) ? kWhatToDo : ""));
  }
  return absl::OkStatus();
}

std::shared_ptr<const collision::PreparedModel> GeometryPreparation::Find(
    const FoldedModel& model) const {
  const auto found = task_of_model_.find(&model);
  return found == task_of_model_.end() ? nullptr : tasks_[found->second].prepared;
}

std::shared_ptr<const collision::RobotGeometry> GeometryPreparation::FindRobot(
    const std::string& files_hash) const {
  const auto found = task_of_robot_.find(files_hash);
  return found == task_of_robot_.end() ? nullptr : tasks_[found->second].robot;
}

}  // namespace cwm::server
