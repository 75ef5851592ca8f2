#include "server/wire/pair_rules.h"

#include <chrono>

#include "collision/world/apply_fault.h"
#include "server/wire/numbers.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

constexpr std::chrono::hours kMaxAllowanceTime{24 * 366};

collision::NamedThing NamedThingFromProto(const v1::NamedThing& thing) {
  return {thing.name(), thing.link()};
}

v1::NamedThing NamedThingToProto(const collision::NamedThing& thing) {
  v1::NamedThing proto;
  proto.set_name(thing.name);
  proto.set_link(thing.link);
  return proto;
}

}  // namespace

absl::StatusOr<collision::NamedPair> NamedPairFromProto(const v1::NamedPair& pair,
                                                        const FieldPath& path) {
  collision::NamedPair result{NamedThingFromProto(pair.a()), NamedThingFromProto(pair.b())};
  const absl::Status status = CheckPair(result);
  if (status.ok()) return result;
  const auto fault = collision::FieldRuleOf(status);
  return fault.has_value() ? path.Field(fault->field).Error(fault->rule) : status;
}

absl::StatusOr<collision::AllowCollision> AllowCollisionFromProto(const v1::AllowCollision& allow,
                                                                  const FieldPath& path) {
  auto pair = NamedPairFromProto(allow.pair(), path.Field("pair"));
  if (!pair.ok()) return pair.status();
  collision::AllowCollision result{.pair = *std::move(pair), .withdraw = allow.withdraw()};
  result.check = allow.check();
  if (allow.check() && allow.withdraw()) {
    return path.Field("check").Error("is true, must be false: what is withdrawn is not checked");
  }
  if (!allow.has_expires_after()) return result;
  const FieldPath field = path.Field("expires_after");
  if (allow.check()) {
    return field.Error("is given, must be absent: a check lasts until it is withdrawn");
  }
  if (allow.withdraw()) {
    return field.Error("is given, must be absent: what is withdrawn cannot expire");
  }
  const auto after = DurationFromProto(allow.expires_after(), field, kMaxAllowanceTime);
  if (!after.ok()) return after.status();
  result.expires = collision::ExpiryAfter(*after);
  return result;
}

absl::StatusOr<collision::SetPairMargin> SetPairMarginFromProto(const v1::SetPairMargin& set,
                                                                const FieldPath& path) {
  auto pair = NamedPairFromProto(set.pair(), path.Field("pair"));
  if (!pair.ok()) return pair.status();
  collision::SetPairMargin result{.pair = *std::move(pair), .margin_m = {}};
  if (!set.has_margin_m()) return result;
  if (auto status = CheckLength(set.margin_m(), path.Field("margin_m")); !status.ok()) {
    return status;
  }
  result.margin_m = set.margin_m();
  return result;
}

v1::PairRule PairRuleToProto(const collision::PairRule& rule) {
  v1::PairRule proto;
  *proto.mutable_pair()->mutable_a() = NamedThingToProto(rule.pair.a);
  *proto.mutable_pair()->mutable_b() = NamedThingToProto(rule.pair.b);
  proto.set_allowed(rule.allowed);
  if (rule.expires.has_value())
    *proto.mutable_expires() = TimePointToProto(rule.expires->wall_time);
  if (rule.margin_m.has_value()) proto.set_margin_m(*rule.margin_m);
  proto.set_check(rule.check);
  return proto;
}

}  // namespace cwm::server
