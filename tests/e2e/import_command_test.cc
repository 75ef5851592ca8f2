// Files of other tools imported into a real world: queries give the same answers as before the
// export.
#include <gmock/gmock.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "clients/cli/mesh_arguments.h"
#include "clients/cli/run.h"
#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kUsage = 1, kBadInput = 8;  // exit codes, see `cwm --help`

// Files have single precision: 2^-24 of coordinates below 2 m, at both ends of a distance.
constexpr double kRounding_m = 4 * 0x1p-24;

class ImportCommand : public ServerTest {
 protected:
  std::string File(const std::string& name) const { return scratch() / name; }

  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream(File(name), std::ios::binary) << content;
    return File(name);
  }

  // Distances of a sphere of 5 cm at places around the object at 0.5, 0.2, 1.
  std::vector<double> Distances(const std::string& world) const {
    std::vector<double> found;
    const json reply =
        CwmJson({"-w", world, "distance", "--sphere", "0.05", "--at", "0.5,0.2,1.4", "--at",
                 "0.9,0.2,1", "--at", "0.5,-0.3,1.01", "--at", "0.1,0.5,0.7"});
    for (const json& row : reply.at("rows")) {
      found.push_back(row.at("answers").at(0).at("distance_m").get<double>());
    }
    return found;
  }

  void ExpectSameDistances(const std::string& world, const std::string& as) const {
    const std::vector<double> got = Distances(world), want = Distances(as);
    ASSERT_EQ(want.size(), 4U);
    ASSERT_EQ(got.size(), want.size());
    for (std::size_t i = 0; i < want.size(); ++i) EXPECT_NEAR(got[i], want[i], kRounding_m) << i;
  }

  void ExpectRefused(const std::vector<std::string>& arguments, int exit_code,
                     const std::string& said) const {
    const ProcessResult run = Cwm(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.out << run.err;
    EXPECT_THAT(run.err, HasSubstr(said));
  }
};

// A wedge without any symmetry.
constexpr char kWedge[] =
    "v 0.4 0.1 0.9\nv 0.6 0.1 0.9\nv 0.4 0.25 0.9\nv 0.4 0.1 1.1\n"
    "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

TEST_F(ImportCommand, TellsOnATerminalHowFarAMeshIs) {
  for (const bool terminal : {false, true}) {
    TriangleMesh
        mesh;  // several chunks; differs per round, since known meshes are not sent in full
    for (std::uint32_t i = 0; i < 150'000; ++i) {
      mesh.vertices.emplace_back(0.001 * i, terminal ? 1 : 0, i % 2);
      if (i >= 2) mesh.triangles.push_back({i - 2, i - 1, i});
    }
    std::istringstream in;
    std::ostringstream out, err;
    cli::Session session({.in = in, .out = out, .err = err, .err_is_terminal = terminal});
    session.address = address();
    const auto part = cli::UploadMesh(session, mesh);
    ASSERT_TRUE(part.ok()) << part.status();
    EXPECT_EQ(out.str(), "");
    if (!terminal) {
      EXPECT_EQ(err.str(), "");
      continue;
    }
    EXPECT_THAT(err.str(), AllOf(HasSubstr("sending 1.0 MB of 5.4 MB, a mesh of 149998 triangles"),
                                 HasSubstr("MB/s"), HasSubstr("the server stores a mesh of")));
    EXPECT_TRUE(err.str().ends_with("\r\033[K")) << "nothing of it stays";
  }
}

// A strip as text of a MoveIt scene, of about 2.2 MB when it is sent.
std::string StripInScene(const std::string& id, int y_m) {
  constexpr int kVertices = 60'000;
  std::ostringstream text;
  text << "* " << id << "\n1\nmesh\n" << kVertices << ' ' << kVertices - 2 << '\n';
  for (int i = 0; i < kVertices; ++i) text << 0.001 * i << ' ' << y_m << ' ' << i % 2 << '\n';
  for (int i = 2; i < kVertices; ++i) text << i - 2 << ' ' << i - 1 << ' ' << i << '\n';
  text << "0 0 0\n0 0 0 1\n0 0 0 0\n";
  return text.str();
}

