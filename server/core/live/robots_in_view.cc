#include "server/core/live/robots_in_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"

namespace cwm::server {
namespace {

using collision::JointKind;
using collision::ModelLink;
using collision::WorldRobot;
using perception::KnownBody;
using perception::LinkAtStamp;
using perception::StateSource;

// How far a joint can shift the origin of the link below it.
double TravelOf_m(const collision::RobotModel& model, const ModelLink& link) {
  if (link.kind == JointKind::kPrismatic) {
    const collision::Variable& variable = model.variables[static_cast<std::size_t>(link.variable)];
    const double at_lower = link.multiplier * variable.lower + link.offset;
    const double at_upper = link.multiplier * variable.upper + link.offset;
    return std::max(std::abs(at_lower), std::abs(at_upper));
  }
  const bool turns = link.kind == JointKind::kFixed || link.kind == JointKind::kRevolute ||
                     link.kind == JointKind::kContinuous;
  return turns ? 0 : std::numeric_limits<double>::infinity();
}

std::shared_ptr<const RobotShape> MakeShape(const collision::RobotGeometry& robot) {
  std::vector<perception::LinkGeometry> geometries;
  for (std::size_t i = 0; i < robot.geometry->parts.size(); ++i) {
    const collision::PreparedPart& part = robot.geometry->parts[i];
    geometries.push_back({.link = robot.link_of_part[i], .X_LG = part.X_OP, .shape = &part.shape});
  }
  const collision::RobotModel& model = *robot.model;
  RobotShape shape{.surface = std::make_shared<const perception::RobotSurface>(
                       geometries, static_cast<int>(model.links.size())),
                   .tree = {},
                   .reach_B = {}};
  perception::LinkTree tree;
  std::vector<perception::ReachJoint> joints;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const ModelLink& link = model.links[i];
    const int parent = i == 0 ? -1 : link.parent;
    tree.names.push_back(link.name);
    tree.parents.push_back(parent);
    joints.push_back({.parent = parent,
                      .X_PL = link.X_PJ,
                      .moves = link.kind != JointKind::kFixed,
                      .travel_m = TravelOf_m(model, link)});
  }
  shape.tree = std::make_shared<const perception::LinkTree>(std::move(tree));
  shape.reach_B = perception::ReachOf(*shape.surface, joints);
  return std::make_shared<const RobotShape>(std::move(shape));
}

// The robot as the world has it, at rest.
std::vector<LinkAtStamp> LinksOf(const WorldRobot& robot) {
  std::vector<LinkAtStamp> links;
  for (const Pose& X_WL : robot.X_WL) links.push_back({.X_WL = X_WL});
  return links;
}

bool IsStateKnown(const WorldRobot& robot) {
  return robot.model().variables.empty() || robot.state_revision != robot.create_revision;
}

RobotAtFrame AtStamp(const collision::WorldRobotPtr& robot, const RobotStates& states,
                     perception::Stamp stamp) {
  RobotAtFrame at{
      .robot = robot, .is_told = states.IsTold(*robot, stamp), .state = {}, .links = {}};
  if (at.is_told) {
    at.state = states.StateAt(*robot, stamp);
  } else if (IsStateKnown(*robot)) {
    at.state = {.source = StateSource::kHeld,
                .values = robot->state,
                .speeds_per_s = std::vector<double>(robot->state.size(), 0.0),
                .X_WB = robot->X_WB};
    at.links = LinksOf(*robot);
    return at;
  } else {
    at.state.reason = "ROBOT_STATE_MISSING";
  }
  at.links = at.state.source == StateSource::kMissing ? LinksOf(*robot)
                                                      : LinksAt(robot->model(), at.state);
  return at;
}

std::string PreparedText(const RobotAtFrame& at) {
  return absl::StrCat("the robot \"", at.robot->name,
                      "\" is new, and its shapes are being prepared for this sensor's frames, "
                      "which takes up to a second: until then nothing changes");
}

std::string WrongText(const RobotAtFrame& at, const perception::RobotSighting& sighting) {
  const ModelLink& link = at.robot->model().links[static_cast<std::size_t>(sighting.through_link)];
  return absl::StrCat("rays pass through ", at.robot->name, "/", link.name, " in ",
                      sighting.through_pixels, " pixels (",
                      std::lround(100 * sighting.through_share),
                      " % of those that must meet it): its state is late, or the calibration of "
                      "the sensor or of the robot is wrong");
}

}  // namespace

std::shared_ptr<const RobotShape> RobotShapes::Of(
    const std::shared_ptr<const collision::RobotGeometry>& robot) {
  const std::lock_guard lock(mutex_);
  const auto is_made = [](const Entry& entry) {
    return entry.shape.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  };
  // The end of a thread that still runs would be waited for.
  std::erase_if(entries_,
                [&](const Entry& entry) { return entry.robot.expired() && is_made(entry); });
  for (const Entry& entry : entries_) {
    if (entry.robot.lock() == robot) return is_made(entry) ? entry.shape.get() : nullptr;
  }
  entries_.push_back(
      {robot, std::async(std::launch::async, [robot] { return MakeShape(*robot); })});
  return nullptr;
}

