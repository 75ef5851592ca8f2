// Contacts of a world; declared in answers.h.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "server/wire/answer_parts.h"
#include "server/wire/scalar_columns.h"

namespace cwm::server {
namespace {

std::string TrustBytes(const std::vector<collision::Accuracy>& accuracy) {
  std::string bytes;
  for (const collision::Accuracy each : accuracy) {
    bytes.push_back(static_cast<char>(EnumToProto(each)));
  }
  return bytes;
}

// The link of a robot's part; nullptr for an object.
const std::string* LinkOfPart(const collision::Obstacle& obstacle, std::int32_t part) {
  if (obstacle.robot == nullptr) return nullptr;
  const int link = obstacle.robot->link_of_part[static_cast<std::size_t>(part)];
  return &obstacle.robot->model->links[static_cast<std::size_t>(link)].name;
}

void SetContactRows(const collision::WorldContactColumns& answers, const AnswerContext& context,
                    v1::GetWorldContactsResponse* response) {
  for (std::size_t i = 0; i < answers.distance_m.size(); ++i) {
    const auto obstacle = [&](std::int32_t index) -> const collision::Obstacle& {
      return context.snapshot.ObstacleAt(static_cast<std::size_t>(index));
    };
    const collision::Obstacle &a = obstacle(answers.object_a[i]),
                              &b = obstacle(answers.object_b[i]);
    v1::WorldContactRow* const row = response->add_rows();
    row->set_object_a(a.name);
    row->set_object_b(b.name);
    row->set_part_a(answers.part_a[i]);
    row->set_part_b(answers.part_b[i]);
    if (const std::string* link = LinkOfPart(a, answers.part_a[i])) row->set_link_a(*link);
    if (const std::string* link = LinkOfPart(b, answers.part_b[i])) row->set_link_b(*link);
    row->set_distance_m(answers.distance_m[i]);
    *row->mutable_point_a() = VectorAt(answers.point_a, i);
    *row->mutable_point_b() = VectorAt(answers.point_b, i);
    *row->mutable_normal() = VectorAt(answers.normal, i);
    row->set_trust(EnumToProto(answers.accuracy[i]));
    if (HasBound(answers.accuracy[i])) row->set_bound_m(answers.bound_m[i]);
  }
}

}  // namespace

void WorldContactAnswersToProto(const collision::WorldContactColumns& answers,
                                const AnswerContext& context,
                                v1::GetWorldContactsResponse* response) {
  response->set_world_uid(context.world_uid);
  response->set_revision(context.revision.value);
  response->set_is_complete(answers.is_complete);
  std::vector<std::int32_t> both = answers.object_a;
  both.insert(both.end(), answers.object_b.begin(), answers.object_b.end());
  const std::vector<std::int32_t> objects = SetObjectRefs(both, context, response);
  if (context.form == Form::kRows) return SetContactRows(answers, context, response);
  const auto middle = objects.begin() + static_cast<std::ptrdiff_t>(answers.object_a.size());
  const Precision precision = context.precision;
  response->set_scalar(precision == Precision::kSingle ? v1::SCALAR_F32 : v1::SCALAR_F64);
  response->set_object_a(NumberBytes(std::vector<std::int32_t>(objects.begin(), middle)));
  response->set_object_b(NumberBytes(std::vector<std::int32_t>(middle, objects.end())));
  response->set_part_a(NumberBytes(answers.part_a));
  response->set_part_b(NumberBytes(answers.part_b));
  response->set_distance_m(Scalars(answers.distance_m, precision));
  response->set_point_a(Scalars(answers.point_a, precision));
  response->set_point_b(Scalars(answers.point_b, precision));
  response->set_normal(Scalars(answers.normal, precision));
  response->set_trust(TrustBytes(answers.accuracy));
  const auto is_exact = [](auto trust) { return trust == collision::Accuracy::kExact; };
  if (std::ranges::all_of(answers.accuracy, is_exact)) return;
  response->set_bound_m(
      Scalars(Rounded(PairBounds_m(answers), Bound::kUpper, precision), precision));
}

}  // namespace cwm::server
