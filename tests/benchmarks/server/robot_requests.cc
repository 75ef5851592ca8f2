// Robots: files that expand while they are parsed, and uploads that stop half-way.
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "proto/transfer/crc32c.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"
#include "tests/collision/mesh_files/mesh_bytes.h"

namespace cwm::benchmarks {
namespace {

namespace mesh_bytes = collision::testing;

v1::LoadRobotHeader HeaderOf(int copy, std::string urdf) {
  v1::LoadRobotHeader header;
  header.set_world(absl::StrCat("robots_", copy));
  header.set_name("r");
  header.set_urdf(std::move(urdf));
  return header;
}

// A Collada file in which each node contains the next one twice, side by side: 2^levels boxes.
std::string Unfolding(int levels, int copy) {
  std::string nodes = absl::StrCat(R"(<node id="n0"><scale>1 1 1.)", 100 + copy,
                                   R"(</scale><instance_geometry url="#part"/></node>)");
  for (int i = 1; i <= levels; ++i) {
    absl::StrAppend(&nodes, R"(<node id="n)", i, R"("><instance_node url="#n)", i - 1,
                    R"("/><node><translate>0 0 )", 1 << i, R"(</translate><instance_node url="#n)",
                    i - 1, R"("/></node></node>)");
  }
  const std::string scene =
      absl::StrCat(R"(<node><instance_node url="#n)", levels, R"("/></node>)");
  return mesh_bytes::Collada(mesh_bytes::BoxMesh({0.1, 0.1, 0.1}),
                             {.scene_nodes = scene, .library_nodes = nodes});
}

SendCopy LoadUnfolding(int levels, std::vector<double> scales) {
  return [levels, scales](const Target& target, int copy, Sent& sent) {
    target.Hold(RobotUploadPlan(HeaderOf(copy, MeshUrdf({"a.dae"}, scales)),
                                {{"a.dae", Unfolding(levels, copy)}}),
                sent);
  };
}

// One mesh of the file at many scales: each scale makes a mesh of its own.
void LoadScales(const Target& target, int copy, Sent& sent) {
  std::vector<double> scales;
  for (int i = 0; i < 40; ++i) scales.push_back(1 + 0.001 * (40 * copy + i));
  const std::string stl = mesh_bytes::BinaryStl(Torus(100, 100, copy));
  target.Hold(RobotUploadPlan(HeaderOf(copy, MeshUrdf({"a.stl"}, scales)), {{"a.stl", stl}}), sent);
}

// A GLB file with very many nodes of one mesh.
void LoadGlbNodes(const Target& target, int copy, Sent& sent) {
  constexpr int kNodes = 2'000;
  std::string nodes = "[", roots = "[";
  for (int i = 0; i < kNodes; ++i) {
    absl::StrAppend(&nodes, i == 0 ? "" : ",", R"({"mesh":0})");
    absl::StrAppend(&roots, i == 0 ? "" : ",", i);
  }
  const TriangleMesh mesh = Torus(20, 20, copy);
  const std::string glb = mesh_bytes::Glb(mesh_bytes::GlbJson(mesh, nodes + "]", roots + "]"),
                                          mesh_bytes::GlbBinary(mesh));
  target.Hold(RobotUploadPlan(HeaderOf(copy, MeshUrdf({"a.glb"}, {1, 2})), {{"a.glb", glb}}), sent);
}

// An OBJ file with eight bytes per triangle, nearly all of them different.
void LoadObjFaces(const Target& target, int copy, Sent& sent) {
  std::string obj;
  for (int i = 0; i < 90; ++i) {
    absl::StrAppend(&obj, "v ", i % 10, " ", i / 10, " ", (i * i + copy) % 17, "\n");
  }
  for (int i = 1; i <= 90; ++i) {
    for (int j = i + 1; j <= 90; ++j) {
      for (int k = j + 1; k <= 90; k += 2) absl::StrAppend(&obj, "f ", i, " ", j, " ", k, "\n");
    }
  }
  target.Hold(RobotUploadPlan(HeaderOf(copy, MeshUrdf({"a.obj"}, {1, 2})), {{"a.obj", obj}}), sent);
}

// An STL file as text that repeats the same triangle.
void LoadStlText(const Target& target, int copy, Sent& sent) {
  std::string stl = absl::StrCat("solid part", copy, "\n");
  for (int i = 0; i < 200'000; ++i) {
    absl::StrAppend(&stl, "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 ",
                    i % 7, "\nendloop\nendfacet\n");
  }
  CallPlan plan =
      RobotUploadPlan(HeaderOf(copy, MeshUrdf({"a.stl"}, {1})), {{"a.stl", stl + "endsolid"}});
  target.Hold(plan, sent);
}

// As many links as a robot may have: some eight million pairs of them.
void LoadManyLinks(const Target& target, int copy, Sent& sent) {
  CallPlan plan = RobotUploadPlan(HeaderOf(copy, ArmUrdf(4'000)), {});
  target.Hold(plan, sent);
}

// A document of the smallest elements.
SendCopy LoadElements(bool in_srdf) {
  return [in_srdf](const Target& target, int copy, Sent& sent) {
    std::string elements;
    for (int i = 0; i < 1'900'000; ++i) elements += "<a/>";
    v1::LoadRobotHeader header = HeaderOf(
        copy, in_srdf ? ArmUrdf(1) : R"(<robot name="r"><link name="l"/>)" + elements + "</robot>");
    if (in_srdf) header.set_srdf(R"(<robot name="arm">)" + elements + "</robot>");
    CallPlan plan = RobotUploadPlan(header, {});
    target.Hold(plan, sent);
  };
}

// Disabled pairs of links, repeated.
void LoadDisabledPairs(const Target& target, int copy, Sent& sent) {
  v1::LoadRobotHeader header = HeaderOf(copy, ArmUrdf(300));
  std::string srdf = R"(<robot name="arm">)";
  for (int i = 0; i < 90'000; ++i) {
    if (i % 300 == i / 300) continue;  // a link and itself are no pair
    absl::StrAppend(&srdf, R"(<disable_collisions link1="a)", i % 300, R"(" link2="a)", i / 300,
                    R"(" reason=""/>)");
  }
  header.set_srdf(srdf + "</robot>");
  target.Hold(RobotUploadPlan(header, {}), sent);
}

// Each group contains all groups before it.
void LoadNestedGroups(const Target& target, int copy, Sent& sent) {
  v1::LoadRobotHeader header = HeaderOf(copy, ArmUrdf(200));
  std::string srdf =
      R"(<robot name="arm"><group name="g0"><chain base_link="a0" tip_link="a200"/></group>)";
  for (int i = 1; i < 250; ++i) {
    absl::StrAppend(&srdf, R"(<group name="g)", i, R"(">)");
    for (int j = 0; j < i; ++j) absl::StrAppend(&srdf, R"(<group name="g)", j, R"("/>)");
    absl::StrAppend(&srdf, "</group>");
  }
  header.set_srdf(srdf + "</robot>");
  target.Hold(RobotUploadPlan(header, {}), sent);
}

void LoadSpheres(const Target& target, int copy, Sent& sent) {
  v1::LoadRobotHeader header = HeaderOf(copy, ArmUrdf(10));
  std::string spheres = R"(<robot name="arm"><link name="a1">)";
  for (int i = 0; i < 30'000; ++i) {
    absl::StrAppend(&spheres, R"(<collision><origin xyz="0 0 )", i,
                    R"(e-6"/><geometry><sphere radius=".01"/></geometry></collision>)");
  }
  header.set_spheres(spheres + "</link></robot>");
  CallPlan plan = RobotUploadPlan(header, {});
  target.Hold(plan, sent);
}

// An upload of only the header, with large texts.
void HalfOpen(const Target& target, int copy, Sent& sent) {
  v1::LoadRobotHeader header = HeaderOf(copy, std::string(15 << 20, ' '));
  CallPlan plan = RobotUploadPlan(header, {});
  plan.messages.resize(1);
  plan.half_closes = false;
  target.Hold(plan, sent);
}

// Many small uploads with the header and the announcement of a file.
void HalfOpenCrowd(const Target& target, int copy, Sent& sent) {
  CallPlan plan = RobotUploadPlan(HeaderOf(copy, ArmUrdf(1)), {{"a.stl", "nothing"}});
  plan.messages.resize(2);
  plan.half_closes = false;
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 200; ++i) target.HoldOver(channel, plan, sent);
}

// Files of a mebibyte of zeros each, without the end of the upload.
void HalfSentFiles(const Target& target, int copy, Sent& sent) {
  const std::string zeros(1 << 20, '\0');
  std::vector<NamedFile> files;
  for (int i = 0; i < 32; ++i) files.push_back({absl::StrCat("f", i), zeros});
  CallPlan plan = RobotUploadPlan(HeaderOf(copy, ArmUrdf(1)), files);
  plan.messages.pop_back();
  plan.half_closes = false;
  target.Hold(plan, sent);
}

// File names of the maximum length, for empty files.
void FileNames(const Target& target, int copy, Sent& sent) {
  std::vector<NamedFile> files;
  for (int i = 0; i < 4'000; ++i) files.push_back({absl::StrCat(std::string(4'000, 'n'), i), ""});
  CallPlan plan = RobotUploadPlan(HeaderOf(copy, ArmUrdf(1)), files);
  plan.messages.pop_back();
  plan.half_closes = false;
  target.Hold(plan, sent);
}

bool MakeArm(Target& target, int) { return LoadArm(target.server, "w", 1'000); }

template <class Request>
SendCopy UnreadCrowd(const std::string& method, Request request) {
  request.set_world("w");
  CallPlan plan = UnaryPlan("cwm.v1.RobotService/" + method, request);
  plan.reads = false;
  return [plan](const Target& target, int, Sent& sent) {
    const auto channel = target.server.NewChannel();
    for (int i = 0; i < 16; ++i) target.HoldOver(channel, plan, sent);
  };
}

v1::GetRobotLinksRequest Links() {
  v1::GetRobotLinksRequest request;
  request.set_name("arm");
  request.set_with_shapes(true);
  return request;
}

// A batch of states of all joints, for a robot with many links.
void ManyStates(const Target& target, int, Sent& sent) {
  v1::CheckCollisionsRequest request;
  request.set_world("w");
  request.mutable_subject()->mutable_robot()->set_robot("arm");
  request.mutable_subject()->mutable_robot()->mutable_rows()->set_data(
      std::string(1'000 * 200 * sizeof(double), '\0'));
  CallPlan plan = UnaryPlan("cwm.v1.QueryService/CheckCollisions", request);
  target.Hold(plan, sent);
}

}  // namespace

std::vector<HostileRequest> RobotRequests() {
  return {
      {.name = "LoadRobot/collada_two_scales", .copies = 1, .send = LoadUnfolding(15, {1, 2})},
      {.name = "LoadRobot/collada_instances", .copies = 1, .send = LoadUnfolding(12, {1})},
      {.name = "LoadRobot/many_scales", .copies = 1, .send = LoadScales},
      {.name = "LoadRobot/glb_nodes", .copies = 1, .send = LoadGlbNodes},
      {.name = "LoadRobot/obj_faces", .copies = 1, .send = LoadObjFaces},
      {.name = "LoadRobot/stl_text", .copies = 1, .send = LoadStlText},
      {.name = "LoadRobot/links", .copies = 1, .send = LoadManyLinks},
      {.name = "LoadRobot/urdf_elements", .copies = 1, .send = LoadElements(false)},
      {.name = "LoadRobot/srdf_elements", .copies = 1, .send = LoadElements(true)},
      {.name = "LoadRobot/srdf_pairs", .copies = 2, .send = LoadDisabledPairs},
      {.name = "LoadRobot/srdf_groups", .copies = 2, .send = LoadNestedGroups},
      {.name = "LoadRobot/spheres", .copies = 1, .send = LoadSpheres},
      {.name = "LoadRobot/half_open", .copies = 4, .send = HalfOpen},
      {.name = "LoadRobot/half_open_crowd", .copies = 1, .send = HalfOpenCrowd, .has_cpu = false},
      {.name = "LoadRobot/half_sent", .copies = 4, .send = HalfSentFiles},
      {.name = "LoadRobot/file_names", .copies = 2, .send = FileNames},
      {.name = "ListRobots/unread",
       .copies = 2,
       .prepare = MakeArm,
       .send = UnreadCrowd("ListRobots", v1::ListRobotsRequest())},
      {.name = "GetRobotLinks/unread",
       .copies = 2,
       .prepare = MakeArm,
       .send = UnreadCrowd("GetRobotLinks", Links())},
      {.name = "CheckCollisions/robot_states",
       .copies = 1,
       .prepare =
           [](Target& target, int) {
             return LoadArm(target.server, "w", 200) && PutBoxes(target.server, "w", 1'000);
           },
       .send = ManyStates},
  };
}

}  // namespace cwm::benchmarks
