// Assesses grasp attempts with a server: reachability of the grasp, and the contacts of the pads.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "clients/grasp/gripper.h"
#include "cwm/world.h"

namespace cwm::grasp {

struct GraspQuery {
  Gripper gripper = {};
  double friction = 0.4;
  double approach_m = 0.10;    // length of the open gripper's straight approach along z of G
  double clearance_m = 0.002;  // kept during the approach, also from the target
};

struct Attempt {
  Eigen::Isometry3d X_WG = Eigen::Isometry3d::Identity();
  std::string target = {};  // the object to grasp; empty: whatever both pads touch first
};

// The first contact of a flat pad with the target.
struct Contact {
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // outward
  double angle_rad = 0;                                // between the normal and the closing line
  int part = 0;                                        // of the target
  // How certain its place is: kBounded if the pad first passes space that no sensor saw and into
  // which the target may extend, kSurfaceOnly on an open surface.
  api::Trust trust = api::Trust::kExact;
};

enum class GraspFailure {
  kNone,
  kBlocked,  // something obstructs the open gripper or its closing fingers
  kMissed,   // a pad touches nothing, or another object than the target
  kSlipped,  // a surface is tilted by more than friction can hold
};

struct Assessment {
  GraspFailure failure = GraspFailure::kNone;
  std::string obstacle = {};             // the obstacle, or the object touched; empty: unknown
  double clearance_m = 0;                // of the open gripper during its approach, up to 0.02 m
  std::string held_object = {};          // the object between the pads
  std::array<Contact, 2> contacts = {};  // of the finger at -x, then of that at +x
  double width_m = 0;                    // between the pads once both touch something
  double off_centre_m = 0;               // how far the object is pushed until both pads touch it
};

// One assessment per attempt, in the world that the view pins. Checks first that the open gripper
// has room at the grasp, then its motions (certified, not sampled), then that the closing fingers
// touch nothing but the target, and finally rays from 15 places of each pad: the middle ray must
// hit, and the first place that touches the target must hold it within friction.
std::vector<Assessment> Assess(const api::WorldView& world, const GraspQuery& query,
                               const std::vector<Attempt>& attempts);

}  // namespace cwm::grasp