std::vector<perception::RobotLinks> LinksInView(std::span<const RobotAtFrame> robots,
                                                RobotShapes& shapes) {
  std::vector<perception::RobotLinks> all;
  for (const RobotAtFrame& at : robots) {
    if (at.state.source == StateSource::kMissing) continue;
    const auto shape = shapes.Of(at.robot->robot);
    if (shape == nullptr) continue;
    all.push_back({.robot = at.robot->name,
                   .tree = shape->tree,
                   .surface = shape->surface,
                   .links = at.links});
  }
  return all;
}

std::string MissingStateText(const RobotAtFrame& at) {
  const std::string& robot = at.robot->name;
  if (at.state.reason != "ROBOT_STATE_STALE") {
    return absl::StrCat("there is no state of the robot \"", robot,
                        "\" for the frame's stamp (StreamRobotStates tells them)");
  }
  if (at.state.late > RobotStates::kMaxExtrapolation) {
    const auto late = std::chrono::ceil<std::chrono::milliseconds>(at.state.late);
    return absl::StrCat("the newest state of the robot \"", robot, "\" is ", late.count(),
                        " ms older than the frame, must be at most ",
                        RobotStates::kMaxExtrapolation.count(), " ms older");
  }
  return absl::StrCat("the states of the robot \"", robot,
                      "\" before and after the frame's stamp are too far apart, must be at most ",
                      RobotStates::kMaxGap.count(), " ms apart");
}

std::vector<RobotAtFrame> RobotsAt(const collision::WorldSnapshot& snapshot,
                                   const RobotStates& states, perception::Stamp stamp) {
  std::vector<RobotAtFrame> robots;
  for (const collision::WorldRobotPtr& robot : snapshot.robots()) {
    robots.push_back(AtStamp(robot, states, stamp));
  }
  return robots;
}

std::vector<KnownBody> BodiesAt(const BodyTable& table, std::span<const RobotAtFrame> robots) {
  std::vector<KnownBody> bodies = table.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const collision::Attachment* const held = table.objects[i]->attachment.get();
    if (held == nullptr) continue;
    const auto carrier = std::ranges::find_if(
        robots, [&](const RobotAtFrame& at) { return at.robot->name == held->robot; });
    if (carrier == robots.end()) continue;
    const std::optional<int> link = carrier->robot->model().FindLink(held->link);
    if (!link.has_value()) continue;
    bodies[i].X_WB = carrier->links[static_cast<std::size_t>(*link)].X_WL * held->X_LO;
  }
  return bodies;
}

RobotsInView::View& RobotsInView::ViewOf(const WorldRobot& robot, RobotShapes& shapes) {
  View& view = views_[robot.name];
  if (view.robot != robot.robot || view.shape == nullptr) {
    view.robot = robot.robot;
    view.shape = shapes.Of(robot.robot);
    view.view = std::make_unique<perception::RobotView>(
        view.shape == nullptr ? nullptr : view.shape->surface);
  }
  return view;
}

RobotsSeen RobotsInView::Mask(const perception::RobotFrame& frame,
                              std::chrono::nanoseconds exposure, const BodyTable& table,
                              std::span<const KnownBody> bodies,
                              std::span<const RobotAtFrame> robots, RobotShapes& shapes) {
  RobotsSeen seen;
  std::erase_if(views_, [&](const auto& each) {
    return std::ranges::none_of(
        robots, [&](const RobotAtFrame& at) { return at.robot->name == each.first; });
  });
  for (const RobotAtFrame& at : robots) {
    View& view = ViewOf(*at.robot, shapes);
    std::vector<perception::CarriedAtStamp> carried;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const collision::Attachment* const held = table.objects[i]->attachment.get();
      if (held == nullptr || held->robot != at.robot->name) continue;
      const std::optional<int> link = at.robot->model().FindLink(held->link);
      if (link.has_value()) carried.push_back({.body = &bodies[i], .link = *link});
    }
    // Nobody knows where a robot may be whose shapes are still being made.
    const bool is_prepared = view.shape != nullptr;
    const StateSource source = is_prepared ? at.state.source : StateSource::kMissing;
    perception::ReachSphere reach_W;
    if (is_prepared) reach_W = view.shape->reach_B;
    reach_W.center = at.robot->X_WB * reach_W.center;
    const double late_s = std::chrono::duration<double>(at.state.late).count();
    perception::RobotMargins margins;
    margins.exposure_s = std::chrono::duration<double>(exposure).count();
    const perception::RobotSighting sighting = view.view->Mask(
        frame, {.source = source, .late_s = late_s, .links = at.links, .reach_W = reach_W}, carried,
        margins);
    perception::MergeMask(sighting.mask, *frame.camera, seen.mask);
    if (at.is_told) {
      seen.state_age_ms = std::max(seen.state_age_ms.value_or(0), 1e3 * late_s);
    }
    if (!is_prepared) seen.is_prepared = false;
    if (sighting.fault != perception::RobotStateFault::kNone) {
      seen.at_fault.push_back(at.robot->name);
    }
    if (!seen.reason.empty()) continue;  // the first robot's fault is told
    if (sighting.fault == perception::RobotStateFault::kMissing) {
      seen.reason = is_prepared ? at.state.reason : "ROBOT_STATE_MISSING";
      seen.message = is_prepared ? MissingStateText(at) + ": nothing within its reach is added"
                                 : PreparedText(at);
    } else if (sighting.fault == perception::RobotStateFault::kWrong) {
      seen.reason = "ROBOT_STATE_WRONG";
      seen.message = WrongText(at, sighting);
    }
  }
  return seen;
}

}  // namespace cwm::server
