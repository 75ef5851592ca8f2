#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/inverse_kinematics/ik_steps.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <cmath>

#include "collision/inverse_kinematics/ik_steps.h"
#include "hwy/contrib/math/math-inl.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

constexpr double kDamping = 0.05;       // alpha
constexpr double kDampingFloor = 1e-7;  // keeps singular configurations solvable
constexpr double kMaxStep = 1;          // rad or m
constexpr double kMinHalfTurn = 1e-4;   // 1 + trace, where the axis of the error gets uncertain

// D is a tag of Highway's with as many lanes as starts are moved together.
template <class D>
struct Stepper {
  using T = hn::TFromD<D>;
  using V = hn::Vec<D>;

  static V All(double value) { return hn::Set(D(), static_cast<T>(value)); }

  struct Column {
    V of[6];  // of the Jacobian: translation, then rotation times its weight
  };

  Stepper(const IkChain& chain_of_tool, const T* numbers_of_chain)
      : chain(chain_of_tool), numbers(numbers_of_chain) {}

  const IkChain& chain;
  const T* numbers;     // IkChain::numbers in this precision
  V turn[9], place[3];  // the frame reached so far, row-major
  V axis[kMaxIkJoints][3], origin[kMaxIkJoints][3];
  V error[6];
  V position2, rotation2;
  Column columns[kMaxIkVariables];

  // Appends a constant transform.
  void Append(const T* X) {
    for (int row = 0; row < 3; ++row) {
      const V a = turn[3 * row], b = turn[3 * row + 1], c = turn[3 * row + 2];
      const auto times = [&](int column) HWY_ATTR {
        return hn::MulAdd(
            a, hn::Set(D(), X[column]),
            hn::MulAdd(b, hn::Set(D(), X[4 + column]), hn::Mul(c, hn::Set(D(), X[8 + column]))));
      };
      place[row] = hn::Add(place[row], times(3));
      turn[3 * row] = times(0);
      turn[3 * row + 1] = times(1);
      turn[3 * row + 2] = times(2);
    }
  }

  void Place(const T* values, std::size_t stride) {
    for (int k = 0; k < 9; ++k) turn[k] = All(k % 4 == 0 ? 1 : 0);
    for (V& number : place) number = hn::Zero(D());
    for (std::size_t j = 0; j < chain.joints.size(); ++j) {
      const IkJoint& joint = chain.joints[j];
      Append(numbers + 12 * j);
      const V variable = hn::LoadU(D(), values + static_cast<std::size_t>(joint.variable) * stride);
      const V value = hn::MulAdd(variable, All(joint.multiplier), All(joint.offset));
      for (int row = 0; row < 3; ++row) {
        axis[j][row] = turn[3 * row + 2];
        origin[j][row] = place[row];
      }
      if (joint.slides) {
        for (int row = 0; row < 3; ++row) place[row] = hn::MulAdd(axis[j][row], value, place[row]);
        continue;
      }
      const V sine = hn::Sin(D(), value), cosine = hn::Cos(D(), value);
      for (int row = 0; row < 3; ++row) {
        const V x = turn[3 * row], y = turn[3 * row + 1];
        turn[3 * row] = hn::MulAdd(x, cosine, hn::Mul(y, sine));
        turn[3 * row + 1] = hn::NegMulAdd(x, sine, hn::Mul(y, cosine));
      }
    }
    Append(numbers + 12 * chain.joints.size());
  }

  // Row i, column j of R_target R^T, the rotation that is missing.
  V Missing(const T* target, int i, int j) const {
    const T* row = target + 4 * i;
    return hn::MulAdd(hn::Set(D(), row[0]), turn[3 * j],
                      hn::MulAdd(hn::Set(D(), row[1]), turn[3 * j + 1],
                                 hn::Mul(hn::Set(D(), row[2]), turn[3 * j + 2])));
  }

