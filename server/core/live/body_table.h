// The objects of a snapshot as the known bodies of live views, with numbers that stay.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "perception/live/known_body.h"
#include "server/core/world.h"

namespace cwm::server {

// Immutable.
struct BodyTable {
  SnapshotPtr snapshot = {};
  std::vector<perception::KnownBody> bodies = {};       // ordered by name
  std::vector<collision::WorldObjectPtr> objects = {};  // one per body

  // nullptr if there is none.
  collision::WorldObjectPtr Find(perception::BodyId id) const;
};

// Numbers the objects of one world. An object keeps its number until it is removed; a number is
// given again only after all others were. Thread safe.
class BodyNumbers {
 public:
  // Unseen space is no body, nor are objects beyond the first 65,535. The last table is kept.
  std::shared_ptr<const BodyTable> TableOf(const SnapshotPtr& snapshot);

 private:
  struct Known {
    collision::Revision create_revision;
    perception::BodyId id = perception::kNoBody;
    bool is_present = false;
  };
  perception::BodyId NextFree();

  std::mutex mutex_;
  std::shared_ptr<const BodyTable> table_;
  std::map<std::string, Known, std::less<>> known_;
  std::vector<bool> is_taken_ = std::vector<bool>(perception::kNoBody, false);
  perception::BodyId last_ = 0;
};

}  // namespace cwm::server
