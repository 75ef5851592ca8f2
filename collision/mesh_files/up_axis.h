// The axis of a file that points away from the ground.
#pragma once

namespace cwm::collision {

enum class UpAxis { kX, kY, kZ };

}  // namespace cwm::collision
