// Which axis of a file points away from the ground.
#pragma once

namespace cwm::collision {

enum class UpAxis { kX, kY, kZ };

}  // namespace cwm::collision
