// Objects that frames removed lately, which may come back under their names, and the objects that
// may have been swapped with another one of their shape.
#pragma once

#include <chrono>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "collision/world/world_snapshot.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/shape_signature.h"

namespace cwm::server {

// Not thread safe.
class GoneObjects {
 public:
  // A frame removed the object. Times are stamps of frames.
  void Add(const collision::WorldObjectPtr& object, perception::Stamp now);
  // Forgets what is gone for longer than `time`.
  void ForgetAfter(std::chrono::nanoseconds time, perception::Stamp now);

  std::vector<collision::WorldObjectPtr> objects() const;

  // The object is seen again, after it was gone or lost. `lost` are those that are in the world but
  // that no sensor has seen since they moved. If any of these, or of what is gone, is of its shape,
  // nobody knows which of them it is. Returns the names of objects whose identity is uncertain by
  // that: such twins stay so, since nothing that a depth camera sees tells them apart, until they
  // are removed for good.
  std::vector<std::string> SeenAgain(const collision::WorldObject& object,
                                     std::span<const collision::WorldObjectPtr> lost);

  bool IsCertain(const std::string& name) const { return !uncertain_.contains(name); }

 private:
  struct Gone {
    collision::WorldObjectPtr object;
    perception::ShapeSignature signature;
    perception::Stamp when;
  };
  std::vector<Gone> gone_;  // oldest first
  std::set<std::string> uncertain_;
};

}  // namespace cwm::server
