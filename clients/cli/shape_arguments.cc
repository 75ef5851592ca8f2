#include <functional>

#include "absl/strings/str_cat.h"
#include "clients/cli/body_arguments.h"
#include "clients/cli/exit_code.h"
#include "clients/cli/number_list.h"

namespace cwm::cli {
namespace {

using NumberList = std::vector<double>;
using cwm::v1::PlacedShape;

struct ShapeOption {
  std::string ShapeArguments::*text;
  NumberSpec spec;
  std::string help;
  std::function<void(const NumberList&, PlacedShape&)> fill;
};

const std::vector<ShapeOption>& ShapeOptions() {
  static const std::vector<ShapeOption> kOptions = {
      {&ShapeArguments::box,
       {"--box", "X,Y,Z", 3},
       "a box of these edge lengths (m)",
       [](const NumberList& n, PlacedShape& shape) {
         shape.mutable_box()->set_size_x_m(n[0]);
         shape.mutable_box()->set_size_y_m(n[1]);
         shape.mutable_box()->set_size_z_m(n[2]);
       }},
      {&ShapeArguments::sphere,
       {"--sphere", "R", 1},
       "a sphere of this radius (m)",
       [](const NumberList& n, PlacedShape& shape) { shape.mutable_sphere()->set_radius_m(n[0]); }},
      {&ShapeArguments::cylinder,
       {"--cylinder", "R,L", 2},
       "a cylinder along z: radius, length (m)",
       [](const NumberList& n, PlacedShape& shape) {
         shape.mutable_cylinder()->set_radius_m(n[0]);
         shape.mutable_cylinder()->set_length_m(n[1]);
       }},
      {&ShapeArguments::cone,
       {"--cone", "RB,RT,L", 3},
       "a cone along z: radius at the bottom, at the top, length (m)",
       [](const NumberList& n, PlacedShape& shape) {
         shape.mutable_cone()->set_radius_bottom_m(n[0]);
         shape.mutable_cone()->set_radius_top_m(n[1]);
         shape.mutable_cone()->set_length_m(n[2]);
       }},
      {&ShapeArguments::capsule,
       {"--capsule", "R,L", 2},
       "a capsule along z: radius, length between the centres (m)",
       [](const NumberList& n, PlacedShape& shape) {
         shape.mutable_capsule()->set_radius_m(n[0]);
         shape.mutable_capsule()->set_length_m(n[1]);
       }},
  };
  return kOptions;
}

}  // namespace

void AddShapeOptions(CLI::App& command, ShapeArguments& shape) {
  for (const ShapeOption& option : ShapeOptions()) {
    command.add_option(option.spec.name, shape.*option.text, option.help)
        ->type_name(option.spec.form);
  }
}

bool HasShape(const ShapeArguments& shape) {
  for (const ShapeOption& option : ShapeOptions()) {
    if (!(shape.*option.text).empty()) return true;
  }
  return false;
}

absl::StatusOr<PlacedShape> ParseShape(const ShapeArguments& shape) {
  PlacedShape placed;
  for (const ShapeOption& option : ShapeOptions()) {
    const std::string& text = shape.*option.text;
    if (text.empty()) continue;
    if (placed.shape_case() != PlacedShape::SHAPE_NOT_SET) {
      return UsageError(absl::StrCat(option.spec.name, ": only one shape at a time"));
    }
    const auto numbers = ParseNumbers(text, option.spec);
    if (!numbers.ok()) return numbers.status();
    option.fill(*numbers, placed);
  }
  if (placed.shape_case() != PlacedShape::SHAPE_NOT_SET) return placed;
  return UsageError("a shape is missing: --box, --sphere, --cylinder, --cone or --capsule");
}

}  // namespace cwm::cli
