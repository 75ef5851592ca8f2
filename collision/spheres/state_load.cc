#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "collision/spheres/state_load.cc"
#include "hwy/foreach_target.h"  // compiles this file once for each instruction set
//
#include <algorithm>

#include "collision/spheres/sphere_lanes.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace cwm::collision {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// chosen: enough rows that a column is stored long before it is loaded as vectors, and few enough
// that the rows are still in the cache for the next column. measured: a gather takes four times as
// long.
constexpr std::size_t kRowsAtOnce = 64;

// Loads one column of up to kRowsAtOnce rows.
class ColumnLoad {
 public:
  ColumnLoad(const LaneInput& input, std::size_t width) : input_(input), width_(width) {}

  void Run(const double* rows, std::size_t count, float* values, StateMark* marks) const {
    alignas(64) double given[kRowsAtOnce];
    for (std::size_t i = 0; i < count; ++i) given[i] = rows[input_.column + i * width_];
    std::fill(given + count, given + kRowsAtOnce, 0.0);
    for (std::size_t i = 0; i < count; i += hn::Lanes(kReal)) {
      RunLanes(hn::Load(kReal, given + i), HWY_MIN(hn::Lanes(kReal), count - i), values + i,
               marks + i);
    }
  }

 private:
  static constexpr hn::CappedTag<double, 8> kReal{};
  static constexpr hn::Rebind<float, decltype(kReal)> kFloatTag{};

  void RunLanes(hn::Vec<decltype(kReal)> given, std::size_t count, float* values,
                StateMark* marks) const {
    const auto set = [](double value) HWY_ATTR { return hn::Set(kReal, value); };
    const auto inside =
        hn::And(hn::Ge(given, set(input_.lower_limit)), hn::Le(given, set(input_.upper_limit)));
    auto value = hn::MulAdd(given, set(input_.multiplier), set(input_.offset));
    auto good = inside;
    if (!input_.stays_near) {
      // Values within `farthest` fit a float; others are replaced by 0.
      good = hn::And(good, hn::Le(hn::Abs(value), set(input_.farthest)));
      if (input_.turns) {
        constexpr double kTurn = 6.283185307179586;
        value = hn::NegMulAdd(hn::Round(hn::Mul(value, set(1 / kTurn))), set(kTurn), value);
      }
    }
    hn::StoreU(hn::DemoteTo(kFloatTag, hn::IfThenElseZero(good, value)), kFloatTag, values);
    if (hn::AllTrue(kReal, good)) return;
    const auto bits = [](auto mask) HWY_ATTR {
      std::uint8_t some[8] = {};
      hn::StoreMaskBits(kReal, mask, some);
      return unsigned{some[0]};
    };
    const unsigned outside = bits(hn::Not(inside)), bad = bits(hn::Not(good));
    for (std::size_t i = 0; i < count; ++i) {
      const StateMark mark = (outside >> i & 1) != 0 ? StateMark::kOutOfLimits
                             : (bad >> i & 1) != 0   ? StateMark::kTooFar
                                                     : StateMark::kReady;
      marks[i] = std::max(marks[i], mark);
    }
  }

  const LaneInput& input_;
  const std::size_t width_;
};

void LoadAll(std::span<const LaneInput> inputs, const double* rows, std::size_t width,
             std::size_t count, std::size_t stride, float* values, StateMark* marks) {
  std::fill_n(marks, count, StateMark::kReady);
  for (std::size_t first = 0; first < count; first += kRowsAtOnce) {
    float* to = values + first;
    for (const LaneInput& input : inputs) {
      ColumnLoad(input, width)
          .Run(rows + first * width, HWY_MIN(kRowsAtOnce, count - first), to, marks + first);
      to += stride;
    }
  }
}

void AddKeysOfAll(const CellKeys& cells, const float* values, std::size_t count,
                  std::uint32_t* keys) {
  const hn::CappedTag<float, kMaxLanes> real;
  const hn::RebindToSigned<decltype(real)> index;
  const hn::RebindToUnsigned<decltype(real)> key;
  const std::size_t lanes = hn::Lanes(real);
  const auto lower = hn::Set(real, cells.lower), scale = hn::Set(real, cells.cells_per_unit);
  const auto last = hn::Set(real, static_cast<float>(cells.key_of_cell.size() - 1));
  // A table that fits a vector is read several times as fast as with a gather.
  const bool fits = cells.key_of_cell.size() <= lanes;
  alignas(64) std::uint32_t few[kMaxLanes] = {};
  if (fits) std::copy(cells.key_of_cell.begin(), cells.key_of_cell.end(), few);
  const auto table = hn::Load(key, few);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto at = hn::Mul(hn::Sub(hn::LoadU(real, values + i), lower), scale);
    const auto cell = hn::ConvertTo(index, hn::Min(hn::Max(at, hn::Zero(real)), last));
    const auto of_cell = fits ? hn::TableLookupLanes(table, hn::IndicesFromVec(key, cell))
                              : hn::GatherIndex(key, cells.key_of_cell.data(), cell);
    hn::StoreU(hn::Or(hn::LoadU(key, keys + i), of_cell), key, keys + i);
  }
  for (; i < count; ++i) {
    const float at = (values[i] - cells.lower) * cells.cells_per_unit;
    const float most = static_cast<float>(cells.key_of_cell.size() - 1);
    keys[i] |= cells.key_of_cell[static_cast<std::size_t>(HWY_MIN(HWY_MAX(at, 0.0F), most))];
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace cwm::collision
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cwm::collision {

HWY_EXPORT(LoadAll);
HWY_EXPORT(AddKeysOfAll);

void LoadStates(std::span<const LaneInput> inputs, const double* rows, std::size_t width,
                std::size_t count, std::size_t stride, float* values, StateMark* marks) {
  HWY_DYNAMIC_DISPATCH(LoadAll)(inputs, rows, width, count, stride, values, marks);
}

void AddKeys(const CellKeys& cells, const float* values, std::size_t count, std::uint32_t* keys) {
  HWY_DYNAMIC_DISPATCH(AddKeysOfAll)(cells, values, count, keys);
}

}  // namespace cwm::collision
#endif  // HWY_ONCE
