// Scans of a view that did not change since it was interpreted, and what makes it another one.
#include "server/core/unchanged_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "absl/strings/str_cat.h"
#include "perception/cloud/returns.h"
#include "perception/simulation/random_draws.h"
#include "server/core/error.h"
#include "tests/server/core/table_scans.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

class UnchangedViewTest : public ::testing::Test {
 protected:
  IngestRequest Request() const { return RequestFor(scan_); }

  // The same scan with other noise along its rays, well within that of the sensor.
  IngestRequest Again(std::uint64_t seed = 1) const {
    IngestRequest request = Request();
    perception::RandomDraws draws(seed, 0);
    for (Eigen::Vector3f& p : request.cloud.points) {
      p *= static_cast<float>(1 + 0.001 * draws.Normal());
    }
    return request;
  }

  // Ingests; the interpreter returns the truth of `scan`.
  IngestOutcome MustIngest(const IngestRequest& request, const TableScan& scan) {
    const auto outcome =
        Ingest(world_, request,
               [&](const perception::PointCloud& cloud, const perception::InterpretOptions& options,
                   std::stop_token stop) {
                 ++interpreted_;
                 return TruthOf(scan)(cloud, options, std::move(stop));
               },
               {});
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *outcome : IngestOutcome{};
  }
  IngestOutcome MustIngest(const IngestRequest& request) { return MustIngest(request, scan_); }

  void ExpectUnchanged(const IngestRequest& request) {
    const int before = interpreted_;
    EXPECT_TRUE(MustIngest(request).unchanged_view);
    EXPECT_EQ(interpreted_, before);
  }
  void ExpectInterpreted(const IngestRequest& request) {
    const int before = interpreted_;
    EXPECT_FALSE(MustIngest(request).unchanged_view);
    EXPECT_EQ(interpreted_, before + 1);
  }
  void MustApply(const Change& change) {
    const auto applied = world_.Apply(std::vector{change}, {});
    ASSERT_TRUE(applied.ok()) << applied.status();
  }

  const TableScan scan_ = ScanTable(TwoBoxes());
  World world_{"w", "uid", {}};
  int interpreted_ = 0;
};

TEST_F(UnchangedViewTest, TheReplyIsThatOfAnInterpretationWithoutOne) {
  IngestRequest first = Request();
  first.frame_stamp = std::chrono::system_clock::time_point(std::chrono::hours(1));
  const IngestOutcome interpreted = MustIngest(first);
  IngestRequest second = Again();
  second.frame_stamp = first.frame_stamp + std::chrono::seconds(1);
  const IngestOutcome outcome = MustIngest(second);
  EXPECT_TRUE(outcome.unchanged_view);
  EXPECT_EQ(interpreted_, 1);
  EXPECT_EQ(outcome.revision, Revision{1});
  EXPECT_EQ(outcome.X_WC.matrix(), interpreted.X_WC.matrix());
  EXPECT_EQ(outcome.supports, interpreted.supports);
  EXPECT_EQ(outcome.objects, interpreted.objects);
  EXPECT_EQ(outcome.support_reachable, interpreted.support_reachable);
  EXPECT_THAT(outcome.kept, ElementsAre("support_1", "object_1", "object_2"));
  EXPECT_THAT(outcome.added, IsEmpty());
  ASSERT_EQ(outcome.labels.size(), interpreted.labels.size());
  // At an edge a pixel may show the surface beside it; noise of 1 mm moves none.
  EXPECT_EQ(outcome.labels, interpreted.labels);
  EXPECT_EQ(outcome.report.points_in, scan_.cloud.size());
  EXPECT_EQ(world_.observations().Get("object_2").last, second.frame_stamp);
  std::vector<std::string> stages;
  for (const perception::StageTime& stage : outcome.report.stages) stages.push_back(stage.stage);
  EXPECT_THAT(stages, ElementsAre("compare", "publish"));
}

