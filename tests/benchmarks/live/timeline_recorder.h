// Plays frames to a server, and records what it publishes beside the truth.
#pragma once

#include <optional>
#include <vector>

#include "perception/simulation/sequence_script.h"
#include "tests/benchmarks/live/live_world.h"
#include "tests/benchmarks/live/timeline.h"

namespace cwm::benchmarks {

// Everything that was published and was true at the frames that were processed.
struct Recording {
  Timeline timeline = {};
  std::vector<PublishedObjects> published = {};  // by moment
  std::vector<std::size_t> frames = {};          // by moment, the index of the frame
  std::vector<FrameAnswer> answers = {};         // by frame
};

// Objects of a revision that are neither supports nor a user's.
std::vector<PublishedThing> ThingsOf(const PublishedObjects& published);

// The scene's objects from `first_thing` on, as a frame has them.
std::vector<TrueThing> TruthOf(const perception::SequenceScript& script, std::size_t first_thing,
                               const TrueFrame& frame);

// Sends the frames at the pace of their stamps, beginning now; empty if the stream ends. The stamps
// are those of the frames, whose things are those from `first_thing` on.
std::optional<Recording> Record(LiveWorld& world, LiveSensor& sensor,
                                const perception::SequenceScript& script, std::size_t first_thing,
                                const std::vector<TrueFrame>& frames);

// The identity for an absent pose.
Pose PoseOf(const v1::Pose& pose);

// A box with its pose, for distances from what is published.
struct PlacedBox {
  Pose X_WB = Pose::Identity();
  Vector3 half_size_m = Vector3::Zero();

  double volume_m3() const { return 8 * half_size_m.prod(); }
};
// The boxes of an object that is made of boxes, else its bounds.
std::vector<PlacedBox> BoxesOf(const v1::Object& object);
// 0 inside.
double Distance_m(const PlacedBox& box, const Vector3& p_W);

}  // namespace cwm::benchmarks
