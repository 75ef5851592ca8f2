// A cwm-server started by the benchmark, with the benchmark world in its world "default".
#pragma once

#include <sys/types.h>

#include <string>

#include "clients/cpp/connection.h"
#include "collision/geometry/shape.h"
#include "tests/support/process.h"

namespace cwm::benchmarks {

class RunningServer {
 public:
  // Starts the cwm-server beside this benchmark; up() is true if it answers.
  RunningServer();

  bool up() const { return up_; }
  const client::Connection& connection() const { return connection_; }
  pid_t pid() const { return process_.pid(); }
  double ResidentMebibytes() const { return process_.ResidentMebibytes(); }

 private:
  testing::ScratchDirectory scratch_;
  testing::BackgroundProcess process_;
  client::Connection connection_;
  bool up_ = false;
};

void SetPose(const Pose& X, v1::Pose* out);
// Sets boxes, cylinders, spheres and capsules; false for other kinds.
bool SetShape(const Shape& shape, v1::ShapePart* part);

}  // namespace cwm::benchmarks
