#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/robot/kinematics_lanes.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/robot/kinematics.h"
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
constexpr std::size_t kMaxLanes = 8;
using Tag = hn::CappedTag<double, kMaxLanes>;
using Lane = hn::Vec<Tag>;
constexpr Tag kTag;
constexpr std::size_t kNumbers = 12;  // per frame: row-major 3 x 4, the fourth column is the origin

Lane All(double value) { return hn::Set(kTag, value); }

struct Turn {
  Lane of[9];  // row-major
};

// Rodrigues' formula.
Turn TurnAbout(const Vector3& axis, Lane sine, Lane cosine) {
  const Lane rest = hn::Sub(All(1), cosine);
  Turn turn;
  for (int at = 0; at < 9; ++at) turn.of[at] = hn::Mul(rest, All(axis[at / 3] * axis[at % 3]));
  for (int at : {0, 4, 8}) turn.of[at] = hn::Add(turn.of[at], cosine);
  const auto cross = [&](int at, double part)
                         HWY_ATTR { turn.of[at] = hn::MulAdd(sine, All(part), turn.of[at]); };
  cross(1, -axis.z()), cross(2, axis.y()), cross(5, -axis.x());
  cross(3, axis.z()), cross(6, -axis.y()), cross(7, axis.x());
  return turn;
}

struct Frame {
  Lane of[kNumbers];

  static Frame OfAll(const Pose& X_WB) {
    Frame frame;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column)
        frame.of[4 * row + column] = All(X_WB(row, column));
    }
    return frame;
  }
  static Frame Read(const double* from) {
    Frame frame;
    for (std::size_t k = 0; k < kNumbers; ++k) frame.of[k] = hn::LoadU(kTag, from + k * kMaxLanes);
    return frame;
  }
  void Write(double* to) const {
    for (std::size_t k = 0; k < kNumbers; ++k) hn::StoreU(of[k], kTag, to + k * kMaxLanes);
  }

  Frame Times(const Pose& X) const {
    Frame out;
    for (int row = 0; row < 12; row += 4) {
      for (int column = 0; column < 4; ++column) {
        const Lane start = column == 3 ? of[row + 3] : hn::Zero(kTag);
        out.of[row + column] =
            hn::MulAdd(of[row], All(X(0, column)),
                       hn::MulAdd(of[row + 1], All(X(1, column)),
                                  hn::MulAdd(of[row + 2], All(X(2, column)), start)));
      }
    }
    return out;
  }

  void Slide(const Vector3& axis, Lane by) {
    for (int row = 0; row < 12; row += 4) {
      const Lane along =
          hn::MulAdd(of[row], All(axis.x()),
                     hn::MulAdd(of[row + 1], All(axis.y()), hn::Mul(of[row + 2], All(axis.z()))));
      of[row + 3] = hn::MulAdd(along, by, of[row + 3]);
    }
  }

  void TurnAboutZ(Lane sine, Lane cosine) {
    for (int row = 0; row < 12; row += 4) {
      const Lane x = of[row], y = of[row + 1];
      of[row] = hn::MulAdd(x, cosine, hn::Mul(y, sine));
      of[row + 1] = hn::NegMulAdd(x, sine, hn::Mul(y, cosine));
    }
  }

  void Apply(const Turn& turn) {
    for (int row = 0; row < 12; row += 4) {
      const Lane x = of[row], y = of[row + 1], z = of[row + 2];
      for (int column = 0; column < 3; ++column) {
        of[row + column] =
            hn::MulAdd(x, turn.of[column],
                       hn::MulAdd(y, turn.of[3 + column], hn::Mul(z, turn.of[6 + column])));
      }
    }
  }
};

