#include "clients/cli/bench/temporary_world.h"

#include <unistd.h>

#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "clients/cli/bench/bench_poses.h"
#include "clients/cli/number_list.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

constexpr int kObjects = 30;

pb::ShapePart SomeShape(int i, Random& random) {
  const auto size_m = [&] { return random.Uniform(0.04, 0.2); };
  const double a = size_m(), b = size_m(), c = size_m();
  pb::ShapePart part;
  switch (i % 4) {
    case 0:
      part.mutable_box()->set_size_x_m(a);
      part.mutable_box()->set_size_y_m(b);
      part.mutable_box()->set_size_z_m(c);
      break;
    case 1:
      part.mutable_cylinder()->set_radius_m(a / 2);
      part.mutable_cylinder()->set_length_m(b);
      break;
    case 2:
      part.mutable_sphere()->set_radius_m(a / 2);
      break;
    default:
      part.mutable_capsule()->set_radius_m(a / 4);
      part.mutable_capsule()->set_length_m(b);
      break;
  }
  return part;
}

// Deletes the world; without a uid, whichever has the name.
absl::Status Delete(const client::Connection& connection, const std::string& name,
                    const std::string& uid) {
  pb::DeleteWorldRequest request;
  request.set_world(name);
  request.set_world_uid(uid);
  return connection.Call(&pb::WorldService::Stub::DeleteWorld, connection.worlds(), request)
      .status();
}

}  // namespace

std::string TemporaryWorldName() {
  std::random_device device;
  return absl::StrCat("cwm-bench-", ::getpid(), "-", absl::Hex(device(), absl::kZeroPad8));
}

std::vector<pb::Change> BenchScene() {
  Random random(42);
  std::vector<pb::Change> changes;
  for (int i = 0; i < kObjects; ++i) {
    pb::Object& object = *changes.emplace_back().mutable_put()->mutable_object();
    object.set_name(absl::StrCat("bench_", i));
    *object.mutable_x_world_object() = PoseToProto(random.RandomPose(kBenchRegion));
    *object.add_shapes() = SomeShape(i, random);
  }
  return changes;
}

absl::StatusOr<std::unique_ptr<TemporaryWorld>> TemporaryWorld::Make(
    const client::Connection& connection, const std::string& name,
    const std::vector<pb::Change>& changes) {
  pb::ApplyChangesRequest request;
  request.set_world(name);
  request.mutable_changes()->Add(changes.begin(), changes.end());
  const auto made =
      connection.Call(&pb::WorldService::Stub::ApplyChanges, connection.worlds(), request);
  if (!made.ok()) {
    // After a deadline the world may exist nevertheless, under a name that nobody else uses.
    static_cast<void>(
        Delete(client::Connection({.address = connection.address(), .deadline = {}}), name, ""));
    return made.status();
  }
  return std::unique_ptr<TemporaryWorld>(new TemporaryWorld(connection, name, made->world_uid()));
}

TemporaryWorld::~TemporaryWorld() {
  // A caller who wants the error has called Remove before.
  static_cast<void>(Remove());
}

absl::Status TemporaryWorld::Remove() {
  if (uid_.empty()) return absl::OkStatus();
  const std::string uid = std::exchange(uid_, "");
  absl::Status removed = Delete(connection_, name_, uid);
  return absl::IsNotFound(removed) ? absl::OkStatus() : removed;
}

}  // namespace cwm::cli