  void SetError(const T* target) {
    position2 = hn::Zero(D());
    for (int row = 0; row < 3; ++row) {
      error[row] = hn::Sub(hn::Set(D(), target[4 * row + 3]), place[row]);
      position2 = hn::MulAdd(error[row], error[row], position2);
    }
    const V trace =
        hn::Add(Missing(target, 0, 0), hn::Add(Missing(target, 1, 1), Missing(target, 2, 2)));
    const V away[3] = {hn::Sub(Missing(target, 2, 1), Missing(target, 1, 2)),
                       hn::Sub(Missing(target, 0, 2), Missing(target, 2, 0)),
                       hn::Sub(Missing(target, 1, 0), Missing(target, 0, 1))};
    // 2 sin(angle / 2) times the axis: sin(angle) = 2 sin(angle / 2) cos(angle / 2), and 1 + trace
    // is 4 cos^2(angle / 2).
    const V scale = hn::Div(All(1), hn::Sqrt(hn::Max(hn::Add(All(1), trace), All(kMinHalfTurn))));
    V by_axis2 = hn::Zero(D());
    for (int k = 0; k < 3; ++k) {
      const V of_axis = hn::Mul(away[k], scale);
      by_axis2 = hn::MulAdd(of_axis, of_axis, by_axis2);
      error[3 + k] = hn::Mul(of_axis, All(kRotationWeight_m));
    }
    // The vector vanishes at half a turn, the trace tells its length there; small errors of it are
    // lost in the trace's rounding.
    rotation2 = hn::IfThenElse(hn::Gt(trace, hn::Zero(D())), by_axis2, hn::Sub(All(3), trace));
  }

  void SetColumns() {
    for (std::size_t v = 0; v < chain.variables.size(); ++v) {
      for (V& number : columns[v].of) number = hn::Zero(D());
    }
    for (std::size_t j = 0; j < chain.joints.size(); ++j) {
      const IkJoint& joint = chain.joints[j];
      V* const column = columns[joint.variable].of;
      const V multiplier = All(joint.multiplier);
      const V* const a = axis[j];
      if (joint.slides) {
        for (int k = 0; k < 3; ++k) column[k] = hn::MulAdd(a[k], multiplier, column[k]);
        continue;
      }
      V lever[3];
      for (int k = 0; k < 3; ++k) lever[k] = hn::Sub(place[k], origin[j][k]);
      for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3, last = (k + 2) % 3;
        const V cross = hn::Sub(hn::Mul(a[next], lever[last]), hn::Mul(a[last], lever[next]));
        column[k] = hn::MulAdd(cross, multiplier, column[k]);
        column[3 + k] =
            hn::MulAdd(a[k], hn::Mul(multiplier, All(kRotationWeight_m)), column[3 + k]);
      }
    }
  }

  // Solves the damped normal equations by Cholesky's decomposition and moves the values.
  void Move(T* values, std::size_t stride) {
    const std::size_t n = chain.variables.size();
    const V total = hn::MulAdd(rotation2, All(kRotationWeight_m * kRotationWeight_m), position2);
    const V damping = hn::MulAdd(total, All(kDamping), All(kDampingFloor));
    V gradient[kMaxIkVariables], value[kMaxIkVariables];
    V matrix[kMaxIkVariables][kMaxIkVariables];  // lower triangle
    hn::Mask<D> is_held[kMaxIkVariables];
    for (std::size_t i = 0; i < n; ++i) {
      const IkVariable& variable = chain.variables[i];
      value[i] = hn::LoadU(D(), values + i * stride);
      gradient[i] = hn::Zero(D());
      for (int k = 0; k < 6; ++k) {
        gradient[i] = hn::MulAdd(columns[i].of[k], error[k], gradient[i]);
      }
      const V zero = hn::Zero(D());
      is_held[i] =
          hn::Or(hn::And(hn::Ge(value[i], All(variable.upper)), hn::Gt(gradient[i], zero)),
                 hn::And(hn::Le(value[i], All(variable.lower)), hn::Lt(gradient[i], zero)));
      gradient[i] = hn::IfThenZeroElse(is_held[i], gradient[i]);
      for (std::size_t j = 0; j <= i; ++j) {
        V sum = hn::Zero(D());
        for (int k = 0; k < 6; ++k) {
          sum = hn::MulAdd(columns[i].of[k], columns[j].of[k], sum);
        }
        if (i == j) sum = hn::IfThenElse(is_held[i], All(1), hn::Add(sum, damping));
        if (i != j) sum = hn::IfThenZeroElse(hn::Or(is_held[i], is_held[j]), sum);
        matrix[i][j] = sum;
      }
    }
    V step[kMaxIkVariables], inverse[kMaxIkVariables];
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        V sum = matrix[i][j];
        for (std::size_t k = 0; k < j; ++k) sum = hn::NegMulAdd(matrix[i][k], matrix[j][k], sum);
        if (i == j) {
          // The damping keeps pivots positive up to rounding.
          inverse[i] = hn::Div(All(1), hn::Sqrt(hn::Max(sum, All(0.1 * kDampingFloor))));
        } else {
          matrix[i][j] = hn::Mul(sum, inverse[j]);
        }
      }
      V sum = gradient[i];
      for (std::size_t k = 0; k < i; ++k) sum = hn::NegMulAdd(matrix[i][k], step[k], sum);
      step[i] = hn::Mul(sum, inverse[i]);
    }
    V longest = hn::Zero(D());
    for (std::size_t i = n; i-- > 0;) {
      V sum = step[i];
      for (std::size_t k = i + 1; k < n; ++k) sum = hn::NegMulAdd(matrix[k][i], step[k], sum);
      step[i] = hn::Mul(sum, inverse[i]);
      longest = hn::Max(longest, hn::Abs(step[i]));
    }
    const V share = hn::Div(All(kMaxStep), hn::Max(longest, All(kMaxStep)));
    for (std::size_t i = 0; i < n; ++i) {
      const IkVariable& variable = chain.variables[i];
      const V moved = hn::MulAdd(step[i], share, value[i]);
      hn::StoreU(hn::Min(hn::Max(moved, All(variable.lower)), All(variable.upper)), D(),
                 values + i * stride);
    }
  }
};

