#include "collision/robot/urdf.h"

#include <array>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "collision/robot/collision_reader.h"
#include "collision/robot/kinematic_tree.h"
#include "collision/robot/mimic.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

absl::StatusOr<JointKind> ReadKind(const XmlElement& joint) {
  for (const JointKind kind : {JointKind::kFixed, JointKind::kRevolute, JointKind::kContinuous,
                               JointKind::kPrismatic, JointKind::kPlanar, JointKind::kFloating}) {
    if (joint.Has("type") && *joint.Text("type") == NameOf(kind)) return kind;
  }
  return joint.FaultOf("type",
                       "must be fixed, revolute, continuous, prismatic, planar or floating");
}

bool HasAxis(JointKind kind) { return kind != JointKind::kFixed && kind != JointKind::kFloating; }
bool HasLimits(JointKind kind) {
  return kind == JointKind::kRevolute || kind == JointKind::kPrismatic;
}

// The first of several axes counts, as in ROS.
absl::StatusOr<Vector3> ReadAxis(const XmlElement& joint, std::vector<std::string>& left_out) {
  const std::vector<XmlElement> axes = joint.Children("axis");
  if (axes.empty()) return Vector3::UnitX();
  const absl::StatusOr<Vector3> xyz = axes.front().VectorOr("xyz", Vector3::UnitX());
  if (!xyz.ok()) return xyz.status();
  const Vector3 unit = xyz->stableNormalized();  // squares of very long axes overflow
  if (!(unit.norm() > 0.5)) return axes.front().FaultOf("xyz", "must have positive length");
  if (axes.size() > 1) {
    left_out.push_back(absl::StrCat(joint.place(), ": has ", axes.size(),
                                    " elements <axis>; the first counts, remove the others"));
  }
  return unit;
}

absl::Status ReadRange(const XmlElement& limit, JointLimits& limits) {
  const absl::StatusOr<double> lower = limit.NumberOr("lower", 0);
  if (!lower.ok()) return lower.status();
  const absl::StatusOr<double> upper = limit.NumberOr("upper", 0);
  if (!upper.ok()) return upper.status();
  if (*lower > *upper) {
    return limit.FaultOf("lower", absl::StrCat("must be at most the upper limit, ", *upper));
  }
  limits.lower = *lower;
  limits.upper = *upper;
  return absl::OkStatus();
}

absl::Status ReadMaximum(const XmlElement& limit, const char* attribute,
                         std::optional<double>& maximum) {
  if (!limit.Has(attribute)) return absl::OkStatus();
  const absl::StatusOr<double> value = limit.Number(attribute);
  if (!value.ok()) return value.status();
  if (*value < 0) return limit.FaultOf(attribute, "must not be negative");
  maximum = *value;
  return absl::OkStatus();
}

absl::StatusOr<JointLimits> ReadLimits(const XmlElement& joint, JointKind kind) {
  const absl::StatusOr<std::optional<XmlElement>> limit = joint.AtMostOne("limit");
  if (!limit.ok()) return limit.status();
  JointLimits limits;
  if (!limit->has_value()) {
    if (!HasLimits(kind)) return limits;
    return joint.Fault(
        absl::StrCat("must have an element <limit>, being ", std::string(NameOf(kind))));
  }
  if (HasLimits(kind)) {
    if (absl::Status status = ReadRange(**limit, limits); !status.ok()) return status;
  }
  absl::Status status = ReadMaximum(**limit, "velocity", limits.max_velocity);
  if (status.ok()) status = ReadMaximum(**limit, "effort", limits.max_effort);
  if (!status.ok()) return status;
  return limits;
}