TEST_F(UnchangedViewTest, LostAndNewReturnsAreLabelledByTheSurfaceAroundThem) {
  IngestRequest first = Request();
  const Eigen::Vector3f none = Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  // Every fifth pixel has no return then, and every seventh one has none now.
  for (std::size_t i = 0; i < first.cloud.points.size(); i += 5) first.cloud.points[i] = none;
  TableScan thinned = scan_;
  for (std::size_t i = 0; i < thinned.truth.labels.size(); i += 5) thinned.truth.labels[i] = 0;
  MustIngest(first, thinned);
  IngestRequest second = Again();
  for (std::size_t i = 0; i < second.cloud.points.size(); i += 7) second.cloud.points[i] = none;
  const IngestOutcome outcome = MustIngest(second);
  ASSERT_TRUE(outcome.unchanged_view);
  int wrong = 0;
  int returns = 0;
  for (std::size_t i = 0; i < outcome.labels.size(); ++i) {
    const bool has_return = second.cloud.points[i].allFinite();
    returns += static_cast<int>(has_return);
    const std::uint32_t truth = has_return ? scan_.truth.labels[i] : 0;
    wrong += static_cast<int>(outcome.labels[i] != truth);
  }
  // Where a box stands on the table, a new return is explained by both.
  EXPECT_LT(wrong, returns / 500);
  EXPECT_EQ(outcome.report.points_finite, static_cast<std::uint64_t>(returns));
}

TEST_F(UnchangedViewTest, WhatMovesComesOrGoesIsInterpreted) {
  MustIngest(Request());
  const auto expect_interpreted = [&](const perception::SimulatedScene& scene) {
    const TableScan scan = ScanTable(scene);
    EXPECT_FALSE(MustIngest(RequestFor(scan), scan).unchanged_view);
    MustIngest(Request());  // as before
  };
  perception::SimulatedScene moved = EmptyTable();
  AddBox(moved, "left", 0.02, 0.2, {0.1, 0.16, 0.12});
  AddBox(moved, "right", 0, -0.2, {0.08, 0.08, 0.2});
  expect_interpreted(moved);
  perception::SimulatedScene added = TwoBoxes();
  AddBox(added, "new", -0.2, 0, {0.03, 0.03, 0.03});
  expect_interpreted(added);
  perception::SimulatedScene removed = EmptyTable();
  AddBox(removed, "left", 0, 0.2, {0.1, 0.16, 0.12});
  expect_interpreted(removed);
}

TEST_F(UnchangedViewTest, SmallChangesAddUpToTheViewThatWasInterpreted) {
  MustIngest(Request());
  bool was_interpreted = false;
  for (int step = 1; step <= 8 && !was_interpreted; ++step) {
    perception::SimulatedScene scene = EmptyTable();
    AddBox(scene, "left", -0.003 * step, 0.2, {0.1, 0.16, 0.12});
    AddBox(scene, "right", 0, -0.2, {0.08, 0.08, 0.2});
    const TableScan scan = ScanTable(scene);
    was_interpreted = !MustIngest(RequestFor(scan), scan).unchanged_view;
  }
  EXPECT_TRUE(was_interpreted) << "24 mm in steps of 3 mm";
}

TEST_F(UnchangedViewTest, WhatOthersChangeInTheViewIsInterpreted) {
  MustIngest(Request());
  ExpectUnchanged(Again());
  Change moved{collision::MoveObject{"object_1", MakeTranslation(0.1, 0.1, 1)}, std::nullopt};
  MustApply(moved);
  ExpectInterpreted(Again());
  ExpectUnchanged(Again());
  MustApply(Remove("object_2"));
  ExpectInterpreted(Again());
  Change put = Put("users_box");
  std::get<collision::PutObject>(put.what).X_WO = MakeTranslation(0.2, 0, 1);
  MustApply(put);
  ExpectInterpreted(Again());
  MustApply(Remove("users_box"));
  ExpectInterpreted(Again());
}

TEST_F(UnchangedViewTest, WhatHappensOutOfViewIsNothingToIt) {
  MustIngest(Request());
  const Revision before = world_.Snapshot()->revision();
  MustApply(Put("behind_the_sensor", -3));
  ExpectUnchanged(Again());
  MustApply(Move("behind_the_sensor", -2.5));
  ExpectUnchanged(Again());
  EXPECT_EQ(world_.Snapshot()->revision().value, before.value + 2);
}

