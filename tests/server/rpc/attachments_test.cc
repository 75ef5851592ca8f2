// Objects attached to robots, and robots as obstacles, over a real socket.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/collision/robot/robot_text.h"
#include "tests/server/rpc/running_server.h"

namespace cwm::server {
namespace {

using collision::testing::Robot;
using collision::testing::ThreeBalls;
using ::testing::ElementsAre;

// The arm "r" has balls of 0.1 m radius at x = 0, 0.5 and 1 (links a, c, e). There are two boxes
// with edges of 0.2 m: "cup" far away and "post" at x = 1.4.
class AttachmentsTest : public RunningServer {
 protected:
  void SetUp() override {
    Load("r");
    PutBox("cup", 5);
    PutBox("post", 1.4);
  }
  void Load(const std::string& name) {
    v1::LoadRobotHeader header;
    header.set_urdf(Robot(ThreeBalls()));
    LoadRobot(name, header);
  }
  // By default 0.25 m beyond the hand, i.e. 5 cm beside it.
  static v1::Change Attach(const std::string& link = "e", double x_m = 0.25) {
    v1::Change change;
    v1::AttachObject& attach = *change.mutable_attach();
    attach.set_name("cup");
    attach.set_robot("r");
    attach.set_link(link);
    attach.mutable_x_link_object()->set_tx_m(x_m);
    attach.mutable_x_link_object()->set_qw(1);
    return change;
  }
  static v1::Change Turn(const std::string& joint, double angle_rad) {
    v1::Change change;
    change.mutable_robot_state()->set_name("r");
    v1::VariableValue& value = *change.mutable_robot_state()->mutable_joints()->add_values();
    value.set_variable(joint);
    value.set_value(angle_rad);
    return change;
  }
  grpc::Status Apply(const std::vector<v1::Change>& changes, std::int64_t* revision = nullptr) {
    Call call;
    v1::ApplyChangesRequest request;
    request.mutable_changes()->Assign(changes.begin(), changes.end());
    v1::ApplyChangesResponse response;
    const grpc::Status status = world_->ApplyChanges(&call, request, &response);
    if (revision != nullptr) *revision = response.revision();
    return status;
  }
  void MustApply(const std::vector<v1::Change>& changes) {
    const grpc::Status status = Apply(changes);
    ASSERT_TRUE(status.ok()) << status.error_message();
  }
  v1::Object Cup() {
    Call call;
    v1::GetObjectRequest request;
    request.set_name("cup");
    v1::GetObjectResponse response;
    const grpc::Status status = world_->GetObject(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response.object();
  }
  static v1::CheckCollisionsRequest AboutArm() {
    v1::CheckCollisionsRequest request;
    request.mutable_subject()->mutable_robot()->set_robot("r");
    request.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
    return request;
  }
  v1::CheckCollisionsResponse Check(const v1::CheckCollisionsRequest& request) {
    Call call;
    v1::CheckCollisionsResponse response;
    const grpc::Status status = query_->CheckCollisions(&call, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return response;
  }
};

TEST_F(AttachmentsTest, AreShownAndMoveWithTheArm) {
  EXPECT_FALSE(Cup().has_attachment());
  MustApply({Attach()});
  const v1::Object held = Cup();
  EXPECT_EQ(held.attached_to(), "r/e");
  EXPECT_EQ(held.attachment().robot(), "r");
  EXPECT_EQ(held.attachment().x_link_object().tx_m(), 0.25);
  EXPECT_NEAR(held.x_world_object().tx_m(), 1.25, 1e-12);
  MustApply({Turn("shoulder", 1.5)});
  EXPECT_NEAR(Cup().x_world_object().ty_m(), 1.25 * std::sin(1.5), 1e-12);
  v1::Change detach;
  detach.mutable_detach()->set_name("cup");
  MustApply({detach});
  EXPECT_FALSE(Cup().has_attachment());
  EXPECT_EQ(Cup().attached_to(), "");
  EXPECT_NEAR(Cup().x_world_object().ty_m(), 1.25 * std::sin(1.5), 1e-12);
}

TEST_F(AttachmentsTest, AreTheSameInAnOverlayAndStored) {
  EXPECT_EQ(Check(AboutArm()).rows(0).verdict(), v1::VERDICT_FREE);
  v1::CheckCollisionsRequest what_if = AboutArm();
  *what_if.mutable_options()->add_overlay() = Attach();
  v1::CheckCollisionsResponse supposed = Check(what_if);
  EXPECT_FALSE(Cup().has_attachment());
  ASSERT_EQ(supposed.rows_size(), 1);
  EXPECT_EQ(supposed.rows(0).verdict(), v1::VERDICT_COLLISION);
  EXPECT_EQ(supposed.rows(0).object(), "post");
  EXPECT_EQ(supposed.rows(0).body_link(), "e");
  EXPECT_EQ(supposed.rows(0).body_object(), "cup");
  EXPECT_THAT(supposed.body_links(), ElementsAre("a", "c", "e", "e"));
  EXPECT_THAT(supposed.body_objects(), ElementsAre("", "", "", "cup"));
  MustApply({Attach()});
  v1::CheckCollisionsResponse stored = Check(AboutArm());
  stored.clear_revision();
  supposed.clear_revision();
  EXPECT_EQ(stored.SerializeAsString(), supposed.SerializeAsString());
}

TEST_F(AttachmentsTest, MeetTheOtherLinksAndAreLeftOut) {
  MustApply({Attach("e", -0.5)});  // around link c
  v1::CheckCollisionsRequest request = AboutArm();
  const v1::CheckCollisionsResponse response = Check(request);
  EXPECT_EQ(response.rows(0).verdict(), v1::VERDICT_COLLISION);
  EXPECT_FALSE(response.rows(0).has_object());
  EXPECT_EQ(response.rows(0).body_object(), "cup");
  EXPECT_EQ(response.rows(0).object_link(), "c");
  request.mutable_options()->add_ignore("cup");
  EXPECT_EQ(Check(request).rows(0).verdict(), v1::VERDICT_FREE);
  v1::Change touching = Attach("e", -0.5);
  touching.mutable_attach()->add_touch_links("c");
  MustApply({touching});
  EXPECT_EQ(Check(AboutArm()).rows(0).verdict(), v1::VERDICT_FREE);
}

TEST_F(AttachmentsTest, OtherRobotsAreNamedWithTheirLinks) {
  Load("s");
  v1::Change aside;
  aside.mutable_robot_state()->set_name("s");
  v1::Pose& base = *aside.mutable_robot_state()->mutable_x_world_base();
  base.set_ty_m(0.15);
  base.set_tx_m(1);
  base.set_qw(1);
  MustApply({aside});
  const v1::CheckCollisionsResponse response = Check(AboutArm());
  EXPECT_EQ(response.rows(0).verdict(), v1::VERDICT_COLLISION);
  EXPECT_EQ(response.rows(0).object(), "s");
  EXPECT_EQ(response.rows(0).object_link(), "a");
  EXPECT_EQ(response.rows(0).body_link(), "e");
  ASSERT_EQ(response.objects_size(), 1);
  EXPECT_NE(response.objects(0).uid(), "");
  EXPECT_THAT(response.objects(0).part_links(), ElementsAre("a", "c", "e"));
  v1::CheckCollisionsRequest without = AboutArm();
  without.mutable_options()->add_ignore("s");
  EXPECT_EQ(Check(without).rows(0).verdict(), v1::VERDICT_FREE);

  v1::CastRaysRequest rays;
  const std::vector<double> ray = {1, 5, 0, 0, -1, 0};
  rays.mutable_rays()->set_data(
      std::string(reinterpret_cast<const char*>(ray.data()), ray.size() * sizeof(double)));
  rays.mutable_options()->set_result_form(v1::RESULT_FORM_ROWS);
  Call call;
  v1::CastRaysResponse hits;
  ASSERT_TRUE(query_->CastRays(&call, rays, &hits).ok());
  EXPECT_EQ(hits.rows(0).object(), "s");
  EXPECT_EQ(hits.rows(0).object_link(), "a");
  EXPECT_NEAR(hits.rows(0).distance_m(), 4.75, 1e-9);
}

TEST_F(AttachmentsTest, AreWatched) {
  Call call;
  v1::WatchWorldRequest request;
  request.set_from_revision(3);
  request.set_world_uid((*application_.worlds.Find(""))->uid());
  const auto reader = world_->WatchWorld(&call, request);
  MustApply({Attach()});
  MustApply({Turn("shoulder", 0.5)});
  v1::WatchWorldResponse message;
  while (reader->Read(&message) && !message.has_events()) {
  }
  ASSERT_EQ(message.events().events_size(), 1);
  EXPECT_EQ(message.events().events(0).put().attachment().link(), "e");
  while (reader->Read(&message) && !message.has_events()) {
  }
  EXPECT_EQ(message.revision(), 5);
  ASSERT_EQ(message.events().events_size(), 1);
  EXPECT_EQ(message.events().events(0).move().name(), "cup");
  EXPECT_EQ(message.events().robot_events_size(), 1);
  call.TryCancel();
  reader->Finish();
}

TEST_F(AttachmentsTest, RefuseWhatIsNotThere) {
  v1::Change change = Attach("tail");
  grpc::Status status = Apply({change});
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(FieldIn(status), "changes[0].attach.link");
  change = Attach();
  change.mutable_attach()->add_touch_links("tail");
  EXPECT_EQ(FieldIn(Apply({change})), "changes[0].attach.touch_links[0]");
  change = Attach();
  change.mutable_attach()->set_robot("nobody");
  status = Apply({change});
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(ReasonIn(status), "ROBOT_UNKNOWN");
  change = Attach();
  change.mutable_attach()->set_name("ghost");
  EXPECT_EQ(ReasonIn(Apply({change})), "OBJECT_UNKNOWN");
  change.mutable_attach()->set_name("");
  EXPECT_EQ(FieldIn(Apply({change})), "changes[0].attach.name");
  v1::CheckCollisionsRequest request = AboutArm();
  request.mutable_options()->set_support_tolerance_m(0.11);
  Call call;
  v1::CheckCollisionsResponse ignored;
  EXPECT_EQ(FieldIn(query_->CheckCollisions(&call, request, &ignored)),
            "options.support_tolerance_m");
}

}  // namespace
}  // namespace cwm::server