Frame ChildFrame(const Frame& parent, const ModelLink& link, Lane variable) {
  Frame frame = parent.Times(link.X_PJ);
  if (link.kind == JointKind::kFixed) return frame;
  const Lane value = hn::MulAdd(All(link.multiplier), variable, All(link.offset));
  if (link.kind == JointKind::kPrismatic) {
    frame.Slide(link.axis_J, value);
    return frame;
  }
  const Lane sine = hn::Sin(kTag, value), cosine = hn::Cos(kTag, value);
  if (link.axis_J == Vector3::UnitZ()) {
    frame.TurnAboutZ(sine, cosine);
  } else {
    frame.Apply(TurnAbout(link.axis_J, sine, cosine));
  }
  return frame;
}

// Places `count` states, as many at a time as there are SIMD lanes. Unused lanes repeat the last
// state.
void PlaceAll(const RobotModel& model, const Pose& X_WB, const double* states, std::size_t count,
              Pose* X_WL) {
  const std::size_t lanes = hn::Lanes(kTag), links = model.links.size();
  const std::size_t width = model.variables.size();
  constexpr std::size_t kFrame = kNumbers * kMaxLanes;
  std::vector<double> frames(links * kFrame);
  for (std::size_t first = 0; first < count; first += lanes) {
    const std::size_t used = std::min(lanes, count - first);
    for (std::size_t i = 0; i < links; ++i) {
      const ModelLink& link = model.links[i];
      double* const own = frames.data() + i * kFrame;
      if (i == 0) {
        Frame::OfAll(X_WB).Write(own);
      } else {
        alignas(64) double variable[kMaxLanes] = {};
        if (link.kind != JointKind::kFixed) {
          for (std::size_t l = 0; l < lanes; ++l) {
            variable[l] = states[(first + std::min(l, used - 1)) * width +
                                 static_cast<std::size_t>(link.variable)];
          }
        }
        const double* const parent = frames.data() + static_cast<std::size_t>(link.parent) * kFrame;
        ChildFrame(Frame::Read(parent), link, hn::Load(kTag, variable)).Write(own);
      }
      for (std::size_t l = 0; l < used; ++l) {
        Pose& pose = X_WL[(first + l) * links + i];
        for (int column = 0; column < 4; ++column) {
          for (int row = 0; row < 3; ++row) {
            pose(row, column) = own[static_cast<std::size_t>(4 * row + column) * kMaxLanes + l];
          }
        }
        pose.makeAffine();
      }
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {
namespace {

// cited: Highway's documentation limits the error of its sine and cosine for angles up to 39 000.
// chosen: somewhat less.
constexpr double kMaxAngle_rad = 3e4;

bool HasMultiVariableJoint(const RobotModel& model) {
  return std::ranges::any_of(model.links, [](const ModelLink& link) {
    return link.kind == JointKind::kFloating || link.kind == JointKind::kPlanar;
  });
}

// True if the state has an angle that the SIMD code cannot take.
bool TurnsTooFar(const RobotModel& model, std::span<const double> state) {
  return std::ranges::any_of(model.links, [&](const ModelLink& link) {
    if (link.kind != JointKind::kRevolute && link.kind != JointKind::kContinuous) return false;
    const double variable = state[static_cast<std::size_t>(link.variable)];
    return !(std::abs(link.multiplier * variable + link.offset) < kMaxAngle_rad);
  });
}

}  // namespace

HWY_EXPORT(PlaceAll);

void LinkPosesOfStates(const RobotModel& model, const Pose& X_WB, std::span<const double> states,
                       std::span<Pose> X_WL) {
  const std::size_t links = model.links.size(), width = model.variables.size();
  const std::size_t count = X_WL.size() / links;
  const bool in_lanes = !HasMultiVariableJoint(model);
  if (in_lanes) {
    HWY_DYNAMIC_DISPATCH(PlaceAll)(model, X_WB, states.data(), count, X_WL.data());
  }
  for (std::size_t k = 0; k < count; ++k) {
    const std::span<const double> state = states.subspan(k * width, width);
    if (in_lanes && !TurnsTooFar(model, state)) continue;
    LinkPoses(model, X_WB, state, X_WL.subspan(k * links, links));
  }
}

}  // namespace cwm::collision
#endif  // HWY_ONCE
