// The content of hostile requests: meshes, scans, robots and lists of changes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "collision/geometry/triangle_mesh.h"
#include "cwm/v1/perception.pb.h"
#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"
#include "cwm/v1/world.pb.h"
#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {

// A closed torus, 1 m wide, of 2 x around x across triangles. Variants differ slightly in size, so
// that each has a hash of its own.
TriangleMesh Torus(int around, int across, int variant);
inline constexpr int kLargeAround = 300, kLargeAcross = 299;  // 179 400 triangles
inline constexpr int kHullAround = 256, kHullAcross = 255;    // 65 280 vertices: may have a hull

// Stores one torus per copy and records the hashes; false if the server refuses.
bool StoreTori(Target& target, int copies, int around, int across);
inline bool StoreLargeTori(Target& target, int copies) {
  return StoreTori(target, copies, kLargeAround, kLargeAcross);
}

// Puts `count` boxes of 5 cm into the world, on a grid of 20 cm.
bool PutBoxes(const MeasuredServer& server, const std::string& world, int count);
// Puts one object, "torus", whose shape is the mesh of that hash.
bool PutMesh(const MeasuredServer& server, const std::string& world, const std::string& hash);
// Loads a robot, "arm", of `links` links on prismatic joints, each a sphere.
bool LoadArm(const MeasuredServer& server, const std::string& world, int links);
bool Apply(const MeasuredServer& server, const v1::ApplyChangesRequest& request);

// A list of `count` puts of spheres of 1 mm, with names and radii as short as possible.
v1::ApplyChangesRequest TinySpheres(const std::string& world, int count);
// The URDF of the arm.
std::string ArmUrdf(int links);
// Rows of poses along x, 1 mm apart.
std::string PoseBytes(int rows, double from_x_m);
std::string PointBytes(int points);

// Header, files and the end of a robot's upload, as messages.
struct NamedFile {
  std::string name;
  std::string bytes;
};
CallPlan RobotUploadPlan(const v1::LoadRobotHeader& header, const std::vector<NamedFile>& files);
// The URDF of one link whose collision geometries are the meshes, each at all of the scales.
std::string MeshUrdf(const std::vector<std::string>& files, const std::vector<double>& scales);

// Header, chunks and the end of a cloud's upload, with x y z as floats.
CallPlan CloudUploadPlan(const std::string& world, const std::vector<float>& xyz);
// `count` points drawn evenly in a box.
std::vector<float> NoisePoints(int count);

}  // namespace cwm::benchmarks
