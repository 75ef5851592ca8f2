#include "clients/cli/object_table.h"

#include <google/protobuf/util/time_util.h>

#include <algorithm>
#include <array>
#include <ostream>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/cli/enum_names.h"
#include "clients/cli/natural_order.h"
#include "clients/cli/quantity.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

const std::vector<Column>& Columns() {
  static const std::vector<Column> kColumns = {{"LABEL", Align::kRight},
                                               {"NAME"},
                                               {"KIND"},
                                               {"SHAPE"},
                                               {"RMS", Align::kRight},
                                               {"INLIERS", Align::kRight},
                                               {"OBSERVED", Align::kRight},
                                               {"POINTS", Align::kRight},
                                               {"SIZE"},
                                               {"ON"},
                                               {"MOTION"},
                                               {"SEEN"},
                                               {"POSITION m"}};
  return kColumns;
}

// "ROBOT:LINK", as rules and queries name a link.
std::string LinkOf(const pb::Attachment& attachment) {
  return absl::StrCat(attachment.robot(), ":", attachment.link());
}

// Adjacent coefficients of one name, such as the three of a direction.
struct CoefficientName {
  const char* name;
  int count;
};

// In PCL's order, see `ShapePart.coefficients`.
std::vector<CoefficientName> CoefficientNames(const pb::ShapePart& part) {
  switch (part.shape_case()) {
    case pb::ShapePart::kPlate:
    case pb::ShapePart::kHalfSpace:
      return {{"normal", 3}, {"d", 1}};
    case pb::ShapePart::kSphere:
      return {{"centre", 3}, {"radius", 1}};
    case pb::ShapePart::kCylinder:
      return {{"point on axis", 3}, {"axis", 3}, {"radius", 1}};
    case pb::ShapePart::kCone:
      return {{"apex", 3}, {"axis", 3}, {"half angle", 1}};
    default:
      return {};
  }
}

// "coefficients: centre 0.0219 0.0022 -0.0265, radius 0.0495", in metres and radians in the
// object's frame. Those of shapes that only a newer server has are named "others".
std::string CoefficientText(const pb::ShapePart& part) {
  std::string text;
  int next = 0;
  const auto append = [&](const char* name, int count) {
    const int end = std::min(next + count, part.coefficients_size());
    if (next < end) absl::StrAppend(&text, text.empty() ? "coefficients: " : ", ", name);
    for (; next < end; ++next) absl::StrAppend(&text, " ", FormatFixed(part.coefficients(next), 4));
  };
  for (const auto& [name, count] : CoefficientNames(part)) append(name, count);
  append("others", part.coefficients_size());
  return text;
}

std::vector<std::string> FitCells(const pb::ShapePart& part) {
  // For a completed body with a measured face (a support) the face's fit is more informative.
  if (!part.has_fit()) {
    return {part.role() == pb::PART_ROLE_COMPLETED ? "completed" : "", "", ""};
  }
  return {FormatLength(part.fit().rms_m()), absl::StrCat(part.fit().inlier_count()),
          FormatPercent(part.fit().observed_fraction())};
}

// The object's geometry besides its shapes.
std::string SurfaceText(const pb::Object& object) {
  std::int64_t triangles = 0;
  for (const auto& surface : object.surfaces()) triangles += surface.triangle_count();
  std::string text;
  if (triangles > 0) {
    absl::StrAppend(&text, "mesh of ", triangles, triangles == 1 ? " triangle" : " triangles");
  }
  if (!object.handles().empty()) {
    absl::StrAppend(&text, text.empty() ? "" : ", ", object.handles_size(),
                    object.handles_size() == 1 ? " handle" : " handles");
  }
  return text;
}

// The boxes of a mover say where it is, and nothing of its shape.
std::string BoxesText(const pb::Object& object) {
  return absl::StrCat(object.shapes_size(), object.shapes_size() == 1 ? " box" : " boxes");
}

std::string Position(const pb::Pose& pose) {
  return absl::StrCat(FormatFixed(pose.tx_m(), 3), " ", FormatFixed(pose.ty_m(), 3), " ",
                      FormatFixed(pose.tz_m(), 3));
}

