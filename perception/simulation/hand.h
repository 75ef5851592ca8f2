// A hand of capsules that pushes, takes and puts objects of a script.
#pragma once

#include <cstddef>
#include <string>

#include "perception/simulation/sequence_script.h"

namespace cwm::perception {

// A right hand with its forearm, about 0.46 m long: four fingers, a thumb, the palm, the wrist. Its
// frame H has its origin between the tips of fingers and thumb and its z axis from the forearm to
// the tips; y points from the thumb to the fingers, which are `opening_m` apart inside.
SimulatedObject MakeHand(double opening_m);

// How a hand comes and goes.
struct HandReach {
  std::string name = "hand";
  Vector3 from_W = Vector3::Zero();  // its tips, before it comes and after it went
  double travel_s = 0.8;             // from there to the object, and back
};

// A place 0.6 m above the object and a little to its side, where a hand may come from.
Vector3 ReachFrom(const SequenceScript& script, std::size_t object, double time_s);

// Add a hand and the events of an object to the script. The object must be there and at rest at
// `time_s`, and have no later events. The hand is there from `travel_s` before until `travel_s`
// after its contact.

// The hand grasps the object from above at `time_s` and carries it away; then both are gone.
void TakeByHand(std::size_t object, double time_s, const HandReach& reach, SequenceScript& script);

// The hand brings the object, which was not there before, and puts it down at X_WO at `time_s`.
void PutByHand(std::size_t object, double time_s, const Pose& X_WO, const HandReach& reach,
               SequenceScript& script);

// The hand pushes the object to X_WO from behind, in the given time.
void PushByHand(std::size_t object, const TimeInterval& during, const Pose& X_WO,
                const HandReach& reach, SequenceScript& script);

}  // namespace cwm::perception
