#include "collision/spheres/tight_pairs.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>

#include "collision/robot/kinematics.h"
#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {
namespace {

constexpr std::size_t kDrawnStates = 512;

// A number in [0, 1), the same with every standard library.
double Share(std::mt19937& random) { return std::ldexp(static_cast<double>(random()), -32); }

std::vector<double> DrawStates(const RobotModel& model) {
  std::mt19937 random(1);
  std::vector<double> rows;
  for (std::size_t k = 0; k < kDrawnStates; ++k) {
    for (const int index : model.all.variables) {
      const Variable& variable = model.variables[static_cast<std::size_t>(index)];
      const bool is_endless = !std::isfinite(variable.lower) || !std::isfinite(variable.upper);
      const double lower = is_endless ? -std::numbers::pi : variable.lower;
      const double upper = is_endless ? std::numbers::pi : variable.upper;
      rows.push_back(lower + Share(random) * (upper - lower));
    }
  }
  return rows;
}

// In how many of the states the spheres of each of at most kTags pairs touch.
std::array<std::size_t, kTags> CountTouching(const SphereProgram& program,
                                             const std::vector<double>& rows, std::size_t width) {
  constexpr std::size_t kStride = (kDrawnStates + kMaxLanes - 1) / kMaxLanes * kMaxLanes;
  std::vector<float> values(program.inputs.size() * kStride, 0.0F);
  std::vector<StateMark> marks(kDrawnStates);
  LoadStates(program.inputs, rows.data(), width, kDrawnStates, kStride, values.data(),
             marks.data());
  LaneMemory memory;
  LaneScene empty;
  empty.near_group.resize(program.lanes.groups.size());
  std::vector<LaneVerdict> verdicts(kDrawnStates);
  std::vector<UnresolvedTags> open(kDrawnStates);
  CheckStates(program.lanes, empty, values.data(), kStride, kDrawnStates, memory, verdicts.data(),
              open.data());
  std::array<std::size_t, kTags> counts{};
  for (const UnresolvedTags& of_state : open) {
    for (std::uint64_t tags = of_state.pairs; tags != 0; tags &= tags - 1) {
      ++counts[static_cast<std::size_t>(std::countr_zero(tags))];
    }
  }
  return counts;
}

}  // namespace

std::vector<LinkPair> FindTightPairs(const RobotModel& model, const SphereModel& around) {
  std::vector<LinkPair> tight;
  std::vector<PlacedSphere> spheres;
  for (std::size_t link = 0; link < around.links.size(); ++link) {
    for (const LinkSphere& sphere : around.links[link]) {
      spheres.push_back({.link = static_cast<int>(link),
                         .centre_L = sphere.center_L,
                         .radius_m = sphere.radius_m,
                         .proof = {.of_gap = true, .of_contact = false}});
    }
  }
  const std::vector<double> base = DefaultVariables(model), rows = DrawStates(model);
  const std::span<const LinkPair> all(model.self_pairs);
  for (std::size_t first = 0; first < all.size(); first += kTags) {
    const auto some = all.subspan(first, std::min<std::size_t>(kTags, all.size() - first));
    std::vector<SphereLinkPair> pairs;
    for (const LinkPair& links : some) {
      pairs.push_back({.links = links, .tag = static_cast<std::int32_t>(pairs.size())});
    }
    const auto program =
        CompileSpheres(model, model.all, base, {.spheres = spheres, .pairs = {.links = pairs}});
    if (!program) return {};
    const auto counts = CountTouching(*program, rows, model.all.variables.size());
    for (std::size_t k = 0; k < some.size(); ++k) {
      const double share = static_cast<double>(counts[k]) / static_cast<double>(kDrawnStates);
      if (share >= kTightShare) tight.push_back(some[k]);
    }
  }
  return tight;
}

}  // namespace cwm::collision