TEST_F(UnchangedViewTest, OtherConditionsOfTheInterpretationAreInterpreted) {
  using Edit = std::function<void(IngestRequest&)>;
  const std::vector<Edit> edits = {
      [](IngestRequest& r) { r.options.noise.model = perception::SensorModel::kRealSense; },
      [](IngestRequest& r) { r.options.up_C = Vector3(0, -1, 0); },
      [](IngestRequest& r) { r.options.clustering = perception::Clustering::kNone; },
      [](IngestRequest& r) { r.options.modeler.search_cones = false; },
      [](IngestRequest& r) { r.mode = IngestMode::kAdd; },
      [](IngestRequest& r) { r.mode = IngestMode::kSegmentOnly; },
      [](IngestRequest& r) { r.force = true; },
      [](IngestRequest& r) { r.sensor = "hand"; },
      [](IngestRequest& r) { r.cloud.seen_from_origin = false; },
      [](IngestRequest& r) { r.options.X_WC->translation().x() += 1e-9; },
  };
  for (std::size_t i = 0; i < edits.size(); ++i) {
    SCOPED_TRACE(i);
    MustIngest(Request());
    ExpectUnchanged(Again());
    IngestRequest edited = Again();
    edits[i](edited);
    ExpectInterpreted(edited);
  }
}

TEST_F(UnchangedViewTest, ThreadsAreNoCondition) {
  MustIngest(Request());
  IngestRequest request = Again();
  request.options.max_threads = 7;
  request.options.threads_now = [] { return 3; };
  ExpectUnchanged(request);
}

TEST_F(UnchangedViewTest, AnEstimatedPoseIsThatOfTheNextScan) {
  IngestRequest first = Request();
  first.options.X_WC.reset();
  MustIngest(first);
  IngestRequest second = Again();
  second.options.X_WC.reset();
  ExpectUnchanged(second);
  ExpectInterpreted(Again());  // the same pose, but given
}

TEST_F(UnchangedViewTest, AnyOtherCloudMustBeEqualToTheBit) {
  IngestRequest first = Request();
  first.cloud.width = static_cast<int>(first.cloud.points.size());
  first.cloud.height = 1;
  MustIngest(first);
  ExpectUnchanged(first);
  IngestRequest second = first;
  std::ranges::find_if(second.cloud.points, perception::IsReturn)->z() += 1e-6F;
  ExpectInterpreted(second);
}

TEST_F(UnchangedViewTest, RevisionsAndRetriesAreCheckedAsEver) {
  MustIngest(Request());
  IngestRequest expecting = Again();
  expecting.write.expected_revision = Revision{7};
  EXPECT_EQ(DetailsOf(Ingest(world_, expecting, TruthOf(scan_), {}).status()).reason,
            "REVISION_MISMATCH");
  IngestRequest named = Again();
  named.write.request_id = "a";
  named.write.request_digest = "digest";
  EXPECT_FALSE(MustIngest(named).replayed);
  const IngestOutcome again = MustIngest(named);
  EXPECT_TRUE(again.replayed);
  EXPECT_TRUE(again.unchanged_view);
  EXPECT_EQ(again.labels, scan_.truth.labels);
}

TEST_F(UnchangedViewTest, ViewsAreForgottenTheLeastRecentlyUsedFirst) {
  KeptViews views{MemoryCharge()};
  const auto keep = [&](std::size_t i) {
    views.Keep(std::make_shared<KeptView>(KeptView{.sensor = absl::StrCat("sensor ", i)}));
  };
  for (std::size_t i = 0; i < KeptViews::kMaxViews; ++i) keep(i);
  EXPECT_NE(views.Find("sensor 0"), nullptr);
  keep(KeptViews::kMaxViews);
  EXPECT_NE(views.Find("sensor 0"), nullptr);
  EXPECT_EQ(views.Find("sensor 1"), nullptr);
  EXPECT_NE(views.Find("sensor 2"), nullptr);
  views.Clear();
  EXPECT_EQ(views.Find("sensor 0"), nullptr);
}

TEST_F(UnchangedViewTest, ViewsAreChargedToTheirWorldAndNotKeptWithoutMemory) {
  const auto budget = MemoryBudget::Make(1 << 20);
  const MemoryBudget::Payer payer = MemoryBudget::World(1, "w");
  KeptViews views{MemoryCharge::Empty(budget, payer)};
  views.Keep(std::make_shared<KeptView>(KeptView{.sensor = "small"}));
  const std::int64_t small = budget->world_bytes_of(payer);
  EXPECT_GT(small, 0);
  views.Keep(std::make_shared<KeptView>(
      KeptView{.sensor = "large", .labels = std::vector<std::uint32_t>(1 << 20)}));
  EXPECT_EQ(views.Find("large"), nullptr);
  EXPECT_NE(views.Find("small"), nullptr);
  EXPECT_EQ(budget->world_bytes_of(payer), small);
  views.Clear();
  EXPECT_EQ(budget->world_bytes_of(payer), 0);
}

}  // namespace
}  // namespace cwm::server
