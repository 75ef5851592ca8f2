// Named places at which a test ends the process as kill -9 does. The environment names one of them
// and the pass at which it kills: CWM_FAILPOINT=after-commit:3. Without it a place costs one load.
#pragma once

#include <atomic>
#include <string_view>

namespace cwm::server {
namespace internal {

extern std::atomic<bool> fail_point_is_set;
void PassFailPoint(std::string_view name);

}  // namespace internal

// The places are named where they are passed: before-record, after-commit, after-publish,
// blob-renamed, checkpoint, compaction, migration, backup.
inline void FailPoint(std::string_view name) {
  if (internal::fail_point_is_set.load(std::memory_order_relaxed)) internal::PassFailPoint(name);
}

// Sets the place as CWM_FAILPOINT does, for children of a test that are forked without exec. False
// if the text is not NAME:PASS with a positive number.
bool SetFailPoint(std::string_view name_and_pass);

}  // namespace cwm::server