absl::StatusOr<std::optional<Mimic>> ReadMimic(const XmlElement& joint) {
  const absl::StatusOr<std::optional<XmlElement>> element = joint.AtMostOne("mimic");
  if (!element.ok()) return element.status();
  if (!element->has_value()) return std::optional<Mimic>();
  const absl::StatusOr<std::string> source = (*element)->Name("joint");
  if (!source.ok()) return source.status();
  const absl::StatusOr<double> multiplier = (*element)->NumberOr("multiplier", 1);
  if (!multiplier.ok()) return multiplier.status();
  const absl::StatusOr<double> offset = (*element)->NumberOr("offset", 0);
  if (!offset.ok()) return offset.status();
  return std::optional<Mimic>({*source, *multiplier, *offset});
}

absl::StatusOr<std::string> ReadEnd(const XmlElement& joint, const char* tag) {
  const absl::StatusOr<XmlElement> end = joint.ExactlyOne(tag);
  if (!end.ok()) return end.status();
  return end->Name("link");
}

absl::Status ReadEnds(const XmlElement& element, Joint& joint) {
  absl::StatusOr<std::string> parent = ReadEnd(element, "parent");
  if (!parent.ok()) return parent.status();
  absl::StatusOr<std::string> child = ReadEnd(element, "child");
  if (!child.ok()) return child.status();
  joint.parent = *std::move(parent);
  joint.child = *std::move(child);
  return absl::OkStatus();
}

// Reads the parts of a joint that depend on its kind.
absl::Status ReadMotion(const XmlElement& element, Joint& joint,
                        std::vector<std::string>& left_out) {
  if (HasAxis(joint.kind)) {
    const absl::StatusOr<Vector3> axis_J = ReadAxis(element, left_out);
    if (!axis_J.ok()) return axis_J.status();
    joint.axis_J = *axis_J;
  }
  if (joint.kind == JointKind::kFixed) return absl::OkStatus();
  const absl::StatusOr<JointLimits> limits = ReadLimits(element, joint.kind);
  if (!limits.ok()) return limits.status();
  joint.limits = *limits;
  absl::StatusOr<std::optional<Mimic>> mimic = ReadMimic(element);
  if (!mimic.ok()) return mimic.status();
  joint.mimic = *std::move(mimic);
  return absl::OkStatus();
}

absl::StatusOr<Joint> ReadJoint(const XmlElement& element, std::vector<std::string>& left_out) {
  Joint joint;
  absl::StatusOr<std::string> name = ExpandedName(element, "name");
  if (!name.ok()) return name.status();
  joint.name = *std::move(name);
  const absl::StatusOr<JointKind> kind = ReadKind(element);
  if (!kind.ok()) return kind.status();
  joint.kind = *kind;
  if (absl::Status status = ReadEnds(element, joint); !status.ok()) return status;
  const absl::StatusOr<Pose> X_PJ = ReadOrigin(element);
  if (!X_PJ.ok()) return X_PJ.status();
  joint.X_PJ = *X_PJ;
  if (absl::Status status = ReadMotion(element, joint, left_out); !status.ok()) return status;
  return joint;
}

class UrdfReader {
 public:
  UrdfReader(std::size_t bytes, const MeshSource& source, const RobotLimits& limits,
             std::stop_token stop, const LinkValues& scale)
      : limits_(limits),
        stop_(std::move(stop)),
        scale_(scale),
        budget_(limits),
        collisions_(source, limits, budget_) {
    budget_.AddFile(bytes);
  }

  absl::StatusOr<RobotDescription> Read(const XmlElement& root) {
    if (root.tag() != "robot") {
      return root.Fault(
          absl::StrCat("has the root element <", std::string(root.tag()), ">, must have <robot>"));
    }
    if (absl::Status status = ReadName(root); !status.ok()) return status;
    // Meshes are read last, so that a robot that is refused for another reason costs less.
    const std::vector<XmlElement> children = root.Children();
    if (absl::Status status = ReadTree(children); !status.ok()) return status;
    if (absl::Status status = budget_.TakeLinks(robot_.links.size()); !status.ok()) {
      return ExcessAt("urdf", std::string(status.message()));
    }
    if (absl::Status status = ReadCollisions(children); !status.ok()) return status;
    return std::move(robot_);
  }