// "at rest" of "at_rest".
std::string WordsOf(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

// A row with a text in the column of shapes.
TableRow ShapeRow(const std::string& text) {
  std::vector<std::string> cells = {"", "", "", text};
  cells.resize(Columns().size());
  return {cells};
}

TableRow PartRow(const pb::ShapePart& part) {
  std::vector<std::string> cells = {"", "", "", FormatShape(part)};
  for (std::string& cell : FitCells(part)) cells.push_back(std::move(cell));
  cells.resize(Columns().size());
  return {cells, CoefficientText(part)};
}

// The lines of an object; the first has its name.
void AddRows(const LabelledObject& labelled, std::vector<TableRow>& rows) {
  const pb::Object& object = *labelled.object;
  const std::size_t first = rows.size();
  if (object.kind() == pb::OBJECT_KIND_MOVER) {
    rows.push_back(ShapeRow(BoxesText(object)));
  } else {
    for (const pb::ShapePart& part : object.shapes()) rows.push_back(PartRow(part));
  }
  if (const std::string surface = SurfaceText(object); !surface.empty()) {
    rows.push_back(ShapeRow(surface));
  }
  if (rows.size() == first) rows.push_back({std::vector<std::string>(Columns().size())});
  std::vector<std::string>& cells = rows[first].cells;
  if (labelled.label >= 0) cells[0] = absl::StrCat(labelled.label);
  cells[1] = object.name();
  cells[2] = ShortName(object.kind());
  if (object.state() == pb::OBJECT_STATE_OCCLUDED || object.state() == pb::OBJECT_STATE_LOST) {
    absl::StrAppend(&cells[2], " (", ShortName(object.state()), ")");
  }
  if (object.point_count() > 0) cells[7] = absl::StrCat(object.point_count());
  if (object.has_bounds()) cells[8] = FormatSize(object.bounds().box());
  cells[9] = object.has_attachment() ? LinkOf(object.attachment()) : object.supported_by();
  cells[10] = WordsOf(ShortName(object.motion()));
  cells[11] = WordsOf(ShortName(object.visibility()));
  cells[12] = Position(object.x_world_object());
}

void PrintLine(const std::string& name, const std::string& value, std::ostream& out) {
  if (!value.empty()) out << name << std::string(14 - name.size(), ' ') << value << "\n";
}

// How much farther the part may extend where nothing was seen. A size of 0 is not compared.
std::string HiddenText(const pb::ShapePart& part, const std::array<double, 3>& size_m) {
  const pb::Box& hidden = part.hidden().box();
  const std::array<double, 3> sizes_m = {hidden.size_x_m(), hidden.size_y_m(), hidden.size_z_m()};
  double more_m = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (size_m[k] > 0) more_m = std::max(more_m, sizes_m[k] - size_m[k]);
  }
  return absl::StrCat(", up to ", FormatLength(more_m), " more unseen");
}

// A completed plate with a fit is a support: measured on top, completed below.
std::string PlateText(const pb::ShapePart& part) {
  const pb::Plate& plate = part.plate();
  std::string text = absl::StrCat("plate of ", plate.outline().vertices_size(), " corners, ");
  if (const int holes = plate.holes_size(); holes > 0) {
    absl::StrAppend(&text, holes, holes == 1 ? " hole, " : " holes, ");
  }
  absl::StrAppend(&text, FormatLength(plate.thickness_m()), " thick");
  if (part.has_hidden()) return text + HiddenText(part, {0, 0, plate.thickness_m()});
  if (part.role() == pb::PART_ROLE_COMPLETED && part.has_fit()) text += " (completed)";
  return text;
}

std::string VesselText(const pb::Vessel& vessel) {
  return absl::StrCat("vessel r ", FormatLength(vessel.foot_radius_m()), " to ",
                      FormatLength(vessel.rim_radius_m()), ", h ", FormatLength(vessel.height_m()),
                      ", ", FormatLength(vessel.depth_m()), " deep, wall ",
                      FormatLength(vessel.wall_thickness_m()));
}

}  // namespace

