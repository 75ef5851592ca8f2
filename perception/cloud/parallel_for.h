// Loops over independent pieces of work on a few threads.
#pragma once

#include <cstddef>
#include <functional>

#include "perception/cloud/work.h"

namespace cwm::perception {

// Calls body(begin, end) for consecutive ranges of [0, count) on at most work.Threads() threads, a
// limit that is read again before each range, and returns when all ranges are done. Ranges are
// handed out in order but run in any order: a body must write only what belongs to its own range,
// and then the result does not depend on the number of threads. Polls before each range, so a range
// should take at most about a millisecond or its body must poll too. A nested loop runs on the
// thread of the outer body and on threads for which the outer loops have no more ranges, so there
// are never more threads than the outermost loop was given. The first exception of a body, Stopped
// included, ends the loop and is rethrown.
void ParallelFor(std::size_t count, std::size_t range_size, const Work& work,
                 const std::function<void(std::size_t begin, std::size_t end)>& body);

// Calls both functions, in parallel like two ranges of a loop.
void ParallelInvoke(const Work& work, const std::function<void()>& first,
                    const std::function<void()>& second);

}  // namespace cwm::perception