TEST_F(ImportCommand, TellsOnATerminalHowFarTheMeshesOfASceneAre) {
  for (const bool terminal : {false, true}) {
    const int y_m = terminal ? 10 : 0;
    const std::string file = Write("strips.scene", "strips\n" + StripInScene("near", y_m) +
                                                       StripInScene("far", y_m + 1) + ".\n");
    std::istringstream in;
    std::ostringstream out, err;
    const cli::ExitCode code =
        cli::Run({"--addr", address(), "import", file},
                 {.in = in, .out = out, .err = err, .err_is_terminal = terminal});
    ASSERT_EQ(static_cast<int>(code), 0) << err.str();
    EXPECT_THAT(out.str(), HasSubstr("imported 2 objects (2 meshes)"));
    if (!terminal) {
      EXPECT_EQ(err.str(), "");
      continue;
    }
    EXPECT_THAT(err.str(), AllOf(HasSubstr("sending 1.0 MB of 4.3 MB, mesh 1 of 2"),
                                 HasSubstr("sending 3.2 MB of 4.3 MB, mesh 2 of 2"),
                                 HasSubstr("MB/s"), HasSubstr("the server stores mesh 2 of 2")));
    EXPECT_TRUE(err.str().ends_with("\r\033[K")) << "nothing of it stays";
  }
}

TEST_F(ImportCommand, TakesWhatWasExportedAndAnswersTheSame) {
  const ProcessResult imported = Cwm({"import", Write("wedge.obj", kWedge)});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_THAT(imported.out, HasSubstr("imported wedge, a mesh of 4 triangles, closed, revision 1"));
  ASSERT_EQ(Cwm({"export", File("all.glb")}).exit_code, 0);
  ASSERT_EQ(Cwm({"export", File("all.ply")}).exit_code, 0);
  ASSERT_EQ(Cwm({"get", "wedge", "--mesh", File("one.glb")}).exit_code, 0);
  ASSERT_EQ(Cwm({"get", "wedge", "--mesh", File("one.ply")}).exit_code, 0);
  ASSERT_EQ(Cwm({"export", File("all.sdf")}).exit_code, 0);
  std::string stl;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch().path())) {
    if (entry.path().extension() == ".stl") stl = entry.path();
  }
  ASSERT_NE(stl, "");
  for (const std::string& file :
       {File("all.glb"), File("all.ply"), File("one.glb"), File("one.ply"), stl}) {
    const std::string world = "of_" + std::filesystem::path(file).filename().string();
    const ProcessResult back = Cwm({"-w", world, "import", file});
    ASSERT_EQ(back.exit_code, 0) << file << back.err;
    ExpectSameDistances(world, "default");
  }
}

// A cube of 1 m with a vertex 1 mm beside an edge, on one side of the edge only.
constexpr char kCrackedCube[] =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 0.5 0.001 0\n"
    "f 1 4 3\nf 1 3 9\nf 3 2 9\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\n"
    "f 3 8 7\nf 4 1 5\nf 4 5 8\n";