std::string FormatShape(const pb::ShapePart& part) {
  if (part.has_vessel()) return VesselText(part.vessel());
  switch (part.shape_case()) {
    case pb::ShapePart::kSphere:
      return absl::StrCat("sphere r ", FormatLength(part.sphere().radius_m()));
    case pb::ShapePart::kBox: {
      const pb::Box& box = part.box();
      std::string text = absl::StrCat("box ", FormatSize(box));
      if (part.has_hidden()) {
        text += HiddenText(part, {box.size_x_m(), box.size_y_m(), box.size_z_m()});
      }
      return text;
    }
    case pb::ShapePart::kCylinder:
      return absl::StrCat("cylinder r ", FormatLength(part.cylinder().radius_m()), ", l ",
                          FormatLength(part.cylinder().length_m()));
    case pb::ShapePart::kCone:
      return absl::StrCat("cone r ", FormatLength(part.cone().radius_bottom_m()), " to ",
                          FormatLength(part.cone().radius_top_m()), ", l ",
                          FormatLength(part.cone().length_m()));
    case pb::ShapePart::kCapsule:
      return absl::StrCat("capsule r ", FormatLength(part.capsule().radius_m()), ", l ",
                          FormatLength(part.capsule().length_m()));
    case pb::ShapePart::kHalfSpace:
      return "half space";
    case pb::ShapePart::kPlate:
      return PlateText(part);
    case pb::ShapePart::kConvex:
      return "convex";
    case pb::ShapePart::kMesh:
      return "mesh";
    case pb::ShapePart::SHAPE_NOT_SET:
      break;
  }
  return "";
}

std::string FormatFacts(const pb::SensorFacts& facts) {
  std::vector<std::string> texts;
  if (facts.motion() != pb::MOTION_UNSPECIFIED) texts.push_back(WordsOf(ShortName(facts.motion())));
  if (facts.visibility() != pb::VISIBILITY_UNSPECIFIED) {
    texts.push_back(WordsOf(ShortName(facts.visibility())));
  }
  if (facts.has_identity_certain() && !facts.identity_certain()) {
    texts.emplace_back("identity not certain");
  }
  if (!facts.carried_by().empty()) texts.push_back(absl::StrCat("carried by ", facts.carried_by()));
  return texts.empty() ? "no longer followed" : absl::StrJoin(texts, ", ");
}

void PrintObjects(const std::vector<LabelledObject>& objects, TableStyle style, std::ostream& out) {
  std::vector<TableRow> rows;
  for (const LabelledObject& object : objects) AddRows(object, rows);
  if (rows.empty()) {
    out << "no objects\n";
    return;
  }
  PrintTable(Columns(), rows, style, out);
}

void PrintObjects(const google::protobuf::RepeatedPtrField<pb::Object>& objects, TableStyle style,
                  std::ostream& out) {
  std::vector<LabelledObject> unlabelled;
  for (const pb::Object& object : objects) unlabelled.push_back({&object});
  std::stable_sort(unlabelled.begin(), unlabelled.end(),
                   [](const LabelledObject& a, const LabelledObject& b) {
                     return NaturalLess(a.object->name(), b.object->name());
                   });
  PrintObjects(unlabelled, style, out);
}

void PrintObjectDetails(const pb::Object& object, TableStyle style, std::ostream& out) {
  PrintObjects(std::vector<LabelledObject>{{&object}}, style, out);
  out << "\n";
  PrintLine("uid", object.uid(), out);
  PrintLine("owner", ShortName(object.owner()), out);
  PrintLine("state", ShortName(object.state()), out);
  PrintLine("motion", WordsOf(ShortName(object.motion())), out);
  PrintLine("visibility", WordsOf(ShortName(object.visibility())), out);
  if (object.has_identity_certain() && !object.identity_certain()) {
    PrintLine("identity", "not certain: it may be another object of the same shape", out);
  }
  PrintLine("pose", FormatPose(object.x_world_object()), out);
  PrintLine("carried by", object.carried_by(), out);
  if (object.has_attachment()) {
    PrintLine("attached to", LinkOf(object.attachment()), out);
    PrintLine("pose in link", FormatPose(object.attachment().x_link_object()), out);
    PrintLine("may touch", absl::StrJoin(object.attachment().touch_links(), ", "), out);
    PrintLine("supported by", object.supported_by(), out);
  }
  if (object.margin_m() != 0) PrintLine("margin", FormatLength(object.margin_m()), out);
  if (object.has_reachable()) PrintLine("reachable", object.reachable() ? "yes" : "no", out);
  if (object.has_last_observed()) {
    PrintLine("last observed", google::protobuf::util::TimeUtil::ToString(object.last_observed()),
              out);
  }
  PrintLine("revisions",
            absl::StrCat("created ", object.create_revision(), ", geometry ",
                         object.geometry_revision(), ", pose ", object.pose_revision()),
            out);
}

}  // namespace cwm::cli
