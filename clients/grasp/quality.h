// How good a grasp that is free is. Each factor is a share, 1 the best, none is 0; the score is their
// weighted geometric mean, so that one bad factor is not made up for by many good ones.
#pragma once

#include "clients/grasp/assess.h"
#include "clients/grasp/candidate.h"
#include "cwm/v1/world.pb.h"

namespace cwm::grasp {

struct Factors {
  // How far the worse contact is from slipping: 1 when it is met square on.
  double antipodal = 1;
  // The object's weight pulls at the lever between the closing line and its middle.
  double centred = 1;
  // Share of the touched parts that a sensor saw: what was completed is a guess. What users put is
  // taken for true.
  double observed = 1;
  // Room that the open gripper keeps on its way, up to 10 mm: scans and robots are a few mm off.
  double clearance = 1;
  // Room between pads and surfaces before they close, against three standard deviations of the width.
  double width = 1;
  // Coming from above keeps arm and palm off the support and the neighbours.
  double upright = 1;
  // How little the object is pushed before both pads hold it.
  double still = 1;
};

Factors FactorsOf(const Candidate& candidate, const Assessment& assessment,
                  const cwm::v1::Object& object, const Question& question);

double ScoreOf(const Factors& factors);

}  // namespace cwm::grasp
