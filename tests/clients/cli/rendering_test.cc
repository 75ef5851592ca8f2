#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "clients/cli/enum_names.h"
#include "clients/cli/mesh_frames.h"
#include "clients/cli/message_json.h"
#include "clients/cli/natural_order.h"
#include "clients/cli/object_table.h"
#include "clients/cli/quantity.h"
#include "clients/formats/file_bytes.h"
#include "cwm/v1/perception.pb.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Table, AlignsColumnsAndLeavesEmptyOnesOut) {
  std::ostringstream out;
  PrintTable({{"NAME"}, {"EMPTY"}, {"N", Align::kRight}},
             {{{"a", "", "10"}, "a note"}, {{"long", "", "7"}}}, TableStyle::kPlain, out);
  EXPECT_EQ(out.str(), "NAME   N\na     10\n    a note\nlong   7\n");
}

TEST(Quantity, CarriesItsUnit) {
  EXPECT_EQ(FormatLength(0.0352), "35.2 mm");
  EXPECT_EQ(FormatLength(-0.00000001), "0.0 mm");
  EXPECT_EQ(FormatLength(1.25), "1.250 m");
  EXPECT_EQ(FormatPercent(0.975), "97.5 %");
  cwm::v1::Box box;
  box.set_size_x_m(0.066);
  box.set_size_y_m(0.066);
  box.set_size_z_m(0.101);
  EXPECT_EQ(FormatSize(box), "66 x 66 x 101 mm");
  cwm::v1::Pose pose;
  pose.set_tx_m(1);
  pose.set_qw(1);
  EXPECT_EQ(FormatPose(pose), "1.000 0.000 0.000 m");
  pose.set_qz(-std::sqrt(0.5));
  pose.set_qw(-std::sqrt(0.5));
  EXPECT_EQ(FormatPose(pose), "1.000 0.000 0.000 m, 90.0 deg about 0.000 0.000 1.000");
}

TEST(EnumNames, DropTheirPrefix) {
  EXPECT_EQ(ShortName(cwm::v1::OBJECT_KIND_SUPPORT), "support");
  EXPECT_EQ(ShortName(cwm::v1::VERDICT_OUT_OF_LIMITS), "out_of_limits");
  EXPECT_EQ(ShortName(cwm::v1::SensorModel::KIND_TIME_OF_FLIGHT), "time_of_flight");
  EXPECT_EQ(ShortName(cwm::v1::ENGINE_UNSPECIFIED), "");
  EXPECT_EQ(ShortNames<cwm::v1::Engine>().size(), 4u);
}

TEST(ObjectTable, ShowsShapeQualitySizeSupportAndCoefficients) {
  cwm::v1::Object can;
  can.set_name("object_1");
  can.set_kind(cwm::v1::OBJECT_KIND_OBJECT);
  can.set_supported_by("support_1");
  auto& part = *can.add_shapes();
  part.mutable_cylinder()->set_radius_m(0.0331);
  part.mutable_cylinder()->set_length_m(0.101);
  part.mutable_fit()->set_rms_m(0.0012);
  part.mutable_fit()->set_inlier_count(2345);
  part.mutable_fit()->set_observed_fraction(0.45);
  for (const double c : {0.1, 0.2, 0.3, 0.0, 0.0, 1.0, 0.0331}) part.add_coefficients(c);
  can.mutable_bounds()->mutable_box()->set_size_x_m(0.066);
  std::ostringstream out;
  PrintObjectDetails(can, TableStyle::kPlain, out);
  for (const char* text :
       {"object_1", "cylinder r 33.1 mm, l 101.0 mm", "1.2 mm", "2345", "45.0 %", "support_1",
        "coefficients: point on axis 0.1000 0.2000 0.3000, axis 0.0000 0.0000 "
        "1.0000, radius 0.0331\n"}) {
    EXPECT_THAT(out.str(), HasSubstr(text));
  }
  EXPECT_THAT(out.str(), Not(HasSubstr("LABEL")));
}

TEST(ObjectTable, ShowsMotionAndVisibilityWhereObjectsAreFollowed) {
  google::protobuf::RepeatedPtrField<cwm::v1::Object> objects;
  cwm::v1::Object& can = *objects.Add();
  can.set_name("object_1");
  can.set_kind(cwm::v1::OBJECT_KIND_OBJECT);
  std::ostringstream still;
  PrintObjects(objects, TableStyle::kPlain, still);
  EXPECT_EQ(still.str().find("MOTION"), std::string::npos) << still.str();
  can.set_motion(cwm::v1::MOTION_AT_REST);
  can.set_visibility(cwm::v1::VISIBILITY_OCCLUDED);
  std::ostringstream followed;
  PrintObjects(objects, TableStyle::kPlain, followed);
  EXPECT_THAT(followed.str(), HasSubstr("MOTION   SEEN      POSITION m\n"));
  EXPECT_THAT(followed.str(), HasSubstr("at rest  occluded  0.000 0.000 0.000\n"));

  can.set_identity_certain(false);
  can.set_carried_by("panda/panda_hand");
  std::ostringstream details;
  PrintObjectDetails(can, TableStyle::kPlain, details);
  EXPECT_THAT(details.str(), HasSubstr("motion        at rest\nvisibility    occluded\n"));
  EXPECT_THAT(details.str(), HasSubstr("identity      not certain"));
  EXPECT_THAT(details.str(), HasSubstr("carried by    panda/panda_hand\n"));
}

