// Scans of a table by the virtual scanner, with the interpretation from its ground truth, as a
// perfect interpreter would return it. Noiseless and coarse, so that association takes
// milliseconds.
#pragma once

#include <string>

#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"
#include "server/core/ingest.h"

namespace cwm::server {

// A table top of 1 m x 0.8 m at z = 0.9 around the origin, object 0 of the scene.
perception::SimulatedScene EmptyTable();
// Puts a box with its lower face on the table.
void AddBox(perception::SimulatedScene& scene, const std::string& name, double x_m, double y_m,
            const Vector3& size_m);
perception::SimulatedScene TwoBoxes();  // "left" at y = +0.2, "right" at y = -0.2

// At x = -0.7, looking down at the table by 40 degrees.
Pose TableCamera_X_WC();

struct TableScan {
  perception::PointCloud cloud;
  perception::SceneInterpretation truth;  // in the true world frame; objects in the scene's order
};
TableScan ScanTable(const perception::SimulatedScene& scene);

// An ingest request for the scan from the sensor "head", whose pose is given.
IngestRequest RequestFor(const TableScan& scan);
// An interpreter that always returns the scan's truth.
Interpreter TruthOf(const TableScan& scan);

}  // namespace cwm::server
