// The true shapes of a scan that an interpretation found, and the shapes that it invented.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "tests/benchmarks/quality/shape_errors.h"

namespace cwm::benchmarks {

// A true shape counts if this many points of it were measured; a found one that matches nothing, if
// it explains this many.
inline constexpr std::size_t kCountedTruePoints = 300;
inline constexpr std::size_t kCountedFoundPoints = 100;

// The true and the found shape have the same points from this intersection over union on. Above one
// half, at most one found shape can reach it.
inline constexpr double kSamePoints_iou = 0.75;

// Another type is equivalent if its surface differs over the visible part by no more than this:
// root mean square, in standard deviations of the sensor's axial noise at that depth.
inline constexpr double kSameSurface_sigma = 0.5;

enum class Outcome {
  kFound,       // same points, same type
  kEquivalent,  // same points, another type with the same surface
  kWrongType,   // same points, another type
  kMerged,      // the best shape has three quarters of its points, and too many others
  kSplit,       // three quarters of the best shape lie on it, but miss too much of it
  kPartial,     // the best shape shares a quarter of its points, or more
  kMissing,     // no shape does
};
inline constexpr int kOutcomeCount = 7;
std::string_view NameOf(Outcome outcome);
inline bool IsFound(Outcome outcome) {
  return outcome == Outcome::kFound || outcome == Outcome::kEquivalent;
}

struct ShapeOutcome {
  Outcome outcome = Outcome::kMissing;
  std::int32_t best = -1;  // the found shape that shares most points, by intersection over union
  double iou = 0;
  double object_iou = 0;     // best of the whole objects found, against this true shape alone
  double surface_sigma = 0;  // for the same points: difference of the surfaces
  ShapeErrors errors;
};

enum class Invention {
  kWrongType,  // three quarters of a true shape's points, as another type
  kFragment,   // by three quarters on one true shape
  kMixture,    // on several true shapes, or on one and its surroundings
  kBackground  // by half or more on fixtures, or on nothing
};
inline constexpr int kInventionCount = 4;
std::string_view NameOf(Invention invention);

struct SpuriousShape {
  std::int32_t found = -1;
  Invention what = Invention::kMixture;
};

struct SceneShapes {
  std::vector<TrueShape> truth;
  std::vector<FoundShape> found;
  std::vector<ShapeOutcome> outcomes;   // per true shape that has points; best = -1 elsewhere
  std::vector<SpuriousShape> spurious;  // of kCountedFoundPoints or more
};

// Matches found and true shapes of any size: the outcome of a match is kFound or kEquivalent. Thin
// solids by half or more on fixtures (the edge of a table top) do not count as invented.
SceneShapes MatchShapes(const InterpretedView& view);

}  // namespace cwm::benchmarks