 private:
  absl::Status ReadTree(const std::vector<XmlElement>& children) {
    for (const XmlElement& child : children) {
      if (stop_.stop_requested()) return absl::CancelledError();
      absl::Status status;
      if (child.tag().starts_with("xacro:")) {
        status = child.Fault("must be expanded by xacro before it is loaded");
      }
      if (child.tag() == "link") status = AddLink(child);
      if (child.tag() == "joint") status = AddJoint(child);
      if (!status.ok()) return status;
    }
    if (absl::Status status = MakeKinematicTree(robot_).status(); !status.ok()) return status;
    DropUnknownMimics();
    return ResolveMimics(robot_).status();
  }

  absl::Status ReadName(const XmlElement& root) {
    if (root.Has("name") && root.Text("name")->empty()) {
      robot_.name = "robot";
      robot_.left_out.emplace_back(
          "urdf: robot name is \"\": the robot is called \"robot\", give it a name");
      return absl::OkStatus();
    }
    absl::StatusOr<std::string> name = root.Name("name");
    if (!name.ok()) return name.status();
    robot_.name = *std::move(name);
    return absl::OkStatus();
  }

  // A joint that follows one that the robot does not have moves by itself, as in MoveIt.
  void DropUnknownMimics() {
    std::set<std::string_view> names;
    for (const Joint& joint : robot_.joints) names.insert(joint.name);
    for (Joint& joint : robot_.joints) {
      if (!joint.mimic || names.contains(joint.mimic->joint)) continue;
      robot_.left_out.push_back(absl::StrCat(
          "urdf: joint ", Quoted(joint.name), ": mimic joint is ", Quoted(joint.mimic->joint),
          ", which the robot does not have: the joint moves by itself; correct the name or remove "
          "<mimic>"));
      joint.mimic.reset();
    }
  }

  absl::Status AddLink(const XmlElement& element) {
    if (robot_.links.size() == static_cast<std::size_t>(limits_.max_links)) {
      return ExcessAt("urdf", absl::StrCat("must have at most ", limits_.max_links, " links"));
    }
    absl::StatusOr<std::string> name = ExpandedName(element, "name");
    if (!name.ok()) return name.status();
    robot_.links.push_back({.name = *std::move(name), .collisions = {}});
    return absl::OkStatus();
  }

  absl::Status AddJoint(const XmlElement& element) {
    absl::StatusOr<Joint> joint = ReadJoint(element, robot_.left_out);
    if (!joint.ok()) return joint.status();
    robot_.joints.push_back(*std::move(joint));
    return absl::OkStatus();
  }

  absl::Status ReadCollisions(const std::vector<XmlElement>& children) {
    auto link = robot_.links.begin();
    for (const XmlElement& child : children) {
      if (child.tag() != "link") continue;
      const double scale = ValueOf(scale_, link->name, 1);
      for (const XmlElement& collision : child.Children("collision")) {
        if (stop_.stop_requested()) return absl::CancelledError();
        absl::StatusOr<CollisionGeometry> read =
            collisions_.Read(collision, link->collisions.size(), scale);
        if (!read.ok()) return read.status();
        link->collisions.push_back(*std::move(read));
      }
      ++link;
    }
    return absl::OkStatus();
  }

  const RobotLimits& limits_;
  const std::stop_token stop_;
  const LinkValues& scale_;
  PreparedBudget budget_;
  CollisionReader collisions_;
  RobotDescription robot_;
};

}  // namespace

absl::StatusOr<RobotDescription> ReadUrdf(std::string_view xml, const MeshSource& meshes,
                                          const RobotLimits& limits, const std::stop_token& stop,
                                          const LinkValues& scale) {
  const absl::StatusOr<XmlDocument> document =
      XmlDocument::Parse(XmlDocument::WithoutTrailingZeros(xml), "urdf", limits.max_xml_bytes);
  if (!document.ok()) return document.status();
  return UrdfReader(xml.size(), meshes, limits, stop, scale).Read(document->root());
}

}  // namespace cwm::collision
