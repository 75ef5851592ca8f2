#include "clients/formats/robot_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/process.h"

namespace cwm::formats {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string LinkWith(const std::string& element, const std::string& uri) {
  return "<link><" + element + "><geometry><mesh filename=\"" + uri + "\"/></geometry></" +
         element + "></link>";
}

TEST(CollisionMeshUris, AreThoseOfCollisionsEachOnce) {
  EXPECT_THAT(CollisionMeshUris("<robot>" + LinkWith("collision", "b.stl") +
                                LinkWith("visual", "v.stl") + LinkWith("collision", "a.stl") +
                                LinkWith("collision", "b.stl") + "</robot>"),
              ElementsAre("b.stl", "a.stl"));
}

TEST(CollisionMeshUris, AreNoneOfWhatIsNoRobot) {
  EXPECT_THAT(CollisionMeshUris(""), IsEmpty());
  EXPECT_THAT(CollisionMeshUris("no xml"), IsEmpty());
  EXPECT_THAT(CollisionMeshUris("<robot><link><collision/></link></robot>"), IsEmpty());
}

class FindMesh : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(scratch_ / "ws/arm/urdf");
    std::filesystem::create_directories(scratch_ / "ws/arm/meshes");
    std::ofstream(scratch_ / "ws/arm/meshes/a.stl") << "x";
    std::ofstream(scratch_ / "ws/arm/urdf/b.stl") << "x";
  }
  // The file's name, or the error message.
  std::string Find(const std::string& uri, std::vector<std::string> packages = {}) const {
    const auto path = FindMeshFile(uri, {scratch_ / "ws/arm/urdf", std::move(packages)});
    return path.ok() ? std::filesystem::path(*path).filename().string()
                     : std::string(path.status().message());
  }
  cwm::testing::ScratchDirectory scratch_;
};

TEST_F(FindMesh, LooksBesideTheUrdfAndBelowPackageFolders) {
  EXPECT_EQ(Find("b.stl"), "b.stl");
  EXPECT_EQ(Find("../meshes/a.stl"), "a.stl");
  EXPECT_EQ(Find("file://" + (scratch_ / "ws/arm/urdf/b.stl")), "b.stl");
  EXPECT_EQ(Find("package://arm/meshes/a.stl"), "a.stl") << "the folder two above the URDF's";
  EXPECT_EQ(Find("package://arm/meshes/a.stl", {scratch_ / "no", scratch_ / "ws"}), "a.stl");
}

TEST_F(FindMesh, KnowsAFolderThatIsThePackage) {
  EXPECT_EQ(Find("package://arm/meshes/a.stl", {scratch_ / "ws/arm"}), "a.stl");
  EXPECT_EQ(Find("package://arm/meshes/a.stl", {scratch_ / "ws/arm/"}), "a.stl");
  const auto find_as = [&](const std::string& package) {
    return Find("package://" + package + "/meshes/a.stl", {scratch_ / "ws/arm"});
  };
  EXPECT_THAT(find_as("robot_description"), HasSubstr("was not found"));
  std::ofstream(scratch_ / "ws/arm/package.xml")
      << "<package format=\"2\"><name>robot_description</name></package>";
  EXPECT_EQ(find_as("robot_description"), "a.stl");
  EXPECT_EQ(Find("package://robot_description/meshes/a.stl"), "a.stl") << "the URDF's own package";
  EXPECT_THAT(find_as("another"), HasSubstr("was not found"));
}

TEST_F(FindMesh, FindsAPackageByTheNameInItsXmlBelowAGivenFolder) {
  const std::string uri = "package://robot_description/meshes/a.stl";
  EXPECT_THAT(Find(uri, {scratch_.path()}), HasSubstr("was not found"));
  std::ofstream(scratch_ / "ws/arm/package.xml")
      << "<package format=\"2\"><name>robot_description</name></package>";
  EXPECT_EQ(Find(uri, {scratch_.path()}), "a.stl") << "two levels below";
  EXPECT_EQ(Find(uri, {scratch_ / "no", scratch_.path()}), "a.stl");
  EXPECT_THAT(Find("package://another/meshes/a.stl", {scratch_.path()}),
              HasSubstr("was not found"));
  // A package has no packages in it.
  std::filesystem::create_directories(scratch_ / "ws/arm/inner/meshes");
  std::ofstream(scratch_ / "ws/arm/inner/package.xml") << "<package><name>inner</name></package>";
  std::ofstream(scratch_ / "ws/arm/inner/meshes/a.stl") << "x";
  EXPECT_THAT(Find("package://inner/meshes/a.stl", {scratch_.path()}), HasSubstr("was not found"));
}

TEST_F(FindMesh, TakesAThirdSlashForNothing) {
  EXPECT_EQ(Find("package:///arm/meshes/a.stl", {scratch_ / "ws"}), "a.stl");
  EXPECT_THAT(Find("package://"), HasSubstr("was not found"));
}

TEST_F(FindMesh, NamesTheUriAndWhereItWasNot) {
  EXPECT_THAT(Find("package://arm/meshes/a.stl", {"/nowhere"}),
              HasSubstr("package://arm/meshes/a.stl"));
  EXPECT_THAT(Find("package://arm/meshes/a.stl", {"/nowhere"}),
              HasSubstr("/nowhere/arm/meshes/a.stl"));
  EXPECT_THAT(Find("meshes"), HasSubstr("was not found"));
  EXPECT_THAT(Find("http://arm.org/a.stl"),
              HasSubstr("must be at package://, at file:// or a path"));
  EXPECT_THAT(Find("package://arm/meshes"), HasSubstr("was not found")) << "a folder is no file";
}

}  // namespace
}  // namespace cwm::formats