TEST_F(ImportCommand, ClosesACrackAndSaysWhatAMeshIs) {
  const std::string file = Write("cracked.obj", kCrackedCube);
  const ProcessResult imported = Cwm({"import", file});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_THAT(imported.out,
              HasSubstr("a mesh of 13 triangles, closed by a cap of a hole of 1000.0 mm"));
  EXPECT_THAT(imported.err, HasSubstr("answers near them are BOUNDED"));
  const auto at = [&](const char* sphere, const char* position) {
    return CwmJson({"check", "--sphere", sphere, "--at", position})["rows"][0];
  };
  EXPECT_EQ(at("0.1", "0.5,0.5,0.5").at("verdict"), "VERDICT_COLLISION");
  EXPECT_EQ(at("0.1", "0.5,0.5,0.5").at("trust"), "TRUST_EXACT");
  EXPECT_EQ(at("0.01", "0.5,0.001,0").at("verdict"), "VERDICT_COLLISION");
  EXPECT_EQ(at("0.01", "0.5,0.001,0").at("trust"), "TRUST_BOUNDED");
  EXPECT_EQ(at("0.1", "0.5,0.5,1.2").at("verdict"), "VERDICT_FREE");
  const auto near = CwmJson({"distance", "--sphere", "0.01", "--at", "0.5,0,-0.02"});
  const auto& answer = near["rows"][0]["answers"][0];
  EXPECT_EQ(answer.at("trust"), "TRUST_BOUNDED");
  EXPECT_NEAR(answer.at("bound_m").get<double>(), 0.001, 1e-6);
  const ProcessResult put = Cwm({"put", "again", "--mesh", file, "--at", "0,0,5"});
  ASSERT_EQ(put.exit_code, 0) << put.err;
  EXPECT_THAT(put.out, HasSubstr("put again, a mesh of 13 triangles, closed by a cap"));
  EXPECT_EQ(at("0.1", "0.5,0.5,5.5").at("verdict"), "VERDICT_COLLISION");
  const ProcessResult open =
      Cwm({"import", Write("lid.obj", "v 0 0 9\nv 1 0 9\nv 0 1 9.5\nf 1 2 3\n")});
  EXPECT_THAT(open.out, HasSubstr("a mesh of 1 triangle, open: a hole of 1500.0 mm"));
  EXPECT_THAT(open.err, HasSubstr("close its holes"));
  const ProcessResult beside = Cwm({"check", "--sphere", "0.1", "--at", "0.9,0.9,9.2"});
  EXPECT_THAT(beside.out, AllOf(HasSubstr("TRUST"), HasSubstr("free")));
  EXPECT_THAT(beside.err, HasSubstr("an open mesh is near"));
  const ProcessResult far = Cwm({"check", "--sphere", "0.1", "--at", "0.3,0.3,7"});
  EXPECT_THAT(far.out, Not(HasSubstr("TRUST")));
  EXPECT_EQ(far.err, "");
}

