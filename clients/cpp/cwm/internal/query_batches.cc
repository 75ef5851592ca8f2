#include "cwm/internal/query_batches.h"

#include <cstring>
#include <numeric>
#include <span>
#include <variant>

#include "absl/strings/str_cat.h"
#include "clients/cpp/geometry_transfer.h"

namespace cwm::CWM_API::internal {
namespace {

// chosen: the bytes of a message that are reserved for everything but rows.
constexpr std::int64_t kHeadBytes = 1 << 16;
constexpr std::size_t kPointWidth = 3;

std::vector<double> PoseRows(std::span<const Eigen::Isometry3d> poses, const std::string& name) {
  std::vector<double> numbers;
  numbers.reserve(poses.size() * kPoseWidth);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto row = PoseNumbers(poses[i], absl::StrCat(name, "[", i, "]"));
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  return numbers;
}

template <class Matrix>
std::vector<double> NumbersOf(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.size()};
}

// The rows of the subject; nullptr for points, which are rows themselves.
std::string& RowData(v1::Subject& subject) {
  switch (subject.what_case()) {
    case v1::Subject::kRobot:
      return *subject.mutable_robot()->mutable_rows()->mutable_data();
    case v1::Subject::kObject:
      return *subject.mutable_object()->mutable_x_world_object()->mutable_data();
    case v1::Subject::kPoints:
      return *subject.mutable_points()->mutable_data();
    default:
      return *subject.mutable_shapes()->mutable_x_world_body()->mutable_data();
  }
}

// Rows of poses; none: a single one, which the server or `absent` gives.
Batches BatchesOfPoses(const Rows& rows, const Eigen::Isometry3d* absent, const std::string& name) {
  if (const auto* poses = std::get_if<std::span<const Eigen::Isometry3d>>(&rows.what())) {
    return BatchesOfRows(PoseRows(*poses, name), kPoseWidth);
  }
  if (std::holds_alternative<Eigen::MatrixXd>(rows.what())) {
    ThrowBadArgument(name, "are numbers, must be poses, since the subject is no robot");
  }
  if (absent == nullptr) return {};
  return BatchesOfRows(PoseRows({absent, 1}, name), kPoseWidth);
}

BoundSubject BindBody(const Body& body, const Rows& rows, const std::string& name) {
  BoundSubject bound;
  if (body.parts().empty()) ThrowBadArgument("subject", "has no shape, must have at least one");
  v1::Subject::Shapes& shapes = *bound.message.mutable_shapes();
  for (std::size_t i = 0; i < body.parts().size(); ++i) {
    v1::PlacedShape& placed = *shapes.add_shapes();
    *placed.mutable_x_body_shape() =
        ToMessage(body.parts()[i].X_BS, absl::StrCat("subject.parts[", i, "].X_BS"));
    SetShape(body.parts()[i].shape, placed, bound.meshes);
  }
  const Eigen::Isometry3d identity = Eigen::Isometry3d::Identity();
  bound.batches = BatchesOfPoses(rows, &identity, name);
  return bound;
}

BoundSubject BindObject(const std::string& object, const Rows& rows, const std::string& name) {
  BoundSubject bound;
  bound.message.mutable_object()->set_name(object);
  bound.batches = BatchesOfPoses(rows, nullptr, name);
  return bound;
}

BoundSubject BindPoints(const Points& points, const Rows& rows, const std::string& name) {
  if (!std::holds_alternative<std::monostate>(rows.what())) {
    ThrowBadArgument(name, "are given, must be absent, since the subject is points");
  }
  BoundSubject bound;
  bound.message.mutable_points();
  bound.batches = BatchesOfRows(NumbersOf(points.points), kPointWidth);
  return bound;
}

}  // namespace

absl::StatusOr<v1::GetLinkPosesResponse> Ask(const View& view, v1::GetLinkPosesRequest& request) {
  return Repeat(view, [&](const client::Connection& connection) {
    return connection.Call(&v1::RobotService::Stub::GetLinkPoses, connection.robots(), request);
  });
}

void SendMeshes(const View& view, const std::vector<MeshBlob>& meshes, bool again) {
  for (const MeshBlob& mesh : meshes) {
    {
      const std::lock_guard lock(view.session->mutex);
      if (!again && view.session->sent_meshes.contains(mesh.hash)) continue;
    }
    RepeatOrThrow(view, [&](const client::Connection& connection) {
      return client::WriteGeometry(connection, {.bytes = mesh.bytes});
    });
    const std::lock_guard lock(view.session->mutex);
    view.session->sent_meshes.insert(mesh.hash);
  }
}

std::string Batches::Bytes(std::int64_t first_unit, std::int64_t end_unit) const {
  if (numbers.empty()) return {};
  const auto begin = static_cast<std::size_t>(unit_begin[static_cast<std::size_t>(first_unit)]);
  const auto end = static_cast<std::size_t>(unit_begin[static_cast<std::size_t>(end_unit)]);
  return {reinterpret_cast<const char*>(numbers.data() + begin * width),
          (end - begin) * width * sizeof(double)};
}