template <class D, class Errors, class T = hn::TFromD<D>>
void StepLanes(const IkChain& chain, const T* numbers, const T* target, T* values,
               std::size_t stride, std::size_t first, Errors& errors) {
  Stepper<D> stepper(chain, numbers);
  stepper.Place(values + first, stride);
  stepper.SetError(target);
  stepper.SetColumns();
  stepper.Move(values + first, stride);
  hn::StoreU(stepper.position2, D(), errors.position2 + first);
  hn::StoreU(stepper.rotation2, D(), errors.rotation2 + first);
}

void StepStarts(const IkChain& chain, const IkTarget<float>& target,
                IkValues<float, kIkStarts>& values, IkErrors<float, kIkStarts>& errors) {
  using D = hn::CappedTag<float, kIkStarts>;
  for (std::size_t first = 0; first < kIkStarts; first += hn::Lanes(D())) {
    StepLanes<D>(chain, chain.rounded_numbers.data(), target.X_BT, values.of, kIkStarts, first,
                 errors);
  }
}

void StepOne(const IkChain& chain, const IkTarget<double>& target, IkValues<double, 1>& values,
             IkErrors<double, 1>& errors) {
  StepLanes<hn::CappedTag<double, 1>>(chain, chain.numbers.data(), target.X_BT, values.of, 1, 0,
                                      errors);
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {

HWY_EXPORT(StepStarts);
HWY_EXPORT(StepOne);

namespace {

template <class T>
IkTarget<T> TargetOf(const Pose& X_BT) {
  IkTarget<T> target;
  for (int k = 0; k < 12; ++k) target.X_BT[k] = static_cast<T>(X_BT(k / 4, k % 4));
  return target;
}

}  // namespace

IkTarget<double> IkTargetOf(const Pose& X_BT) { return TargetOf<double>(X_BT); }
IkTarget<float> RoundedIkTargetOf(const Pose& X_BT) { return TargetOf<float>(X_BT); }

IkErrors<float, kIkStarts> StepIkStarts(const IkChain& chain, const IkTarget<float>& target,
                                        IkValues<float, kIkStarts>& values) {
  IkErrors<float, kIkStarts> errors;
  HWY_DYNAMIC_DISPATCH(StepStarts)(chain, target, values, errors);
  return errors;
}

IkErrors<double, 1> StepIk(const IkChain& chain, const IkTarget<double>& target,
                           IkValues<double, 1>& values) {
  IkErrors<double, 1> errors;
  HWY_DYNAMIC_DISPATCH(StepOne)(chain, target, values, errors);
  return errors;
}

}  // namespace cwm::collision
#endif