TEST_F(ImportCommand, ScalesTurnsPlacesAndNames) {
  Write("wedge.obj", kWedge);
  CwmJson({"-w", "plain", "import", File("wedge.obj")});
  std::string millimetres = "# y is up\n";
  for (const char* line :
       {"v 400 900 -100\n", "v 600 900 -100\n", "v 400 900 -250\n", "v 400 1100 -100\n"}) {
    millimetres += line;
  }
  Write("odd name (1).obj", millimetres + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const ProcessResult warned = Cwm({"-w", "huge", "import", File("odd name (1).obj")});
  EXPECT_EQ(warned.exit_code, 0);
  EXPECT_THAT(warned.err, HasSubstr("are these millimetres? --scale 0.001"));
  const ProcessResult turned = Cwm(
      {"-w", "turned", "import", File("odd name (1).obj"), "--scale", "0.001", "--up-axis", "y"});
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  EXPECT_THAT(turned.out, HasSubstr("imported odd_name__1_,"));
  EXPECT_EQ(turned.err, "");
  ExpectSameDistances("turned", "plain");
  // `put --mesh` gives the same result.
  CwmJson({"-w", "put", "put", "w", "--mesh", File("odd name (1).obj"), "--scale", "0.001",
           "--up-axis", "y"});
  ExpectSameDistances("put", "plain");
  // At another pose under another name.
  CwmJson({"-w", "moved", "import", File("wedge.obj"), "--name", "shelf/w", "--at", "1,0,0"});
  EXPECT_EQ(CwmJson({"-w", "moved", "get", "shelf/w"}).at("object").at("x_world_object").at("tx_m"),
            1);
}

TEST_F(ImportCommand, TakesCloudsAsIngestDoes) {
  std::string xyz = "# x y z\n", csv = "x;y;z\n";
  for (int i = 0; i < 60; ++i) {
    for (int k = 0; k < 60; ++k) {
      const std::string x = std::to_string(0.01 * i - 0.3), y = std::to_string(0.01 * k - 0.3);
      xyz += x + " " + y + " 1\n";
      csv += x + ";" + y + ";1\n";
    }
  }
  Write("table.xyz", xyz);
  Write("table.csv", csv);
  const ProcessResult saved = RunProgram(
      {"/usr/bin/python3", "-c",
       "import numpy, sys; numpy.save(sys.argv[2], numpy.loadtxt(sys.argv[1]).astype('>f4'))",
       File("table.xyz"), File("table.npy")});
  ASSERT_EQ(saved.exit_code, 0) << saved.err;
  const std::vector<std::string> scan = {"--up", "0,0,-1", "--sensor-model", "0.001"};
  for (const std::string command : {"import", "ingest"}) {
    for (const std::string name : {"table.xyz", "table.csv", "table.npy"}) {
      std::vector<std::string> line = {"-w", command + name, command, File(name)};
      line.insert(line.end(), scan.begin(), scan.end());
      const json reply = CwmJson(line);
      EXPECT_EQ(reply.at("supports").size(), 1U) << command << name;
      EXPECT_EQ(reply.at("report").at("points_in"), "3600") << command << name;
    }
  }
  // The vertices of a mesh may be used as a scan, but with a warning.
  const ProcessResult mesh = Cwm({"-w", "m", "put", "b", "--box", "1,1,1"});
  ASSERT_EQ(mesh.exit_code, 0) << mesh.err;
  ASSERT_EQ(Cwm({"-w", "m", "get", "b", "--mesh", File("b.ply")}).exit_code, 0);
  EXPECT_THAT(Cwm({"-w", "m2", "ingest", File("b.ply")}).err,
              HasSubstr("has faces, its vertices are taken as a scan"));
}

TEST_F(ImportCommand, RefusesBadFilesAndOptionsThatDoNotFit) {
  CwmJson({"put", "can", "--cylinder", "0.03,0.1"});
  ExpectRefused({"import", Write("a.stl", "solid\nfacet\nvertex 0 0\n")}, kBadInput,
                "a.stl: line 3: must have three numbers");
  ExpectRefused({"import", Write("a.glb", "glTF")}, kBadInput, "a.glb: ");
  ExpectRefused({"import", Write("a.dae", "<COLLADA>")}, kBadInput, "a.dae: ");
  ExpectRefused({"import", Write("a.ply", "ply\nformat ascii 2.0\n")}, kBadInput, "a.ply: format");
  ExpectRefused({"import", Write("a.npy", "\x93NUMPY\x09")}, kBadInput, "a.npy: version");
  ExpectRefused({"import", Write("a.xyz", "1 2 3\n1 2\n")}, kBadInput,
                "a.xyz: line 2 number of columns is 2, must be at least 3");
  ExpectRefused({"import", Write("b.xyz", "hello\n")}, kBadInput, "first line is hello");
  ExpectRefused({"import", Write("wedge.obj", kWedge), "--robot", "panda"}, kUsage, "--robot");
  ExpectRefused({"import", File("wedge.obj"), "--up", "0,0,1"}, kUsage, "--up");
  ExpectRefused({"import", File("wedge.obj"), "--scale", "0"}, kUsage, "--scale is 0");
  ExpectRefused({"import", File("wedge.obj"), "--up-axis", "w"}, kUsage, "must be x, y or z");
  ExpectRefused({"import", Write("c.xyz", "1 2 3\n"), "--up-axis", "z"}, kUsage,
                "--up-axis does not go with " + File("c.xyz") + ", which is read as a cloud");
  ExpectRefused({"import", File("c.xyz"), "--expected-revision", "1"}, kUsage,
                "--expected-revision");
  EXPECT_EQ(RevisionOf("default"), 1) << "bad input changed the world";
}

}  // namespace
}  // namespace cwm::testing
