#include "tests/benchmarks/quality/shape_tally.h"

#include <cstdio>
#include <numbers>
#include <utility>

namespace cwm::benchmarks {
namespace {

void Append(std::vector<double>& samples, const std::optional<double>& error) {
  if (error) samples.push_back(*error);
}

std::string Describe(const TrueShape& truth, const SceneShapes& shapes,
                     const ShapeOutcome& outcome) {
  char text[200];
  const std::string as =
      outcome.best < 0
          ? "nothing"
          : std::string(
                NameOf(KindOf(shapes.found[static_cast<std::size_t>(outcome.best)].part.shape)));
  std::snprintf(text, sizeof(text),
                "%s of %zu points (object %d): %s; best is a %s, IoU %.2f, whole object IoU %.2f, "
                "surface off by %.2f sigma",
                std::string(NameOf(KindOf(truth.shape))).c_str(), truth.points.size(), truth.object,
                std::string(NameOf(outcome.outcome)).c_str(), as.c_str(), outcome.iou,
                outcome.object_iou, outcome.surface_sigma);
  return text;
}

// The errors that are large, as text; empty if there are none.
std::string DescribeLarge(const TrueShape& truth, const FoundShape& found,
                          const ShapeErrors& errors) {
  std::string large;
  const auto add = [&large](const char* name, double value, double limit, const char* unit) {
    if (!(value > limit)) return;
    char text[60];
    std::snprintf(text, sizeof(text), ", %s off by %.1f %s", name, value, unit);
    large += text;
  };
  constexpr double kMillimetres = 1000, kDegrees = 180 / std::numbers::pi;
  add("radius", kMillimetres * errors.radius_m.value_or(0),
      kMillimetres * ShapeTally::kLargeRadius_m, "mm");
  add("axis", kDegrees * errors.axis_rad.value_or(0), ShapeTally::kLargeAxis_deg, "deg");
  for (const double length_m : errors.length_m) {
    add("length", kMillimetres * length_m, kMillimetres * ShapeTally::kLargeLength_m, "mm");
  }
  if (large.empty()) return large;
  return std::string(NameOf(KindOf(truth.shape))) + " of " + std::to_string(truth.points.size()) +
         " points as a " + std::string(NameOf(KindOf(found.part.shape))) + large;
}

std::string Describe(const FoundShape& found, Invention what) {
  char text[120];
  std::snprintf(text, sizeof(text), "invented %s of %zu points (found object %d): %s",
                std::string(NameOf(KindOf(found.part.shape))).c_str(), found.points.size(),
                found.object, std::string(NameOf(what)).c_str());
  return text;
}

}  // namespace

void ErrorSamples::Add(const TrueShape& truth, const ShapeErrors& errors) {
  Append(radius_m, errors.radius_m);
  Append(axis_rad, errors.axis_rad);
  Append(half_angle_rad, errors.half_angle_rad);
  Append(box_axis_rad, errors.box_axis_rad);
  Append(centre_m, errors.centre_m);
  std::vector<double>& lengths = KindOf(truth.shape) == ShapeKind::kBox ? box_edge_m : length_m;
  lengths.insert(lengths.end(), errors.length_m.begin(), errors.length_m.end());
}

void ShapeTally::AddTruth(const std::string& scene, const InterpretedView& view,
                          const TrueShape& truth, const SceneShapes& shapes,
                          const ShapeOutcome& outcome) {
  ++true_count_;
  ++outcomes_[KindOf(truth.shape)][static_cast<std::size_t>(outcome.outcome)];
  all_.Add(truth, outcome.errors);
  const Vector3 middle_S = MiddleOfSeen_S(truth, view);
  const Vector3 middle_C = view.interpretation.X_WC.inverse() * (truth.X_WS * middle_S);
  if (middle_C.z() > kFar_m) far_.Add(truth, outcome.errors);
  const std::optional<double> radius_m = RadiusAt_m(truth.shape, middle_S.z());
  if (radius_m && *radius_m < kThin_m) thin_.Add(truth, outcome.errors);
  if (!IsFound(outcome.outcome)) {
    failures_.push_back({scene, Describe(truth, shapes, outcome)});
    return;
  }
  const FoundShape& found = shapes.found[static_cast<std::size_t>(outcome.best)];
  calibration_.Add(truth, found);
  std::string large = DescribeLarge(truth, found, outcome.errors);
  if (!large.empty()) large_errors_.push_back({scene, std::move(large)});
}

void ShapeTally::Add(const std::string& scene, const InterpretedView& view,
                     const SceneShapes& shapes) {
  for (std::size_t t = 0; t < shapes.truth.size(); ++t) {
    if (shapes.truth[t].points.size() < kCountedTruePoints) continue;
    AddTruth(scene, view, shapes.truth[t], shapes, shapes.outcomes[t]);
  }
  for (const SpuriousShape& spurious : shapes.spurious) {
    ++inventions_[static_cast<std::size_t>(spurious.what)];
    failures_.push_back(
        {scene, Describe(shapes.found[static_cast<std::size_t>(spurious.found)], spurious.what)});
  }
}

double ShapeTally::found_share() const {
  int found = 0;
  for (const auto& [kind, counts] : outcomes_) {
    found += counts[static_cast<std::size_t>(Outcome::kFound)];
  }
  return true_count_ == 0 ? 0 : static_cast<double>(found) / true_count_ + equivalent_share();
}

double ShapeTally::equivalent_share() const {
  int equivalent = 0;
  for (const auto& [kind, counts] : outcomes_) {
    equivalent += counts[static_cast<std::size_t>(Outcome::kEquivalent)];
  }
  return true_count_ == 0 ? 0 : static_cast<double>(equivalent) / true_count_;
}

double ShapeTally::spurious_share() const {
  int spurious = 0;
  for (int count : inventions_) spurious += count;
  return true_count_ == 0 ? 0 : static_cast<double>(spurious) / true_count_;
}

std::vector<std::string> ShapeTally::Lines() const {
  char text[40];
  std::snprintf(text, sizeof(text), "  %-10s", "true");
  std::vector<std::string> lines = {text};
  for (int o = 0; o < kOutcomeCount; ++o) {
    std::snprintf(text, sizeof(text), "%12s", std::string(NameOf(static_cast<Outcome>(o))).c_str());
    lines[0] += text;
  }
  for (const auto& [kind, counts] : outcomes_) {
    std::snprintf(text, sizeof(text), "  %-10s", std::string(NameOf(kind)).c_str());
    lines.emplace_back(text);
    for (int count : counts) {
      std::snprintf(text, sizeof(text), "%12d", count);
      lines.back() += text;
    }
  }
  lines.emplace_back("  invented:");
  for (int i = 0; i < kInventionCount; ++i) {
    const std::string name(NameOf(static_cast<Invention>(i)));
    std::snprintf(text, sizeof(text), " %s %d", name.c_str(),
                  inventions_[static_cast<std::size_t>(i)]);
    lines.back() += text;
  }
  return lines;
}

}  // namespace cwm::benchmarks
