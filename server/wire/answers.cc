#include "server/wire/answers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "server/wire/answer_parts.h"
#include "server/wire/poses.h"
#include "server/wire/scalar_columns.h"

namespace cwm::server {
namespace {

using server::EnumToProto;  // of answer_parts.h, which the functions below would hide

v1::Verdict EnumToProto(collision::Verdict verdict) {
  switch (verdict) {
    case collision::Verdict::kNotComputed:
      return v1::VERDICT_NOT_COMPUTED;
    case collision::Verdict::kFree:
      return v1::VERDICT_FREE;
    case collision::Verdict::kCollision:
      return v1::VERDICT_COLLISION;
    case collision::Verdict::kOutOfLimits:
      return v1::VERDICT_OUT_OF_LIMITS;
    case collision::Verdict::kUndecided:
      return v1::VERDICT_UNDECIDED;
  }
  return v1::VERDICT_UNSPECIFIED;
}

v1::SampleState EnumToProto(collision::SampleState state) {
  switch (state) {
    case collision::SampleState::kSmooth:
      return v1::SAMPLE_STATE_SMOOTH;
    case collision::SampleState::kKink:
      return v1::SAMPLE_STATE_KINK;
    case collision::SampleState::kBeyond:
      return v1::SAMPLE_STATE_BEYOND;
  }
  return v1::SAMPLE_STATE_UNSPECIFIED;
}

v1::MotionVerdict EnumToProto(collision::MotionVerdict verdict) {
  switch (verdict) {
    case collision::MotionVerdict::kNotComputed:
      return v1::MOTION_VERDICT_NOT_COMPUTED;
    case collision::MotionVerdict::kFree:
      return v1::MOTION_VERDICT_FREE;
    case collision::MotionVerdict::kContact:
      return v1::MOTION_VERDICT_CONTACT;
    case collision::MotionVerdict::kGrazing:
      return v1::MOTION_VERDICT_GRAZING;
    case collision::MotionVerdict::kUndecided:
      return v1::MOTION_VERDICT_UNDECIDED;
    case collision::MotionVerdict::kOutOfLimits:
      return v1::MOTION_VERDICT_OUT_OF_LIMITS;
  }
  return v1::MOTION_VERDICT_UNSPECIFIED;
}

template <class Enum>
std::string EnumBytes(const std::vector<Enum>& values) {
  std::string bytes(values.size(), '\0');
  std::transform(values.begin(), values.end(), bytes.begin(),
                 [](Enum value) { return static_cast<char>(EnumToProto(value)); });
  return bytes;
}

template <class Response>
void SetHead(std::size_t completed, const AnswerContext& context, Response* response) {
  response->set_world_uid(context.world_uid);
  response->set_revision(context.revision.value);
  response->set_completed_count(static_cast<std::int64_t>(completed));
}

// Writes the head of a reply and translates indices of the snapshot to indices of its `objects`.
template <class Response>
std::vector<std::int32_t> SetObjects(const std::vector<std::int32_t>& snapshot_indices,
                                     std::size_t completed, const AnswerContext& context,
                                     Response* response) {
  SetHead(completed, context, response);
  return SetObjectRefs(snapshot_indices, context, response);
}

template <class Response>
void SetLinks(const AnswerContext& context, Response* response) {
  for (const std::string& link : context.body.links) response->add_body_links(link);
  for (const std::string& object : context.body.objects) response->add_body_objects(object);
}

// Sets the variables that are out of limits, if any.
template <class Columns, class Response>
void SetVariables(const Columns& answers, const AnswerContext& context, Response* response) {
  if (answers.variable.empty()) return;
  response->set_variable_index(NumberBytes(answers.variable));
  for (const std::string& name : context.body.variables) response->add_variables(name);
}

template <class Columns, class Row>
void SetVariable(const Columns& answers, std::size_t i, const AnswerContext& context, Row* row) {
  if (answers.variable.empty() || answers.variable[i] < 0) return;
  row->set_variable(context.body.variables[static_cast<std::size_t>(answers.variable[i])]);
}

// Sets the derivatives by the joints, if they were asked for.
void SetGradients(const collision::PairColumns& answers, Precision precision,
                  v1::PairColumns* columns) {
  columns->set_joint_gradient(Scalars(answers.joint_gradient, precision));
  columns->set_gradient_kink(NumberBytes(answers.gradient_kink));
}
void SetGradient(const collision::PairColumns& answers, std::size_t i, v1::PairRow* row) {
  if (answers.gradient_kink.empty()) return;
  const std::size_t width = answers.joint_gradient.size() / answers.gradient_kink.size();
  for (std::size_t k = 0; k < width; ++k) {
    row->add_joint_gradient(answers.joint_gradient[i * width + k]);
  }
  row->set_gradient_kink(answers.gradient_kink[i] != 0);
}

template <class Response>
void SetColumns(const collision::PairColumns& answers, const std::vector<std::int32_t>& objects,
                Precision precision, Response* response) {
  v1::PairColumns* columns = response->mutable_columns();
  columns->set_scalar(precision == Precision::kSingle ? v1::SCALAR_F32 : v1::SCALAR_F64);
  columns->set_row_begin(NumberBytes(answers.row_begin));
  columns->set_distance_m(Scalars(answers.distance_m, precision));
  columns->set_point_body(Scalars(answers.point_body, precision));
  columns->set_point_object(Scalars(answers.point_object, precision));
  columns->set_normal(Scalars(answers.normal, precision));
  columns->set_object_index(NumberBytes(objects));
  columns->set_body_part(NumberBytes(answers.body_part));
  columns->set_object_part(NumberBytes(answers.object_part));
  columns->set_trust(EnumBytes(answers.accuracy));
  SetGradients(answers, precision, columns);
  const bool all_exact =
      std::all_of(answers.accuracy.begin(), answers.accuracy.end(),
                  [](auto trust) { return trust == collision::Accuracy::kExact; });
  if (all_exact) return;
  columns->set_bound_m(
      Scalars(Rounded(PairBounds_m(answers), Bound::kUpper, precision), precision));
}

struct PairAt {
  std::int32_t object, body_part, object_part;
};

// Sets the obstacle's name, and the link if it is a robot.
template <class Row>
void SetObstacle(std::int32_t index, std::int32_t part, const AnswerContext& context, Row* row) {
  const collision::Obstacle& met = context.snapshot.ObstacleAt(static_cast<std::size_t>(index));
  row->set_object(met.name);
  row->set_object_part(part);
  if (met.robot == nullptr) return;
  const int link = met.robot->link_of_part[static_cast<std::size_t>(part)];
  row->set_object_link(met.robot->model->links[static_cast<std::size_t>(link)].name);
}

// Sets the names of a row's pair; `row` is any message with these fields. The obstacle is named,
// the robot that is the query's subject is not.
template <class Row>
void SetPair(const PairAt& pair, const AnswerContext& context, Row* row) {
  const auto link_of = [&](std::int32_t part) {
    return context.body.links[static_cast<std::size_t>(part)];
  };
  const auto carried_of = [&](std::int32_t part) {
    return context.body.objects.empty() ? std::string()
                                        : context.body.objects[static_cast<std::size_t>(part)];
  };
  if (IsObjectIndex(pair.object)) SetObstacle(pair.object, pair.object_part, context, row);
  row->set_body_part(pair.body_part);
  row->set_object_part(pair.object_part);
  if (context.body.links.empty()) return;
  row->set_body_link(link_of(pair.body_part));
  if (const std::string name = carried_of(pair.body_part); !name.empty()) {
    row->set_body_object(name);
  }
  if (pair.object != collision::kSelfObject) return;
  row->set_object_link(link_of(pair.object_part));
  if (const std::string name = carried_of(pair.object_part); !name.empty()) row->set_object(name);
}

v1::PairRow PairRowAt(const collision::PairColumns& answers, std::size_t i,
                      const AnswerContext& context) {
  v1::PairRow row;
  row.set_distance_m(answers.distance_m[i]);
  *row.mutable_point_body() = VectorAt(answers.point_body, i);
  *row.mutable_point_object() = VectorAt(answers.point_object, i);
  *row.mutable_normal() = VectorAt(answers.normal, i);
  SetPair({answers.object[i], answers.body_part[i], answers.object_part[i]}, context, &row);
  row.set_trust(EnumToProto(answers.accuracy[i]));
  if (HasBound(answers.accuracy[i])) row.set_bound_m(answers.bound_m[i]);
  SetGradient(answers, i, &row);
  return row;
}

// A row that was not computed has no accuracy.
v1::Trust TrustAt(const collision::CollisionColumns& answers, std::size_t i) {
  const bool is_computed = answers.verdict[i] != collision::Verdict::kNotComputed;
  return is_computed ? EnumToProto(answers.accuracy[i]) : v1::TRUST_UNSPECIFIED;
}

std::string TrustColumn(const collision::CollisionColumns& answers) {
  std::string bytes(answers.accuracy.size(), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(TrustAt(answers, i));
  return bytes;
}

template <class Response>
void SetPairs(const collision::PairColumns& answers, const AnswerContext& context,
              Response* response) {
  const auto objects = SetObjects(answers.object, answers.completed, context, response);
  SetLinks(context, response);
  if (context.form == Form::kColumns) {
    return SetColumns(answers, objects, context.precision, response);
  }
  for (std::size_t row = 0; row < answers.completed; ++row) {
    v1::PairRows* rows = response->add_rows();
    for (std::uint32_t i = answers.row_begin[row]; i < answers.row_begin[row + 1]; ++i) {
      *rows->add_answers() = PairRowAt(answers, i, context);
    }
  }
}

}  // namespace

void DistanceAnswersToProto(const collision::PairColumns& answers, const AnswerContext& context,
                            v1::GetDistancesResponse* response) {
  SetPairs(answers, context, response);
  if (!context.joint_gradients) return;
  for (const std::string& name : context.body.row_variables) response->add_variables(name);
}

void ContactAnswersToProto(const collision::PairColumns& answers, const AnswerContext& context,
                           v1::GetContactsResponse* response) {
  SetPairs(answers, context, response);
}

void CollisionAnswersToProto(const collision::CollisionColumns& answers,
                             const AnswerContext& context, v1::CheckCollisionsResponse* response) {
  // Queries of verdicts only name no pairs: only the pairs that had to be searched for are known.
  const bool named = !context.verdicts_only;
  std::vector<std::int32_t> objects;
  if (named) {
    objects = SetObjects(answers.object, answers.completed, context, response);
    SetLinks(context, response);
  } else {
    SetHead(answers.completed, context, response);
  }
  if (context.form == Form::kColumns) {
    response->set_verdicts(EnumBytes(answers.verdict));
    response->set_trust(TrustColumn(answers));
    if (!named) return;
    response->set_object_index(NumberBytes(objects));
    response->set_body_part(NumberBytes(answers.body_part));
    response->set_object_part(NumberBytes(answers.object_part));
    SetVariables(answers, context, response);
    return;
  }
  for (std::size_t i = 0; i < answers.completed; ++i) {
    v1::CollisionRow* row = response->add_rows();
    row->set_verdict(EnumToProto(answers.verdict[i]));
    row->set_trust(TrustAt(answers, i));
    SetVariable(answers, i, context, row);
    if (!named || answers.object[i] == kNoObject) continue;
    SetPair({answers.object[i], answers.body_part[i], answers.object_part[i]}, context, row);
  }
}

namespace {

void SetRows(const collision::MotionColumns& answers, const AnswerContext& context,
             v1::CheckMotionsResponse* response) {
  for (std::size_t i = 0; i < answers.completed; ++i) {
    v1::MotionRow* row = response->add_rows();
    row->set_verdict(EnumToProto(answers.verdict[i]));
    row->set_trust(EnumToProto(answers.accuracy[i]));
    if (answers.verdict[i] == collision::MotionVerdict::kFree) {
      row->set_clearance_m(answers.clearance_m[i]);
      continue;
    }
    row->set_segment(answers.segment[i]);
    SetVariable(answers, i, context, row);
    if (answers.verdict[i] == collision::MotionVerdict::kOutOfLimits) continue;
    row->set_lo(answers.lo[i]);
    row->set_hi(answers.hi[i]);
    if (answers.object[i] == kNoObject) continue;
    SetPair({answers.object[i], answers.body_part[i], answers.object_part[i]}, context, row);
  }
}

}  // namespace

void MotionAnswersToProto(const collision::MotionColumns& answers, const AnswerContext& context,
                          v1::CheckMotionsResponse* response) {
  const auto objects = SetObjects(answers.object, answers.completed, context, response);
  SetLinks(context, response);
  if (context.form == Form::kRows) return SetRows(answers, context, response);
  const auto scalars = [&](const std::vector<double>& values, Bound bound) {
    return Scalars(Rounded(values, bound, context.precision), context.precision);
  };
  response->set_scalar(context.precision == Precision::kSingle ? v1::SCALAR_F32 : v1::SCALAR_F64);
  response->set_verdicts(EnumBytes(answers.verdict));
  response->set_segment(NumberBytes(answers.segment));
  response->set_lo(scalars(answers.lo, Bound::kLower));
  response->set_hi(scalars(answers.hi, Bound::kUpper));
  response->set_clearance_m(scalars(answers.clearance_m, Bound::kLower));
  response->set_object_index(NumberBytes(objects));
  response->set_body_part(NumberBytes(answers.body_part));
  response->set_object_part(NumberBytes(answers.object_part));
  response->set_trust(EnumBytes(answers.accuracy));
  SetVariables(answers, context, response);
}

namespace {

// An open surface that a ray hits has no outward side.
std::vector<collision::Accuracy> TrustOf(const collision::RayColumns& answers,
                                         const collision::WorldSnapshot& snapshot) {
  std::vector<collision::Accuracy> trust = answers.accuracy;
  for (std::size_t i = 0; i < answers.completed; ++i) {
    if (answers.hit[i] == 0) continue;
    const collision::Obstacle& met =
        snapshot.ObstacleAt(static_cast<std::size_t>(answers.object[i]));
    const Shape& shape =
        met.geometry->parts[static_cast<std::size_t>(answers.object_part[i])].shape;
    const Mesh* const mesh = std::get_if<Mesh>(&shape);
    if (mesh != nullptr && !mesh->watertight) trust[i] = collision::Accuracy::kSurfaceOnly;
  }
  return trust;
}

std::vector<double> BoundColumn(const collision::PointColumns& answers) {
  std::vector<double> bound_m(answers.completed, 0);
  for (const auto& bound : answers.bounds) bound_m[bound.row] = bound.bound_m;
  return bound_m;
}

void SetRows(const collision::PointColumns& answers, const AnswerContext& context,
             v1::SamplePointsResponse* response) {
  const std::vector<double> bound_m = BoundColumn(answers);
  for (std::size_t i = 0; i < answers.completed; ++i) {
    v1::SampleRow* row = response->add_rows();
    row->set_state(EnumToProto(answers.state[i]));
    row->set_trust(EnumToProto(answers.accuracy[i]));
    if (answers.state[i] == collision::SampleState::kBeyond) continue;
    row->set_distance_m(answers.distance_m[i]);
    *row->mutable_gradient() = VectorAt(answers.gradient, i);
    SetObstacle(answers.object[i], answers.object_part[i], context, row);
    if (answers.accuracy[i] == collision::Accuracy::kBounded) row->set_bound_m(bound_m[i]);
  }
}

}  // namespace

void RayAnswersToProto(const collision::RayColumns& answers,
                       std::span<const collision::RayRow> rays, const AnswerContext& context,
                       v1::CastRaysResponse* response) {
  // Rows without a hit name no object, whatever their other columns contain.
  std::vector<std::int32_t> hit_objects = answers.object;
  for (std::size_t i = 0; i < hit_objects.size(); ++i) {
    if (answers.hit[i] == 0) hit_objects[i] = kNoObject;
  }
  const auto objects = SetObjects(hit_objects, answers.completed, context, response);
  const std::vector<collision::Accuracy> trust = TrustOf(answers, context.snapshot);
  if (context.form == Form::kColumns) {
    response->set_scalar(context.precision == Precision::kSingle ? v1::SCALAR_F32 : v1::SCALAR_F64);
    response->set_hit(NumberBytes(answers.hit));
    response->set_distance_m(Scalars(answers.distance_m, context.precision));
    response->set_normal(Scalars(answers.normal, context.precision));
    response->set_object_index(NumberBytes(objects));
    response->set_object_part(NumberBytes(answers.object_part));
    response->set_trust(EnumBytes(trust));
    return;
  }
  for (std::size_t i = 0; i < answers.completed; ++i) {
    v1::RayRow* row = response->add_rows();
    row->set_hit(answers.hit[i] != 0);
    row->set_trust(EnumToProto(trust[i]));
    if (answers.hit[i] == 0) continue;
    row->set_distance_m(answers.distance_m[i]);
    *row->mutable_point() =
        VectorToProto(Vector3(rays[i].origin + answers.distance_m[i] * rays[i].direction));
    *row->mutable_normal() = VectorAt(answers.normal, i);
    SetObstacle(answers.object[i], answers.object_part[i], context, row);
  }
}

void SampleAnswersToProto(const collision::PointColumns& answers, const AnswerContext& context,
                          v1::SamplePointsResponse* response) {
  std::vector<std::int32_t> near_objects = answers.object;
  for (std::size_t i = 0; i < near_objects.size(); ++i) {
    if (answers.state[i] == collision::SampleState::kBeyond) near_objects[i] = kNoObject;
  }
  const auto objects = SetObjects(near_objects, answers.completed, context, response);
  if (context.form == Form::kRows) return SetRows(answers, context, response);
  response->set_scalar(context.precision == Precision::kSingle ? v1::SCALAR_F32 : v1::SCALAR_F64);
  response->set_state(EnumBytes(answers.state));
  response->set_distance_m(Scalars(answers.distance_m, context.precision));
  response->set_gradient(Scalars(answers.gradient, context.precision));
  response->set_object_index(NumberBytes(objects));
  response->set_object_part(NumberBytes(answers.object_part));
  response->set_trust(EnumBytes(answers.accuracy));
  if (answers.bounds.empty()) return;
  response->set_bound_m(
      Scalars(Rounded(BoundColumn(answers), Bound::kUpper, context.precision), context.precision));
}

}  // namespace cwm::server