TEST(ObjectTable, CountsTheBoxesOfAMover) {
  google::protobuf::RepeatedPtrField<cwm::v1::Object> objects;
  cwm::v1::Object& hand = *objects.Add();
  hand.set_name("mover_1");
  hand.set_kind(cwm::v1::OBJECT_KIND_MOVER);
  for (int i = 0; i < 3; ++i) hand.add_shapes()->mutable_box()->set_size_x_m(0.04);
  std::ostringstream out;
  PrintObjects(objects, TableStyle::kPlain, out);
  EXPECT_THAT(out.str(), HasSubstr("mover_1  mover  3 boxes  0.000 0.000 0.000\n"));
}

TEST(ObjectTable, TellsFactsOfSensorsOnOneLine) {
  cwm::v1::SensorFacts facts;
  EXPECT_EQ(FormatFacts(facts), "no longer followed");
  facts.set_motion(cwm::v1::MOTION_MOVING);
  facts.set_visibility(cwm::v1::VISIBILITY_VISIBLE);
  facts.set_identity_certain(true);
  EXPECT_EQ(FormatFacts(facts), "moving, visible");
  facts.set_identity_certain(false);
  facts.set_carried_by("arm/hand");
  EXPECT_EQ(FormatFacts(facts), "moving, visible, identity not certain, carried by arm/hand");
}

TEST(ObjectTable, NamesEveryCoefficientOfEveryShape) {
  cwm::v1::Object object;
  const auto add = [&](std::initializer_list<double> coefficients) -> cwm::v1::ShapePart& {
    cwm::v1::ShapePart& part = *object.add_shapes();
    for (const double value : coefficients) part.add_coefficients(value);
    return part;
  };
  add({0, 0, 1, -0.5}).mutable_half_space();
  add({1, 2, 3, 0.25}).mutable_sphere();
  add({1, 2, 3, 0, 1, 0, 0.5, 9}).mutable_cone();  // the last is of a newer server
  add({}).mutable_box();
  std::ostringstream out;
  PrintObjectDetails(object, TableStyle::kPlain, out);
  for (const char* text : {"coefficients: normal 0.0000 0.0000 1.0000, d -0.5000\n",
                           "coefficients: centre 1.0000 2.0000 3.0000, radius 0.2500\n",
                           "coefficients: apex 1.0000 2.0000 3.0000, axis 0.0000 1.0000 0.0000, "
                           "half angle 0.5000, others 9.0000\n"}) {
    EXPECT_THAT(out.str(), HasSubstr(text));
  }
}

TEST(ObjectTable, ListsNamesInNaturalOrder) {
  google::protobuf::RepeatedPtrField<cwm::v1::Object> objects;
  for (const char* name : {"object_1", "object_10", "object_2"}) objects.Add()->set_name(name);
  std::ostringstream out;
  PrintObjects(objects, TableStyle::kPlain, out);
  EXPECT_LT(out.str().find("object_2"), out.str().find("object_10"));
}

TEST(NaturalLess, ComparesDigitsAsNumbersAndAllElseByBytes) {
  const std::vector<std::string> ordered = {"",
                                            "01",
                                            "1",
                                            "2",
                                            "10",
                                            "a",
                                            "a1b2",
                                            "a1b10",
                                            "a2b1",
                                            "object",
                                            "object_2",
                                            "object_2_1",
                                            "object_10",
                                            "object_18446744073709551616",
                                            "object_18446744073709551617",
                                            "objects",
                                            "\xc3\xa9"};
  for (std::size_t i = 0; i < ordered.size(); ++i) {
    for (std::size_t j = 0; j < ordered.size(); ++j) {
      EXPECT_EQ(NaturalLess(ordered[i], ordered[j]), i < j) << ordered[i] << " and " << ordered[j];
    }
  }
}

TEST(MessageJson, PrintsDefaultsInSnakeCase) {
  cwm::v1::ListObjectsResponse response;
  response.set_revision(7);
  EXPECT_EQ(ToJson(response, JsonStyle::kOneLine),
            "{\"world_uid\":\"\",\"revision\":\"7\",\"objects\":[],\"next_page_token\":\"\"}");
}

TEST(MessageJson, TakesTheBytesOfAFile) {
  const std::string path = ::testing::TempDir() + "cwm_bytes_of_a_file";
  ASSERT_TRUE(formats::WriteFileBytes(path, std::string("\0\xff\n", 3)).ok());
  cwm::v1::CastRaysRequest request;
  const auto status = FromJson("{\"rays\": {\"data\": \"@" + path + "\"}}", request);
  ASSERT_TRUE(status.ok()) << status;
  EXPECT_EQ(request.rays().data(), std::string("\0\xff\n", 3));
  EXPECT_TRUE(absl::IsInvalidArgument(FromJson("{\"rays\": {\"data\": \"@/no/such\"}}", request)));
  EXPECT_TRUE(absl::IsInvalidArgument(FromJson("{\"rayz\": 1}", request)));
  EXPECT_TRUE(absl::IsInvalidArgument(FromJson("[1", request)));
}

TEST(MeshFrames, TurnAndShiftVertices) {
  cwm::v1::Pose pose;  // a quarter turn about z, then along x
  pose.set_tx_m(10);
  pose.set_qz(std::sqrt(0.5));
  pose.set_qw(std::sqrt(0.5));
  const formats::MeshFile mesh =
      TransformMesh(pose, formats::MeshFile{.vertices = {{1, 2, 3}}, .triangles = {}});
  constexpr double kRounding_m = 1e-14;
  EXPECT_NEAR(mesh.vertices[0][0], 8, kRounding_m);
  EXPECT_NEAR(mesh.vertices[0][1], 1, kRounding_m);
  EXPECT_NEAR(mesh.vertices[0][2], 3, kRounding_m);
}

}  // namespace
}  // namespace cwm::cli
