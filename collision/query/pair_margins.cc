#include "collision/query/pair_margins.h"

#include <algorithm>

#include "collision/world/world_robot.h"

namespace cwm::collision {

double PairMargins::OwnMargin_m(int frame) const {
  const AttachedObject* const attached = body_.AttachedIn(frame);
  return attached != nullptr ? attached->object->margin_m : body_.margin_m;
}

bool PairMargins::IsSupportOf(int frame, const std::string& name) const {
  const AttachedObject* const attached = body_.AttachedIn(frame);
  const std::string& supported_by =
      attached != nullptr ? attached->object->supported_by : body_.supported_by;
  return !supported_by.empty() && supported_by == name;
}

double PairMargins::Of(int frame, const Obstacle& object, std::size_t part) const {
  if (IsSupportOf(frame, object.name)) return -support_tolerance_m_;
  // A robot has no paddings against what it carries.
  const bool carries_body = body_.attachment != nullptr && body_.attachment->robot == object.name;
  const double their_margin_m = carries_body ? object.margin_m : MarginOf_m(object, part);
  return their_margin_m + OwnMargin_m(frame) + body_.PaddingOf_m(frame) + request_m_;
}

double PairMargins::OfSelfPair(int first, int second) const {
  const AttachedObject* const on_first = body_.AttachedIn(first);
  const AttachedObject* const on_second = body_.AttachedIn(second);
  const auto of_object = [&](int frame, const WorldObject& other) {
    if (IsSupportOf(frame, other.name)) return -support_tolerance_m_;
    return other.margin_m + OwnMargin_m(frame) + request_m_;
  };
  if (on_first == nullptr && on_second == nullptr) return request_m_;
  if (on_first == nullptr) return OwnMargin_m(second) + request_m_;
  if (on_second == nullptr) return OwnMargin_m(first) + request_m_;
  return std::min(of_object(first, *on_second->object), of_object(second, *on_first->object));
}

double PairMargins::MaxOf(const WorldSnapshot& world) const {
  double own_m = body_.margin_m + body_.MaxPadding_m();
  for (const AttachedObject& attached : body_.attached) {
    own_m = std::max(own_m, attached.object->margin_m);
  }
  return std::max(0.0, world.max_margin_m() + own_m + request_m_);
}

}  // namespace cwm::collision