Batches BatchesOfRows(std::vector<double> numbers, std::size_t width) {
  Batches batches{.numbers = std::move(numbers), .width = width};
  batches.unit_begin.resize(width == 0 ? 1 : batches.numbers.size() / width + 1);
  std::iota(batches.unit_begin.begin(), batches.unit_begin.end(), 0);
  return batches;
}

v1::QueryOptions OptionsOf(const View& view, const QueryOptions& options,
                           std::vector<MeshBlob>& meshes) {
  v1::QueryOptions message;
  message.set_margin_m(options.margin_m);
  if (options.max_distance_m) message.set_max_distance_m(*options.max_distance_m);
  message.set_max_results(options.max_results);
  message.set_max_contacts(options.max_contacts);
  message.set_verdicts_only(options.verdicts_only);
  for (const NamedThing& thing : options.only) *message.add_only() = ToMessage(thing);
  message.mutable_ignore()->Assign(options.ignore.begin(), options.ignore.end());
  for (const auto& [a, b] : options.ignore_pairs) *message.add_ignore_pairs() = ToMessage(a, b);
  for (std::size_t i = 0; i < view.supposed.size(); ++i) {
    *message.add_overlay() =
        ToMessage(view.supposed[i], absl::StrCat("WhatIf.changes[", i, "]"), meshes);
  }
  for (std::size_t i = 0; i < options.overlay.size(); ++i) {
    *message.add_overlay() =
        ToMessage(options.overlay[i], absl::StrCat("options.overlay[", i, "]"), meshes);
  }
  message.set_engine(static_cast<v1::Engine>(options.engine));
  message.set_representation(static_cast<v1::Representation>(options.representation));
  message.set_unseen(static_cast<v1::UnseenSpace>(options.unseen));
  message.set_margin_sigma(options.margin_sigma);
  if (options.support_tolerance_m) message.set_support_tolerance_m(*options.support_tolerance_m);
  if (options.time_budget_s) {
    *message.mutable_time_budget() = DurationFrom(*options.time_budget_s, "options.time_budget_s");
  }
  message.set_scalar(v1::SCALAR_F64);
  return message;
}

std::int64_t EndOfBatch(const View& view, const Batches& batches, std::int64_t first,
                        std::size_t head_bytes) {
  const v1::Limits& limits = view.session->limits;
  const auto row_bytes =
      static_cast<std::int64_t>(std::max<std::size_t>(1, batches.width * sizeof(double)));
  const std::int64_t free_bytes =
      limits.max_message_bytes() - kHeadBytes - static_cast<std::int64_t>(head_bytes);
  const std::int64_t max_rows =
      std::max<std::int64_t>(1, std::min({limits.max_batch_rows(), free_bytes / row_bytes,
                                          limits.max_answers() / batches.answers_per_unit}));
  const auto begin = batches.unit_begin.begin();
  const auto end = std::upper_bound(begin + first, batches.unit_begin.end(),
                                    batches.unit_begin[static_cast<std::size_t>(first)] + max_rows);
  return std::max<std::int64_t>(first + 1, end - begin - 1);  // the server refuses a longer unit
}

void BoundSubject::Fill(std::int64_t first_unit, std::int64_t end_unit,
                        v1::Subject& subject) const {
  subject = message;
  if (!batches.numbers.empty()) RowData(subject) = batches.Bytes(first_unit, end_unit);
}

BoundSubject Bind(const RobotSubject& robot, const Rows& rows, const std::string& name) {
  BoundSubject bound;
  v1::RobotSubject& message = *bound.message.mutable_robot();
  message.set_robot(robot.robot);
  message.set_group(robot.group);
  message.set_scope(static_cast<v1::RobotScope>(robot.scope));
  message.set_robot_geometry(static_cast<v1::RobotGeometry>(robot.geometry));
  if (robot.X_WB) *message.mutable_x_world_base() = ToMessage(*robot.X_WB, "robot.X_WB");
  *message.mutable_base_state() = ToMessage(robot.base_state);
  for (const LinkPadding& padding : robot.link_padding) {
    *message.add_link_padding() = ToMessage(padding);
  }
  if (std::holds_alternative<std::span<const Eigen::Isometry3d>>(rows.what())) {
    ThrowBadArgument(name,
                     "are poses, must be joint values in columns, since the subject is a "
                     "robot; RobotSubject::X_WB is its base");
  }
  if (const auto* states = std::get_if<Eigen::MatrixXd>(&rows.what())) {
    if (states->rows() == 0) ThrowBadArgument(name, "have no number, must have one per joint");
    message.mutable_rows()->set_width(static_cast<std::int32_t>(states->rows()));
    bound.batches = BatchesOfRows(NumbersOf(*states), static_cast<std::size_t>(states->rows()));
  }
  return bound;
}

BoundSubject Bind(const Subject& subject, const Rows& rows, const std::string& name) {
  if (const auto* robot = std::get_if<RobotSubject>(&subject.what())) {
    return Bind(*robot, rows, name);
  }
  if (const auto* object = std::get_if<std::string>(&subject.what())) {
    return BindObject(*object, rows, name);
  }
  if (const auto* points = std::get_if<Points>(&subject.what())) {
    return BindPoints(*points, rows, name);
  }
  return BindBody(std::get<Body>(subject.what()), rows, name);
}

}  // namespace cwm::CWM_API::internal
