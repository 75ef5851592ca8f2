// Paddings, scales and tools of robots, rules that check pairs, and all contacts of a world.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/collision/robot/robot_text.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::Robot;
using collision::testing::ThreeBalls;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kSrdf[] =
    "<robot name=\"r\"><group name=\"arm\"><joint name=\"shoulder\"/><joint name=\"elbow\"/>"
    "</group><group_state name=\"folded\" group=\"arm\"><joint name=\"elbow\" value=\"3\"/>"
    "</group_state><disable_collisions link1=\"a\" link2=\"c\"/>"
    "<disable_collisions link1=\"c\" link2=\"e\"/></robot>";

std::string Bytes(const std::vector<double>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
}
template <class Number>
std::vector<Number> NumbersIn(const std::string& bytes) {
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

// The arm of ThreeBalls: balls a, c and e of 0.1 m radius at x = 0, 0.5 and 1 m.
v1::LoadRobotHeader Header(const std::string& srdf = kSrdf) {
  v1::LoadRobotHeader header;
  header.set_urdf(Robot(ThreeBalls()));
  header.set_srdf(srdf);
  return header;
}
void Pad(const std::string& link, double padding_m, v1::LoadRobotHeader& header) {
  header.add_link_padding()->set_link(link);
  header.mutable_link_padding()->rbegin()->set_padding_m(padding_m);
}

class RobotSettings : public RunningServer {
 protected:
  grpc::Status Load(const v1::LoadRobotHeader& header, v1::LoadRobotResponse* response) {
    Call call;
    const auto writer = robot_->LoadRobot(&call, response);
    v1::LoadRobotRequest request;
    *request.mutable_header() = header;
    writer->Write(request);
    request.mutable_finish();
    writer->Write(request);
    writer->WritesDone();
    return writer->Finish();
  }
  v1::LoadRobotResponse MustLoad(const v1::LoadRobotHeader& header) {
    v1::LoadRobotResponse response;
    const grpc::Status status = Load(header, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
  std::string RefusedField(const v1::LoadRobotHeader& header) {
    v1::LoadRobotResponse response;
    return FieldIn(Load(header, &response));
  }
  v1::CheckCollisionsRequest CheckAt(const std::vector<double>& row) {
    v1::CheckCollisionsRequest request;
    request.mutable_subject()->mutable_robot()->set_robot("r");
    request.mutable_subject()->mutable_robot()->set_group("arm");
    request.mutable_subject()->mutable_robot()->mutable_rows()->set_data(Bytes(row));
    return request;
  }
  v1::Verdict VerdictOf(const v1::CheckCollisionsRequest& request) {
    Call call;
    v1::CheckCollisionsResponse response;
    const grpc::Status status = query_->CheckCollisions(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return static_cast<v1::Verdict>(response.verdicts()[0]);
  }
  void Apply(const v1::Change& change) {
    v1::ApplyChangesRequest request;
    *request.add_changes() = change;
    Call call;
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
  }
  v1::GetWorldContactsResponse Contacts(const v1::GetWorldContactsRequest& request) {
    Call call;
    v1::GetWorldContactsResponse response;
    const grpc::Status status = query_->GetWorldContacts(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
};

TEST_F(RobotSettings, AreToldWithTheRobot) {
  v1::LoadRobotHeader header = Header();
  Pad("*", 0.01, header);
  Pad("e", 0.05, header);
  header.add_link_scale()->set_link("c");
  header.mutable_link_scale(0)->set_scale(2);
  v1::RobotTool& tool = *header.add_tools();
  tool.set_name("tip");
  tool.set_link("e");
  tool.set_group("arm");
  tool.mutable_x_link_tool()->set_tx_m(0.2);
  tool.mutable_x_link_tool()->set_qw(1);
  MustLoad(header);
  Call call;
  v1::ListRobotsResponse listed;
  ASSERT_TRUE(robot_->ListRobots(&call, {}, &listed).ok());
  const v1::Robot& robot = listed.robots(0);
  std::map<std::string, v1::RobotLink> links;
  for (const v1::RobotLink& link : robot.links()) links[link.name()] = link;
  EXPECT_EQ(links["a"].padding_m(), 0.01);
  EXPECT_EQ(links["e"].padding_m(), 0.05);
  EXPECT_EQ(links["a"].scale(), 1);
  EXPECT_EQ(links["c"].scale(), 2);
  ASSERT_EQ(robot.tools_size(), 1);
  EXPECT_EQ(robot.tools(0).name(), "tip");
  EXPECT_EQ(robot.tools(0).link(), "e");
  EXPECT_EQ(robot.tools(0).group(), "arm");
  EXPECT_EQ(robot.tools(0).x_link_tool().tx_m(), 0.2);
}

TEST_F(RobotSettings, ArePartOfWhatARobotIs) {
  v1::LoadRobotHeader header = Header();
  Pad("e", 0.05, header);
  EXPECT_EQ(MustLoad(header).revision(), 1);
  EXPECT_EQ(MustLoad(header).revision(), 1) << "the same robot";
  header.mutable_link_padding(0)->set_padding_m(0.06);
  EXPECT_EQ(MustLoad(header).revision(), 2);
  header.add_link_scale()->set_link("a");
  header.mutable_link_scale(0)->set_scale(0.5);
  EXPECT_EQ(MustLoad(header).revision(), 3);
  header.add_tools()->set_name("tip");
  header.mutable_tools(0)->set_link("e");
  EXPECT_EQ(MustLoad(header).revision(), 4);
  EXPECT_EQ(MustLoad(header).revision(), 4);
}

TEST_F(RobotSettings, NameTheFieldThatIsWrong) {
  v1::LoadRobotHeader header = Header();
  Pad("a", 0.01, header);
  Pad("z", 0.01, header);
  EXPECT_EQ(RefusedField(header), "header.link_padding[1].link");
  header.mutable_link_padding(1)->set_link("a");
  EXPECT_EQ(RefusedField(header), "header.link_padding[1].link") << "twice";
  header.mutable_link_padding(1)->set_link("c");
  header.mutable_link_padding(1)->set_padding_m(-0.1);
  EXPECT_EQ(RefusedField(header), "header.link_padding[1].padding_m");
  header = Header();
  header.add_link_scale()->set_link("a");
  EXPECT_EQ(RefusedField(header), "header.link_scale[0].scale") << "0";
  header.mutable_link_scale(0)->set_scale(101);
  EXPECT_EQ(RefusedField(header), "header.link_scale[0].scale");
  header = Header();
  header.add_tools()->set_name("tip");
  EXPECT_EQ(RefusedField(header), "header.tools[0].link");
  header.mutable_tools(0)->set_link("e");
  header.mutable_tools(0)->set_group("legs");
  EXPECT_EQ(RefusedField(header), "header.tools[0].group");
  header.mutable_tools(0)->set_group("arm");
  header.mutable_tools(0)->set_link("a");
  EXPECT_EQ(RefusedField(header), "header.tools[0].group") << "the group does not move the base";
  header.mutable_tools(0)->set_link("e");
  *header.add_tools() = header.tools(0);
  EXPECT_EQ(RefusedField(header), "header.tools[1].name");
}

// The box of 0.2 m at x = 1.25 m is 0.05 m from ball e, and 0.05 m from it with a scale of 1.
TEST_F(RobotSettings, WidenWhatCollides) {
  PutBox("post", 1.25);
  MustLoad(Header());
  EXPECT_EQ(VerdictOf(CheckAt({0, 0})), v1::VERDICT_FREE);
  v1::LoadRobotHeader padded = Header();
  Pad("e", 0.06, padded);
  MustLoad(padded);
  EXPECT_EQ(VerdictOf(CheckAt({0, 0})), v1::VERDICT_COLLISION);
  v1::CheckCollisionsRequest without = CheckAt({0, 0});
  v1::LinkPadding& padding = *without.mutable_subject()->mutable_robot()->add_link_padding();
  padding.set_link("e");
  padding.set_padding_m(0.04);
  EXPECT_EQ(VerdictOf(without), v1::VERDICT_FREE);
  padding.set_link("z");
  Call call;
  v1::CheckCollisionsResponse ignored;
  EXPECT_EQ(FieldIn(query_->CheckCollisions(&call, without, &ignored)),
            "subject.robot.link_padding[0].link");
  v1::LoadRobotHeader scaled = Header();
  scaled.add_link_scale()->set_link("*");
  scaled.mutable_link_scale(0)->set_scale(1.6);
  MustLoad(scaled);
  EXPECT_EQ(VerdictOf(CheckAt({0, 0})), v1::VERDICT_COLLISION) << "a radius of 0.16 m";
}

TEST_F(RobotSettings, GiveSolveItsTool) {
  v1::LoadRobotHeader header = Header();
  v1::RobotTool& tool = *header.add_tools();
  tool.set_name("tip");
  tool.set_link("e");
  tool.set_group("arm");
  tool.mutable_x_link_tool()->set_tx_m(0.25);
  tool.mutable_x_link_tool()->set_qw(1);
  *header.add_tools() = tool;
  header.mutable_tools(1)->set_name("bare");
  header.mutable_tools(1)->set_group("");
  header.mutable_tools(1)->clear_x_link_tool();
  MustLoad(header);
  v1::SolvePosesRequest request;
  request.mutable_robot()->set_robot("r");
  request.mutable_robot()->set_group("arm");
  const auto solve = [&](double x_m, grpc::Status* refused = nullptr) {
    request.mutable_x_world_tool()->set_data(Bytes({x_m, 0, 0, 0, 0, 0, 1}));
    Call call;
    v1::SolvePosesResponse response;
    const grpc::Status status = query_->SolvePoses(&call, request, &response);
    if (refused != nullptr) *refused = status;
    return response;
  };
  const auto status_at = [&](double x_m) {
    const v1::SolvePosesResponse response = solve(x_m);
    EXPECT_EQ(response.tool_link(), "e");
    return static_cast<v1::PoseStatus>(response.status()[0]);
  };
  EXPECT_EQ(status_at(1.25), v1::POSE_STATUS_SOLVED) << "the group's tool, both joints at 0";
  EXPECT_EQ(status_at(1), v1::POSE_STATUS_UNREACHABLE);
  request.set_tool("bare");
  EXPECT_EQ(status_at(1), v1::POSE_STATUS_SOLVED);
  grpc::Status refused;
  request.set_tool_link("e");
  solve(1, &refused);
  EXPECT_EQ(FieldIn(refused), "tool");
  request.clear_tool_link();
  request.set_tool("hook");
  solve(1, &refused);
  EXPECT_EQ(FieldIn(refused), "tool");
  EXPECT_THAT(refused.error_message(), HasSubstr("\"tip\", \"bare\""));
}

TEST_F(RobotSettings, RulesCheckPairsThatTheSrdfDisables) {
  MustLoad(
      Header("<robot name=\"r\"><group name=\"arm\"><joint name=\"shoulder\"/>"
             "<joint name=\"elbow\"/></group><disable_collisions link1=\"a\" link2=\"e\"/>"
             "</robot>"));
  EXPECT_EQ(VerdictOf(CheckAt({0, 3})), v1::VERDICT_FREE);
  v1::Change change;
  v1::AllowCollision& allow = *change.mutable_allow();
  allow.mutable_pair()->mutable_a()->set_name("r");
  allow.mutable_pair()->mutable_a()->set_link("e");
  allow.mutable_pair()->mutable_b()->set_name("r");
  allow.mutable_pair()->mutable_b()->set_link("a");
  allow.set_check(true);
  v1::CheckCollisionsRequest supposed = CheckAt({0, 3});
  *supposed.mutable_options()->add_overlay() = change;
  EXPECT_EQ(VerdictOf(supposed), v1::VERDICT_COLLISION) << "in an overlay";
  EXPECT_EQ(VerdictOf(CheckAt({0, 3})), v1::VERDICT_FREE);
  Apply(change);
  EXPECT_EQ(VerdictOf(CheckAt({0, 3})), v1::VERDICT_COLLISION);
  Call call;
  v1::GetWorldResponse world;
  ASSERT_TRUE(world_->GetWorld(&call, {}, &world).ok());
  ASSERT_EQ(world.pair_rules_size(), 1);
  EXPECT_TRUE(world.pair_rules(0).check());
  EXPECT_FALSE(world.pair_rules(0).allowed());
  allow.set_withdraw(true);
  v1::ApplyChangesRequest both;
  *both.add_changes() = change;
  Call second;
  v1::ApplyChangesResponse ignored;
  EXPECT_EQ(FieldIn(world_->ApplyChanges(&second, both, &ignored)), "changes[0].allow.check");
}

TEST_F(RobotSettings, WarnOfStatesInSelfCollision) {
  EXPECT_THAT(MustLoad(Header()).warnings(),
              ::testing::Contains(HasSubstr("named state folded of arm (a with e) in "
                                            "self-collision")));
  v1::LoadRobotHeader nested = Header("<robot name=\"r\"/>");
  nested.set_urdf(Robot(ThreeBalls() + collision::testing::Ball("f") +
                        collision::testing::JointText("swivel", "continuous", "c", "f")));
  EXPECT_THAT(MustLoad(nested).warnings(),
              ::testing::Contains(HasSubstr("pair c with f always in collision")));
}

TEST_F(RobotSettings, ContactsOfTheWorldAreThoseOfItsMembers) {
  MustLoad(Header());
  PutBox("in_e", 1.05);
  PutBox("next", 1.22);
  v1::GetWorldContactsRequest request;
  const v1::GetWorldContactsResponse columns = Contacts(request);
  EXPECT_TRUE(columns.is_complete());
  ASSERT_EQ(columns.objects_size(), 3);
  EXPECT_EQ(columns.objects(0).name(), "in_e");
  EXPECT_EQ(columns.objects(2).name(), "r");
  EXPECT_THAT(columns.objects(2).part_links(), ElementsAre("a", "c", "e"));
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_a()), ElementsAre(0, 0));
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.object_b()), ElementsAre(2, 1));
  EXPECT_THAT(NumbersIn<std::int32_t>(columns.part_b()), ElementsAre(2, 0));
  EXPECT_THAT(columns.bound_m(), IsEmpty()) << "all are exact";
  request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  const v1::GetWorldContactsResponse rows = Contacts(request);
  ASSERT_EQ(rows.rows_size(), 2);
  EXPECT_EQ(rows.rows(0).object_a(), "in_e");
  EXPECT_FALSE(rows.rows(0).has_link_a());
  EXPECT_EQ(rows.rows(0).link_b(), "e");
  EXPECT_NEAR(rows.rows(1).distance_m(), -0.03, 1e-9);
  EXPECT_NEAR(rows.rows(1).normal().x(), 1, 1e-9);
  EXPECT_EQ(rows.rows(1).trust(), v1::TRUST_EXACT);
}

TEST_F(RobotSettings, ContactsOfTheWorldTakeOverlaysRevisionsAndOptions) {
  MustLoad(Header());
  const std::int64_t revision = PutBox("in_e", 1.05);
  PutBox("next", 1.22);
  v1::GetWorldContactsRequest request;
  const auto count = [&] { return Contacts(request).trust().size(); };
  EXPECT_EQ(count(), 2U);
  request.mutable_options()->mutable_at_revision()->set_exact(revision);
  EXPECT_EQ(count(), 1U);
  *request.mutable_options()->add_overlay() = PutBoxChange("other", 1.22);
  EXPECT_EQ(count(), 2U);
  request.mutable_options()->add_ignore("in_e");
  EXPECT_EQ(count(), 0U) << "the box of the overlay is 0.02 m from ball e";
  request = {};
  request.mutable_options()->set_max_contacts(1);
  EXPECT_FALSE(Contacts(request).is_complete());
  request.mutable_options()->set_max_contacts(65'537);
  Call call;
  v1::GetWorldContactsResponse ignored;
  EXPECT_EQ(FieldIn(query_->GetWorldContacts(&call, request, &ignored)), "options.max_contacts");
}

TEST_F(RobotSettings, ContactsOfTheWorldAreAnsweredOverAStream) {
  PutBox("one", 1);
  PutBox("two", 1.15);
  Call call;
  const auto stream = query_->StreamQueries(&call);
  v1::StreamQueriesRequest request;
  request.set_id(5);
  request.mutable_get_world_contacts();
  ASSERT_TRUE(stream->Write(request));
  v1::StreamQueriesResponse response;
  ASSERT_TRUE(stream->Read(&response));
  EXPECT_EQ(response.id(), 5);
  EXPECT_THAT(NumbersIn<double>(response.get_world_contacts().distance_m()),
              ElementsAre(::testing::DoubleNear(-0.05, 1e-9)));
  stream->WritesDone();
  EXPECT_TRUE(stream->Finish().ok());
}

}  // namespace
}  // namespace cwm::server
