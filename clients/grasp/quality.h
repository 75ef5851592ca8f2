// The quality of a collision-free grasp. Each factor is from above 0 to 1, the best; the score is
// their weighted geometric mean, so that many good factors cannot compensate a bad one.
#pragma once

#include "clients/grasp/assess.h"
#include "clients/grasp/candidate.h"
#include "cwm/objects.h"

namespace cwm::grasp {

struct Factors {
  // The distance of the worse contact from slipping: 1 if the surface is perpendicular to the
  // closing line.
  double antipodal = 1;
  // Falls with the lever between the closing line and the object's middle, at which its weight
  // acts.
  double centred = 1;
  // The share that a sensor observed of the parts that the pads touch, the lesser of both:
  // completed parts, and faces beyond which the object may go on unseen, are guesses. Parts put by
  // users count as observed.
  double observed = 1;
  // The clearance of the open gripper during its approach, up to 10 mm, since scans and robots are
  // off by a few mm.
  double clearance = 1;
  // The room between pads and surfaces before closing, relative to three standard deviations of the
  // width.
  double width = 1;
  // Approaching from above keeps arm and palm away from the support and other objects.
  double upright = 1;
  // Falls with the distance that the object is pushed before both pads hold it.
  double still = 1;
};

Factors FactorsOf(const Candidate& candidate, const Assessment& assessment,
                  const api::Object& object, const GraspQuery& query);

double ScoreOf(const Factors& factors);

}  // namespace cwm::grasp
