// Errors of URDF files, with their messages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/robot/urdf.h"
#include "tests/collision/mesh_files/mesh_bytes.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

std::string RefusalOfText(const std::string& xml, const MeshSource& meshes = NoMeshes) {
  const auto robot = ReadUrdf(xml, meshes);
  if (robot.ok()) return "none";
  EXPECT_EQ(robot.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(robot.status().message());
}

// The error of a robot that exceeds the limits.
std::string ExcessOfText(const std::string& xml, const MeshSource& meshes,
                         const RobotLimits& limits) {
  const auto robot = ReadUrdf(xml, meshes, limits);
  if (robot.ok()) return "none";
  EXPECT_EQ(robot.status().code(), absl::StatusCode::kResourceExhausted);
  return std::string(robot.status().message());
}

std::string RefusalOf(const std::string& elements) { return RefusalOfText(Robot(elements)); }

std::string RefusalOfJoint(const std::string& kind, const std::string& more) {
  return RefusalOf(Links("ab") + JointText("elbow", kind, "a", "b", more));
}

std::string RefusalOfShape(const std::string& shape, const MeshSource& meshes = NoMeshes) {
  return RefusalOfText(
      Robot("<link name=\"a\"><collision><geometry>" + shape + "</geometry></collision></link>"),
      meshes);
}

MeshSource Always(const std::string& bytes) {
  return [bytes](std::string_view) { return absl::StatusOr<std::string>(bytes); };
}

TEST(UrdfRefusals, MalformedXmlIsToldWithItsLine) {
  EXPECT_THAT(RefusalOfText(""), HasSubstr("urdf: must not be empty"));
  EXPECT_THAT(RefusalOfText("  \n "), HasSubstr("urdf: must"));
  EXPECT_THAT(RefusalOfText("robot"), HasSubstr("urdf: line 1: malformed XML"));
  EXPECT_THAT(RefusalOfText("<robot name=\"r\">\n<link name=\"a\">\n</robot>"),
              HasSubstr("urdf: line 2: the element is not closed by its own end tag"));
  EXPECT_THAT(RefusalOfText("<robot name=\"r\">\n<link name=a/></robot>"),
              HasSubstr("urdf: line 2: malformed XML"));
  EXPECT_THAT(RefusalOfText(Robot(Links("a")).substr(0, 50)), HasSubstr("urdf: line"));
  EXPECT_EQ(RefusalOfText("<?xml version=\"1.0\"?>"), "urdf: must have a root element");
  EXPECT_EQ(RefusalOfText(Robot(Links("a")) + std::string(1, '\0') + " "),
            "urdf: must not hold the byte 0");
}

TEST(UrdfRefusals, EntitiesAreNeitherDeclaredNorExpanded) {
  const std::string bomb =
      "<?xml version=\"1.0\"?>\n<!-- x -->\n<!DOCTYPE r [<!ENTITY a \"aaaaaaaaaa\">"
      "<!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\">]>\n<robot name=\"&b;\"><link name=\"a\"/></robot>";
  EXPECT_EQ(RefusalOfText(bomb), "urdf: must not have a DOCTYPE");
  EXPECT_EQ(RefusalOfText(Robot(Links("a")) + "\n<robot name=\"other\"/>").substr(0, 11),
            "urdf: line ");
  EXPECT_THAT(RefusalOfText(Robot(Links("a")) + "\n<robot name=\"other\"/>"),
              HasSubstr("has the root element <robot> beside <robot>, must have one"));
  EXPECT_EQ(RefusalOfText("\xef\xbb\xbf<!DOCTYPE r SYSTEM \"file:///etc/passwd\">" +
                          Robot(Links("a")).substr(22)),
            "urdf: must not have a DOCTYPE");
}

TEST(UrdfRefusals, AReferenceMustBeToWhatXmlDefines) {
  const auto named = [](const std::string& name) {
    return "<?xml version=\"1.0\"?>\n<robot name=\"" + name + "\"><link name=\"a\"/></robot>";
  };
  EXPECT_EQ(
      RefusalOfText(named("&arm;")),
      "urdf: line 2: \"&arm;\" is not defined: must be &amp;, &lt;, &gt;, &quot;, &apos; or the "
      "number of a character, such as &#945;");
  for (const char* reference : {"&AMP;", "&nbsp;", "&#;", "&#x;", "&#0;", "&#xd800;", "&#xffff;",
                                "&#1114112;", "&#99999999999;", "&#-1;", "&#12a;"}) {
    EXPECT_THAT(RefusalOfText(named(std::string("a & b ") + reference)),
                HasSubstr(std::string("line 2: \"") + reference + "\" is not defined"));
  }
  const auto name_of = [&](const std::string& name) {
    const auto robot = ReadUrdf(named(name) + "<!-- &none; -->", NoMeshes);
    return robot.ok() ? robot->name : std::string(robot.status().message());
  };
  EXPECT_EQ(name_of("&lt;a&gt; &amp; &quot;&apos;&#98;&#x63;"), "<a> & \"'bc");
  EXPECT_EQ(name_of("&amp;arm;"), "&arm;");
  // Not references, although not proper XML either: other readers accept them unchanged.
  for (const char* plain : {"a & b", "a&b", "a&", "?x=1&y=2;", "&;"}) {
    EXPECT_EQ(name_of(plain), plain);
  }
}

TEST(UrdfRefusals, DeepAndLongDocumentsAreRefused) {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<link name=\"a\">";
  EXPECT_THAT(RefusalOf(deep), HasSubstr("elements must not nest deeper than 100"));
  const std::string robot = Robot(Links("a"));
  const RobotLimits limits{.max_xml_bytes = robot.size()};
  EXPECT_EQ(ExcessOfText(robot, NoMeshes, limits), "none");
  EXPECT_EQ(ExcessOfText(robot + " ", NoMeshes, limits),
            "urdf: is " + std::to_string(robot.size() + 1) + " bytes long, must be at most " +
                std::to_string(robot.size()));
}

TEST(UrdfRefusals, OtherDocumentsAreRefused) {
  EXPECT_EQ(RefusalOfText("<sdf/>"), "urdf: has the root element <sdf>, must have <robot>");
  EXPECT_EQ(RefusalOfText("<robot><link name=\"a\"/></robot>"), "urdf: name: must be given");
  EXPECT_EQ(RefusalOf(Links("a") + "<xacro:include filename=\"arm.xacro\"/>"),
            "urdf: xacro:include: must be expanded by xacro before it is loaded");
  EXPECT_EQ(
      RefusalOf("<link name=\"${prefix}base\"/>"),
      "urdf: link \"${prefix}base\" name is \"${prefix}base\": must be expanded by xacro before "
      "it is loaded");
  EXPECT_THAT(RefusalOfShape("<mesh filename=\"$(find arm)/a.stl\"/>"),
              HasSubstr("mesh filename is \"$(find arm)/a.stl\": must be expanded by xacro"));
}

TEST(UrdfRefusals, RobotsWithoutLinksOrWithTooManyAreRefused) {
  EXPECT_EQ(RefusalOf(""), "urdf: must have at least one link");
  std::string links;
  for (int i = 0; i < 5; ++i) links += "<link name=\"l" + std::to_string(i) + "\"/>";
  EXPECT_EQ(ExcessOfText(Robot(links), NoMeshes, {.max_links = 4}),
            "urdf: must have at most 4 links");
}

TEST(UrdfRefusals, NamesMustBeThereOnceAndFitForTables) {
  EXPECT_EQ(RefusalOf("<link/>"), "urdf: link name: must be given");
  EXPECT_EQ(RefusalOf(Links("aa")), "urdf: link \"a\": must not appear twice");
  EXPECT_EQ(RefusalOf(Links("abc") + JointText("j", "fixed", "a", "b") +
                      JointText("j", "fixed", "a", "c")),
            "urdf: joint \"j\": must not appear twice");
  const std::string rule = "must be 1 to 256 bytes of UTF-8 without control characters";
  for (const std::string& name :
       {std::string(), std::string("a\tb"), std::string(257, 'a'), std::string("a\xff"),
        std::string("\xc0\x80"), std::string("\xed\xa0\x80"), std::string("\xe2\x82")}) {
    EXPECT_THAT(RefusalOf("<link name=\"" + name + "\"/>"), HasSubstr(rule)) << name;
  }
}

TEST(UrdfRefusals, MessagesAreShortAndPrintable) {
  const std::string flood = "\x1b[2J\xff" + std::string(10'000, 'a');
  const std::string refusal = RefusalOfJoint("revolute", "<axis xyz=\"" + flood + "\"/>");
  EXPECT_LT(refusal.size(), 200u);
  EXPECT_THAT(refusal, HasSubstr("axis xyz is \"?[2J?aaa"));
}

TEST(UrdfRefusals, JointsMustJoinLinksOfTheRobot) {
  EXPECT_EQ(RefusalOf(Links("ab") + JointText("j", "fixed", "x", "b")),
            "urdf: joint \"j\": parent link is \"x\": must be a link of the robot");
  EXPECT_EQ(RefusalOf(Links("ab") + JointText("j", "fixed", "a", "x")),
            "urdf: joint \"j\": child link is \"x\": must be a link of the robot");
  EXPECT_EQ(
      RefusalOf(Links("ab") + "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/></joint>"),
      "urdf: joint \"j\": must have an element <child>");
  EXPECT_EQ(RefusalOf(Links("ab") + JointText("j", "fixed", "a", "b", "<child link=\"b\"/>")),
            "urdf: joint \"j\": has 2 elements <child>, must have one");
  EXPECT_EQ(RefusalOf(Links("ab") + "<joint name=\"j\" type=\"fixed\"><parent/>"
                                    "<child link=\"b\"/></joint>"),
            "urdf: joint \"j\": parent link: must be given");
}

TEST(UrdfRefusals, LinksMustFormOneTree) {
  EXPECT_EQ(RefusalOf(Links("abc") + JointText("j", "fixed", "a", "c") +
                      JointText("k", "fixed", "b", "c")),
            "urdf: joint \"k\": child link is \"c\": must have one parent, but is the child of "
            "joint \"j\" too");
  EXPECT_EQ(RefusalOf(Links("abc") + JointText("j", "fixed", "a", "b")),
            "urdf: links \"a\" and \"c\": must not both be roots, each link but one must be the "
            "child of a joint");
  EXPECT_THAT(RefusalOf(Links("ab") + JointText("j", "fixed", "a", "b") +
                        JointText("k", "fixed", "b", "a")),
              HasSubstr("is part of a cycle"));
  EXPECT_EQ(RefusalOf(Links("a") + JointText("j", "fixed", "a", "a")),
            "urdf: joint \"j\": is part of a cycle, links and joints must form a tree");
  // A cycle beside a valid tree, and a link below the cycle: the error names the cycle.
  EXPECT_THAT(RefusalOf(Links("abcd") + JointText("j", "fixed", "b", "c") +
                        JointText("k", "fixed", "c", "b") + JointText("l", "fixed", "c", "d")),
              AllOf(HasSubstr("is part of a cycle"), ::testing::Not(HasSubstr("\"l\""))));
}

TEST(UrdfRefusals, NumbersMustBeFiniteAndAsManyAsNeeded) {
  const std::string vector = "must be 3 finite numbers";
  for (const char* xyz : {"", "1 2", "1 2 3 4", "1 2 x", "1,2,3", "nan 0 0", "0 inf 0", "0 0 1e999",
                          "0x1 0 0", "1 2 3m"}) {
    EXPECT_EQ(RefusalOfJoint("revolute", std::string("<axis xyz=\"") + xyz + "\"/>"),
              std::string("urdf: joint \"elbow\": axis xyz is \"") + xyz + "\": " + vector);
    EXPECT_THAT(RefusalOfJoint("fixed", std::string("<origin rpy=\"") + xyz + "\"/>"),
                HasSubstr(vector));
  }
  for (const char* number : {"", "a", "nan", "-inf", "1 2"}) {
    EXPECT_EQ(RefusalOfJoint("revolute", std::string("<limit lower=\"") + number + "\"/>"),
              std::string("urdf: joint \"elbow\": limit lower is \"") + number +
                  "\": must be a finite number");
  }
  EXPECT_THAT(RefusalOfJoint("fixed", "<origin xyz=\"0 0 2e6\"/>"), HasSubstr("within 1e6 m"));
  EXPECT_THAT(RefusalOfJoint("fixed", "<origin quat_xyzw=\"0 0 0 1\"/>"), HasSubstr("as rpy"));
  EXPECT_THAT(RefusalOfJoint("fixed", "<origin/><origin/>"), HasSubstr("has 2 elements <origin>"));
}

TEST(UrdfRefusals, TagsAndAttributesAreCounted) {
  std::string many;
  for (int i = 0; i < 90'000; ++i) many += "<a b=\"\" c=\"\"/>";
  EXPECT_EQ(ExcessOfText(Robot(many), NoMeshes, {}),
            "urdf: must have at most 250000 tags and attributes");
  EXPECT_EQ(RefusalOf(Links("ab") + "<!--" + many + "-->"), RefusalOf(Links("ab")))
      << "a comment is one";
}

TEST(UrdfRefusals, AStopEndsReading) {
  std::stop_source stop;
  stop.request_stop();
  const auto read = ReadUrdf(Robot(Links("ab")), NoMeshes, {}, stop.get_token());
  EXPECT_TRUE(absl::IsCancelled(read.status())) << read.status();
}

TEST(UrdfRefusals, AxesMustHaveALength) {
  for (const char* kind : {"revolute", "continuous", "prismatic", "planar"}) {
    EXPECT_EQ(RefusalOfJoint(kind, "<axis xyz=\"0 0 0\"/><limit/>"),
              "urdf: joint \"elbow\": axis xyz is \"0 0 0\": must have positive length");
  }
}

TEST(UrdfRefusals, KindsMustBeKnown) {
  const std::string rule = "must be fixed, revolute, continuous, prismatic, planar or floating";
  EXPECT_EQ(RefusalOfJoint("hinge", ""), "urdf: joint \"elbow\" type is \"hinge\": " + rule);
  EXPECT_EQ(RefusalOf(Links("ab") + "<joint name=\"j\"/>"), "urdf: joint \"j\" type: " + rule);
}

TEST(UrdfRefusals, LimitsMustBeThereAndInOrder) {
  for (const char* kind : {"revolute", "prismatic"}) {
    EXPECT_EQ(RefusalOfJoint(kind, ""),
              std::string("urdf: joint \"elbow\": must have an element <limit>, being ") + kind);
    EXPECT_EQ(RefusalOfJoint(kind, "<limit lower=\"1\" upper=\"0.5\"/>"),
              "urdf: joint \"elbow\": limit lower is \"1\": must be at most the upper limit, 0.5");
    EXPECT_EQ(RefusalOfJoint(kind, "<limit lower=\"1\" upper=\"1\"/>"), "none");
  }
  EXPECT_EQ(RefusalOfJoint("continuous", "<limit velocity=\"-1\"/>"),
            "urdf: joint \"elbow\": limit velocity is \"-1\": must not be negative");
}

TEST(UrdfRefusals, MimicsMustLeadToAJointWithOneVariable) {
  const auto mimic = [](const std::string& joint) {
    return "<limit lower=\"-1\" upper=\"1\"/><mimic joint=\"" + joint + "\"/>";
  };
  EXPECT_EQ(RefusalOfJoint("revolute", mimic("elbow")),
            "urdf: joint \"elbow\": mimic joint is \"elbow\": must not lead back to itself");
  EXPECT_THAT(RefusalOf(Links("abc") + JointText("j", "revolute", "a", "b", mimic("k")) +
                        JointText("k", "revolute", "b", "c", mimic("j"))),
              HasSubstr("must not lead back to itself"));
  EXPECT_THAT(RefusalOf(Links("abc") + JointText("j", "fixed", "a", "b") +
                        JointText("k", "revolute", "b", "c", mimic("j"))),
              HasSubstr("leads to the fixed joint \"j\", must be one with one variable"));
  EXPECT_THAT(RefusalOf(Links("abc") + JointText("j", "revolute", "a", "b") +
                        JointText("k", "planar", "b", "c", mimic("j"))),
              HasSubstr("without exactly one variable"));
  EXPECT_THAT(RefusalOfJoint("revolute", "<limit/><mimic joint=\"x\" offset=\"nan\"/>"),
              HasSubstr("mimic offset is \"nan\": must be a finite number"));
}

TEST(UrdfRefusals, MimicsMustNotMultiplyBeyondAllGears) {
  const auto mimic = [](const std::string& numbers) {
    return "<limit/><mimic joint=\"j\" " + numbers + "/>";
  };
  const auto follower = [&](const std::string& kind, const std::string& numbers) {
    return RefusalOf(Links("abc") + JointText("j", "revolute", "a", "b") +
                     JointText("elbow", kind, "b", "c", mimic(numbers)));
  };
  EXPECT_EQ(
      follower("revolute", "multiplier=\"-1e305\""),
      "urdf: joint \"elbow\": mimic multiplier is -1e+305: must be at most 1e+06 in magnitude");
  EXPECT_EQ(follower("prismatic", "offset=\"1.5e6\""),
            "urdf: joint \"elbow\": mimic offset is 1.5e+06: must be at most 1e+06 in magnitude");
  const auto chain = [&](const std::string& first, const std::string& second) {
    return RefusalOf(
        Links("abcd") + JointText("j", "revolute", "a", "b") +
        JointText("k", "revolute", "b", "c", mimic(first)) +
        JointText("l", "revolute", "c", "d", "<limit/><mimic joint=\"k\" " + second + "/>"));
  };
  EXPECT_EQ(chain("multiplier=\"1000\"", "multiplier=\"1000\""), "none");
  EXPECT_EQ(
      chain("multiplier=\"2000\"", "multiplier=\"1000\" offset=\"1\""),
      "urdf: joint \"l\": mimic joint is \"k\": leads to \"j\" by a multiplier of 2e+06 and an "
      "offset of 1 along the chain, must be at most 1e+06 in magnitude, both");
  EXPECT_THAT(chain("offset=\"3000\"", "multiplier=\"500\""), HasSubstr("an offset of 1.5e+06"));
}

TEST(UrdfRefusals, ShapesMustHavePositiveDimensions) {
  const std::string place = "urdf: link \"a\": collision: geometry: ";
  EXPECT_EQ(RefusalOfShape("<sphere radius=\"0\"/>"),
            place + "sphere radius is \"0\": must be positive and finite");
  EXPECT_EQ(RefusalOfShape("<box size=\"1 -1 1\"/>"),
            place + "box size is \"1 -1 1\": must be positive and finite");
  EXPECT_EQ(RefusalOfShape("<cylinder radius=\"1\" length=\"-2\"/>"),
            place + "cylinder length is \"-2\": must be positive and finite");
  EXPECT_EQ(RefusalOfShape("<capsule radius=\"-1\" length=\"2\"/>"),
            place + "capsule radius is \"-1\": must be positive and finite");
  EXPECT_EQ(RefusalOfShape("<sphere radius=\"nan\"/>"),
            place + "sphere radius is \"nan\": must be a finite number");
  EXPECT_EQ(RefusalOfShape("<sphere radius=\"2e6\"/>"),
            place + "sphere radius is \"2e6\": must be at most 1e6 m");
  EXPECT_EQ(RefusalOfShape("<cylinder radius=\"1\"/>"), place + "cylinder length: must be given");
}

TEST(UrdfRefusals, ACollisionMustHaveOneKnownShape) {
  for (const char* shape :
       {"", "<cone radius=\"1\"/>", "<sphere radius=\"1\"/><sphere radius=\"1\"/>"}) {
    EXPECT_EQ(RefusalOfShape(shape),
              "urdf: link \"a\": collision: geometry: must have one element <box>, <cylinder>, "
              "<sphere>, <capsule> or <mesh>");
  }
  EXPECT_EQ(RefusalOf("<link name=\"a\"><collision name=\"c\"/></link>"),
            "urdf: link \"a\": collision \"c\": must have an element <geometry>");
  EXPECT_THAT(RefusalOf("<link name=\"a\"><collision><geometry><sphere radius=\"1\"/></geometry>"
                        "</collision><collision/></link>"),
              HasSubstr("link \"a\": collision[1]: must have an element"));
}

TEST(UrdfRefusals, PlacesAmongVeryManySiblingsAreLines) {
  const std::string ball = "<collision><geometry><sphere radius=\"1\"/></geometry></collision>\n";
  std::string balls;
  for (int i = 0; i < 1000; ++i) balls += ball;
  EXPECT_THAT(RefusalOf("<link name=\"a\">\n" + balls + "<collision/>" + ball + "</link>"),
              HasSubstr("link \"a\": collision[1000]: must have"));
  EXPECT_THAT(RefusalOf("<link name=\"a\">\n" + balls + ball + "<collision/></link>"),
              HasSubstr("link \"a\": collision[line 1005]: must have"));
}

TEST(UrdfRefusals, MeshesMustBeThereAndSound) {
  const std::string place =
      "urdf: link \"a\": collision: geometry: mesh filename is \"package://p/a.stl\": ";
  const std::string mesh = "<mesh filename=\"package://p/a.stl\"/>";
  EXPECT_EQ(RefusalOfShape(mesh), place + "must be one of the files sent along");
  EXPECT_EQ(RefusalOfShape(mesh, Always("")), place + "must not be empty");
  EXPECT_THAT(RefusalOfShape(mesh, Always("garbage")), HasSubstr(place + "must begin with"));
  EXPECT_THAT(RefusalOfShape("<mesh/>"), HasSubstr("mesh filename: must be given"));
  EXPECT_THAT(RefusalOfShape("<mesh filename=\"a.blend\"/>", Always("x")),
              HasSubstr("must end in .stl, .obj, .dae or .glb"));
}

TEST(UrdfRefusals, ScalesMustNotFlattenAMeshNorThrowItOutOfRange) {
  const MeshSource box = Always(testing::BinaryStl(testing::BoxMesh({1, 1, 1})));
  const auto refusal = [&](const std::string& scale) {
    return RefusalOfShape("<mesh filename=\"a.stl\" scale=\"" + scale + "\"/>", box);
  };
  EXPECT_THAT(refusal("1 0 1"), HasSubstr("mesh scale is \"1 0 1\": must not be 0"));
  EXPECT_THAT(refusal("1 1"), HasSubstr("must be 3 finite numbers"));
  EXPECT_THAT(refusal("1 1 nan"), HasSubstr("must be 3 finite numbers"));
  EXPECT_THAT(refusal("2e6 1 1"), HasSubstr("must be within 1e6 m of the origin"));
  EXPECT_EQ(refusal("0.001 0.001 0.001"), "none");
}

TEST(UrdfRefusals, MeshesTogetherAreCounted) {
  const MeshSource box = Always(testing::BinaryStl(testing::BoxMesh({1, 1, 1})));
  const auto link = [](const std::string& name, const std::string& file) {
    return "<link name=\"" + name + "\"><collision><geometry><mesh filename=\"" + file +
           "\"/></geometry></collision></link>" +
           (name == "a" ? "" : JointText("to_" + name, "fixed", "a", name));
  };
  const RobotLimits limits{.max_triangles = 24};
  const std::string shared = link("a", "x.stl") + link("b", "y.stl") + link("c", "x.stl");
  EXPECT_EQ(ExcessOfText(Robot(shared), box, limits), "none");
  EXPECT_THAT(
      ExcessOfText(Robot(shared + link("d", "z.stl")), box, limits),
      HasSubstr("link \"d\": collision: geometry: mesh filename is \"z.stl\": the meshes of "
                "the robot must have at most 24 triangles together"));
}

}  // namespace
}  // namespace cwm::collision
