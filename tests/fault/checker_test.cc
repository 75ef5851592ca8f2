// Each test takes the history of a server that keeps its promises, breaks one of them, and expects
// the name of the rule that finds it. The file is longer than 500 lines: it has a test for each
// rule.
#include "tests/fault/checker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <utility>

namespace cwm::fault {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::IsEmpty;

using Kind = Operation::Kind;
using Outcome = Operation::Outcome;

constexpr char kUid[] = "uid-1";
constexpr int kWriter = 1;
constexpr int kReader = 2;
constexpr int kLossless = 3;
constexpr int kCoalesced = 4;

Change PutChange(const std::string& name, std::int64_t x) {
  return {.kind = Change::Kind::kPut, .name = name, .place = {x, 0, 0}, .geometry = "box"};
}

Change MoveChange(const std::string& name, std::int64_t x) {
  return {.kind = Change::Kind::kMove, .name = name, .place = {x, 0, 0}};
}

Change RemoveChange(const std::string& name) {
  return {.kind = Change::Kind::kRemove, .name = name};
}

Change LoadRobotChange() { return {.kind = Change::Kind::kLoadRobot, .name = "cart"}; }

Change JointChange(std::int64_t value) {
  return {.kind = Change::Kind::kRobotState, .name = "cart", .value = value};
}

// What a lossless watch says of the step from one world to the next.
std::vector<Effect> EffectsBetween(const ModelWorld& before, const ModelWorld& after) {
  std::vector<Effect> effects;
  for (const auto& [name, object] : before.objects) {
    if (!after.objects.contains(name)) {
      effects.push_back({.kind = Effect::Kind::kRemoveObject, .name = name});
    }
  }
  for (const auto& [name, object] : after.objects) {
    const auto old = before.objects.find(name);
    if (old == before.objects.end()) {
      effects.push_back({.kind = Effect::Kind::kObject, .name = name, .object = object});
    } else if (old->second != object) {
      effects.push_back(
          {.kind = Effect::Kind::kMove, .name = name, .object = {.place = object.place}});
    }
  }
  for (const auto& [name, robot] : after.robots) {
    if (!before.robots.contains(name) || before.robots.at(name) != robot) {
      effects.push_back({.kind = Effect::Kind::kRobot, .name = name, .robot = robot});
    }
  }
  return effects;
}

// A server that keeps its promises, one call after the other; each takes 10 ns.
class HonestServer {
 public:
  HonestServer() { OpenWatches(std::nullopt); }

  // Returns the index of the operation.
  std::size_t Write(const std::vector<Change>& changes, Operation operation = {}) {
    Begin(operation, Kind::kWrite);
    if (operation.request_id.empty()) operation.request_id = "w" + std::to_string(++last_id_);
    operation.changes = changes;
    Commit(changes);
    operation.revision = revision_;
    return End(operation);
  }

  // A write whose answer is lost, and the retry that gets it.
  std::pair<std::size_t, std::size_t> WriteTwice(const std::vector<Change>& changes) {
    Operation operation;
    operation.request_id = "w" + std::to_string(++last_id_);
    Begin(operation, Kind::kWrite);
    operation.changes = changes;
    Commit(changes);
    operation.outcome = Outcome::kUnknown;
    const std::size_t first = End(operation);
    Restart();
    Begin(operation, Kind::kWrite);
    operation.outcome = Outcome::kOk;
    operation.revision = revision_;
    return {first, End(operation)};
  }

  std::size_t Read(Operation operation = {}) {
    operation.client = kReader;
    Begin(operation, Kind::kRead);
    operation.revision = revision_;
    const ModelHash hash = HashOf(world_);
    operation.objects_hash = hash.objects;
    operation.robots_hash = hash.robots;
    operation.rules_hash = hash.rules;
    operation.digests["objects"] = std::to_string(hash.objects);
    return End(operation);
  }

  void Restart() {
    Read({.after_restart = true});
    OpenWatches(revision_);
  }

  // The power goes off; revisions after `kept` are taken.
  void Cut(std::int64_t kept, const ModelWorld& kept_world) {
    Operation operation;
    Begin(operation, Kind::kCut);
    End(operation);
    revision_ = kept + 65'536;  // skips what a client may have seen
    world_ = kept_world;
    Read({.after_restart = true});
    OpenWatches(std::nullopt);
  }

  void Bookmark() {
    history_.watches[lossless_].messages.push_back({.time_ns = ++now_, .revision = revision_});
    history_.watches[coalesced_].messages.push_back({.time_ns = ++now_, .revision = revision_});
  }

  std::int64_t revision() const { return revision_; }
  const ModelWorld& world() const { return world_; }
  History& history() { return history_; }
  Watch& lossless() { return history_.watches[lossless_]; }
  Watch& coalesced() { return history_.watches[coalesced_]; }

 private:
  void Begin(Operation& operation, Kind kind) {
    if (operation.client == 0) operation.client = kWriter;
    operation.kind = kind;
    operation.world = "kitchen";
    operation.world_uid = kind == Kind::kCut ? "" : kUid;
    operation.invoke_ns = now_ += 10;
  }

  std::size_t End(Operation& operation) {
    operation.return_ns = now_ += 10;
    history_.operations.push_back(operation);
    return history_.operations.size() - 1;
  }

  void Commit(const std::vector<Change>& changes) {
    const auto after = Apply(world_, changes);
    ASSERT_TRUE(after.has_value());
    if (*after == world_) return;
    ++revision_;
    const WatchMessage message{.time_ns = now_ + 5,
                               .revision = revision_,
                               .kind = WatchMessage::Kind::kEvents,
                               .effects = EffectsBetween(world_, *after)};
    history_.watches[lossless_].messages.push_back(message);
    history_.watches[coalesced_].messages.push_back(message);
    world_ = *after;
  }

  void OpenWatches(std::optional<std::int64_t> from) {
    for (const bool is_lossless : {true, false}) {
      Watch watch{.client = is_lossless ? kLossless : kCoalesced,
                  .world = "kitchen",
                  .world_uid = kUid,
                  .from_revision = from,
                  .is_lossless = is_lossless,
                  .invoke_ns = ++now_};
      if (!from) {
        watch.messages.push_back({.time_ns = ++now_,
                                  .revision = revision_,
                                  .kind = WatchMessage::Kind::kInitialState,
                                  .effects = EffectsBetween({}, world_)});
      }
      (is_lossless ? lossless_ : coalesced_) = history_.watches.size();
      history_.watches.push_back(std::move(watch));
    }
  }

  History history_;
  ModelWorld world_;
  std::int64_t revision_ = 0;
  std::int64_t now_ = 0;
  std::size_t lossless_ = 0;
  std::size_t coalesced_ = 0;
  int last_id_ = 0;
};

// Three objects, a move, a lost answer, a restart, a removal.
class CheckerTest : public ::testing::Test {
 protected:
  CheckerTest() {
    server_.Write({PutChange("cup", 1), PutChange("pan", 2)});
    server_.Write({PutChange("jug", 3)});
    move_ = server_.Write({MoveChange("cup", 4)});
    server_.Read();
    std::tie(unanswered_, retry_) = server_.WriteTwice({MoveChange("cup", 5)});
    read_ = server_.Read();
    expecting_ = server_.Write({RemoveChange("pan")}, {.expected_revision = server_.revision()});
    server_.Write({MoveChange("jug", 6)});
    server_.Read();
    server_.Bookmark();
  }

  Operation& At(std::size_t index) { return server_.history().operations[index]; }
  void ExpectFound(const std::string& rule) {
    const Report report = Check(server_.history());
    EXPECT_THAT(report.violations, Contains(Field(&Violation::rule, rule)));
  }

  HonestServer server_;
  std::size_t move_ = 0;
  std::size_t unanswered_ = 0;
  std::size_t retry_ = 0;
  std::size_t read_ = 0;
  std::size_t expecting_ = 0;
};

TEST_F(CheckerTest, FindsNothingInAHistoryThatKeepsAllPromises) {
  const Report report = Check(server_.history());
  for (const Violation& violation : report.violations) {
    ADD_FAILURE() << violation.rule << ": " << violation.text;
  }
  EXPECT_EQ(report.acknowledged, 6);
  EXPECT_EQ(report.unknown, 1);
  EXPECT_EQ(report.unknown_applied, 1);
  EXPECT_EQ(report.lost, 0);
  EXPECT_EQ(report.revisions, 6);
  EXPECT_EQ(report.unchecked_revisions, 0);
  EXPECT_EQ(report.reads, 4);
  EXPECT_EQ(report.watch_events, 14);
}

TEST_F(CheckerTest, FindsTheSameInAHistoryThatWasWrittenAndRead) {
  At(move_).revision = 2;
  std::stringstream file;
  Write(server_.history(), file);
  const Report direct = Check(server_.history());
  const Report read = Check(ReadHistory(file));
  ASSERT_EQ(read.violations.size(), direct.violations.size());
  for (std::size_t i = 0; i < direct.violations.size(); ++i) {
    EXPECT_EQ(read.violations[i].text, direct.violations[i].text);
  }
  EXPECT_FALSE(direct.violations.empty());
}

TEST_F(CheckerTest, FindsAnAcknowledgedWriteThatARestartLost) {
  server_.history().watches.clear();
  Operation restart = At(read_);
  restart.after_restart = true;
  restart.invoke_ns = At(read_).invoke_ns + 1'000;
  restart.return_ns = restart.invoke_ns + 1;
  server_.history().operations.push_back(restart);  // without the two newest writes
  ExpectFound("latest");
  EXPECT_EQ(Check(server_.history()).lost, 2);
}

TEST_F(CheckerTest, FindsAnAcknowledgedWriteAtARevisionThatHoldsAnother) {
  At(move_).changes = {MoveChange("jug", 4)};
  ExpectFound("acknowledged");
}

TEST_F(CheckerTest, FindsARetryThatWasAppliedAgain) {
  At(unanswered_).outcome = Outcome::kOk;
  At(unanswered_).revision = At(retry_).revision;
  At(retry_).revision += 1;
  ExpectFound("exactly-once");
}

TEST_F(CheckerTest, FindsARefusedWriteThatIsThere) {
  Operation& refused = At(move_);
  refused.outcome = Outcome::kError;
  refused.reason = "DISK_FULL";
  ExpectFound("exactly-once");
}

TEST_F(CheckerTest, FindsRevisionsAgainstRealTime) {
  Operation late = At(move_);
  late.request_id = "late";
  late.changes = {MoveChange("cup", 4)};  // no effect at the revision of the move
  late.invoke_ns = At(expecting_).return_ns + 1'000;
  late.return_ns = late.invoke_ns + 1;
  server_.history().operations.push_back(late);
  ExpectFound("real-time");
}

TEST_F(CheckerTest, FindsAnUnequalExpectedRevisionThatSucceeded) {
  At(expecting_).expected_revision = *At(expecting_).expected_revision - 1;
  ExpectFound("expected-revision");
}

TEST_F(CheckerTest, FindsAnEqualExpectedRevisionThatWasRefused) {
  Operation refused = At(expecting_);
  refused.request_id = "refused";
  refused.outcome = Outcome::kError;
  refused.reason = "REVISION_MISMATCH";
  refused.actual_revision = refused.expected_revision;
  server_.history().operations.push_back(refused);
  ExpectFound("expected-revision");
}

TEST_F(CheckerTest, FindsALatestReadThatIsBehind) {
  Operation& read = At(read_);
  const Operation& first = At(0);
  ModelWorld world = *Apply({}, first.changes);
  read.revision = first.revision;
  read.objects_hash = HashOf(world).objects;
  read.digests.clear();
  ExpectFound("latest");
}

TEST_F(CheckerTest, FindsAReadThatShowsAnotherWorld) {
  *At(read_).objects_hash += 1;
  ExpectFound("content");
}

TEST_F(CheckerTest, FindsBytesThatChangedInAReplay) {
  Operation again = At(read_);
  again.at = Operation::At::kExact;
  again.asked_revision = again.revision;
  again.digests["objects"] = "other";
  server_.history().operations.push_back(again);
  ExpectFound("replay");
}

TEST_F(CheckerTest, FindsAWatchThatSkipsARevision) {
  auto& messages = server_.lossless().messages;
  messages.erase(messages.begin());
  ExpectFound("watch-reliable");
}

TEST_F(CheckerTest, FindsABookmarkBeforeAllWasSent) {
  auto& messages = server_.lossless().messages;
  messages.erase(messages.end() - 2);
  ExpectFound("watch-reliable");
}

TEST_F(CheckerTest, FindsAWatchThatSendsARevisionTwice) {
  auto& messages = server_.lossless().messages;
  messages.insert(messages.begin(), messages.front());
  ExpectFound("watch-unique");
}

TEST_F(CheckerTest, FindsAWatchOutOfOrder) {
  auto& messages = server_.coalesced().messages;
  messages.push_back({.time_ns = messages.back().time_ns + 1,
                      .revision = server_.revision() - 1,
                      .kind = WatchMessage::Kind::kEvents});
  ExpectFound("watch-ordered");
}

TEST_F(CheckerTest, FindsHalfARevision) {
  Watch& first = server_.history().watches.front();
  first.messages[1].effects.pop_back();
  first.messages[1].more = true;  // and the rest never comes
  ExpectFound("watch-atomic");
}

TEST_F(CheckerTest, FindsAResumedWatchThatBeganTooLate) {
  server_.lossless().from_revision = *server_.lossless().from_revision + 1;
  auto& messages = server_.lossless().messages;
  messages.erase(messages.begin());
  // Now the stream is whole, but its client missed a revision while the server was away.
  server_.lossless().from_revision = *server_.lossless().from_revision - 1;
  ExpectFound("watch-reliable");
}

TEST_F(CheckerTest, FindsAWatchThatCannotResume) {
  server_.lossless().messages.clear();
  server_.lossless().end_reason = "REVISION_COMPACTED";
  ExpectFound("watch-resumable");
}

TEST_F(CheckerTest, FindsACoalescedWatchThatLosesARemoval) {
  for (WatchMessage& message : server_.coalesced().messages) {
    std::erase_if(message.effects,
                  [](const Effect& effect) { return effect.kind == Effect::Kind::kRemoveObject; });
  }
  ExpectFound("watch-content");
}

TEST_F(CheckerTest, FindsAnInitialStateOfAnotherWorld) {
  Watch watch = server_.lossless();
  watch.client = 9;
  watch.from_revision.reset();
  watch.messages = {{.time_ns = watch.invoke_ns + 1,
                     .revision = server_.revision(),
                     .kind = WatchMessage::Kind::kInitialState,
                     .effects = {{.name = "cup", .object = {.geometry = "box"}}}}};
  server_.history().watches.push_back(watch);
  ExpectFound("watch-content");
}

TEST_F(CheckerTest, FindsAWorldThatIsGoneWithoutADeletion) {
  Operation read = At(read_);
  read.outcome = Outcome::kError;
  read.reason = "WORLD_UNKNOWN";
  server_.history().operations.push_back(read);
  ExpectFound("acknowledged");
}

TEST_F(CheckerTest, FindsADeletedWorldThatCameBack) {
  Operation deletion{.client = kWriter,
                     .kind = Kind::kDelete,
                     .world = "kitchen",
                     .world_uid = kUid,
                     .invoke_ns = 100'000,
                     .return_ns = 100'001,
                     .revision = server_.revision()};
  server_.history().operations.push_back(deletion);
  EXPECT_THAT(Check(server_.history()).violations, IsEmpty());
  server_.Read();
  server_.history().operations.back().invoke_ns = 100'002;
  server_.history().operations.back().return_ns = 100'003;
  ExpectFound("deleted");
}

TEST_F(CheckerTest, FindsADeletionWhoseRetryDoesNotGetTheFirstReply) {
  Operation deletion{.client = kWriter,
                     .kind = Kind::kDelete,
                     .world = "kitchen",
                     .world_uid = kUid,
                     .request_id = "d1",
                     .invoke_ns = 100'000,
                     .return_ns = 100'001,
                     .outcome = Outcome::kUnknown};
  server_.history().operations.push_back(deletion);
  EXPECT_THAT(Check(server_.history()).violations, IsEmpty());
  deletion.outcome = Outcome::kError;
  deletion.reason = "WORLD_UNKNOWN";
  server_.history().operations.push_back(deletion);
  ExpectFound("exactly-once");
}

TEST_F(CheckerTest, FindsARevisionThatNobodyMade) {
  server_.Write({PutChange("lid", 7)});
  server_.history().operations.pop_back();
  ExpectFound("exactly-once");
}

// A robot's state, which a power cut may take, after a put, which it may not.
class CutTest : public ::testing::Test {
 protected:
  CutTest() {
    server_.Write({LoadRobotChange(), PutChange("cup", 1)});
    put_ = server_.revision();
    world_ = server_.world();
    state_ = server_.Write({JointChange(5)});
  }
  void GoOn() {
    server_.Write({MoveChange("cup", 2)});
    server_.Read();
    server_.Bookmark();
  }

  HonestServer server_;
  std::int64_t put_ = 0;
  ModelWorld world_;
  std::size_t state_ = 0;
};

TEST_F(CutTest, AllowsThatThePowerCutTakesStatesOfRobots) {
  server_.Cut(put_, world_);
  GoOn();
  const Report report = Check(server_.history());
  for (const Violation& violation : report.violations) {
    ADD_FAILURE() << violation.rule << ": " << violation.text;
  }
  EXPECT_EQ(report.lost_observed, 1);
  EXPECT_EQ(report.lost, 0);
}

TEST_F(CutTest, FindsADurableWriteThatThePowerCutTook) {
  server_.history().operations[state_].changes.push_back(MoveChange("cup", 1));  // no effect
  server_.Cut(put_, world_);
  GoOn();
  const Report report = Check(server_.history());
  EXPECT_THAT(report.violations, Contains(Field(&Violation::rule, "power-cut")));
  EXPECT_EQ(report.lost, 1);
}

TEST_F(CutTest, AllowsThatAWatchResumesAtTheRevisionThatTheCutLeft) {
  server_.Cut(put_, world_);
  server_.lossless().from_revision = put_;
  server_.lossless().client = 9;
  server_.lossless().messages = {
      {.time_ns = server_.lossless().invoke_ns + 1, .revision = server_.revision()}};
  GoOn();
  EXPECT_THAT(Check(server_.history()).violations, IsEmpty());
}

TEST_F(CutTest, FindsANumberThatIsUsedAgainAfterThePowerCut) {
  server_.Cut(put_, world_);
  GoOn();
  Operation again = server_.history().operations.back();
  again.revision = put_ + 1;
  again.at = Operation::At::kExact;
  again.asked_revision = put_ + 1;
  server_.history().operations.push_back(again);
  const Report report = Check(server_.history());
  EXPECT_THAT(report.violations, Contains(Field(&Violation::rule, "power-cut")));
}

TEST_F(CutTest, FindsAJumpOfNumbersWithoutAPowerCut) {
  server_.Cut(put_, world_);
  GoOn();
  std::erase_if(server_.history().operations,
                [](const Operation& operation) { return operation.kind == Kind::kCut; });
  const Report report = Check(server_.history());
  EXPECT_THAT(report.violations, Contains(Field(&Violation::rule, "numbers")));
}

TEST(ModelTest, AttachedObjectsMoveWithTheirLinkUntilTheyAreDetached) {
  const auto world = Apply({}, {LoadRobotChange(),
                                PutChange("cup", 10),
                                {.kind = Change::Kind::kAttach, .name = "cup", .other = "cart"},
                                JointChange(3)});
  ASSERT_TRUE(world.has_value());
  EXPECT_EQ(world->objects.at("cup").place[0], 13);
  const auto later =
      Apply(*world, {{.kind = Change::Kind::kDeleteRobot, .name = "cart"}, MoveChange("cup", 1)});
  ASSERT_TRUE(later.has_value());
  EXPECT_EQ(later->objects.at("cup").attached_to, "");
  EXPECT_FALSE(Apply(*world, {RemoveChange("pan")}).has_value());
}

TEST(ModelTest, ARuleThatSaysNothingIsNone) {
  const Change allow{.kind = Change::Kind::kAllow, .name = "b", .other = "a", .value = 1};
  const Change margin{.kind = Change::Kind::kMargin, .name = "a", .other = "b", .value = 4};
  const auto both = Apply({}, {allow, margin});
  ASSERT_TRUE(both.has_value());
  EXPECT_EQ(both->rules.size(), 1U);
  Change withdraw = allow;
  withdraw.value = 0;
  Change remove = margin;
  remove.value = -1;
  const auto none = Apply(*both, {withdraw, remove});
  ASSERT_TRUE(none.has_value());
  EXPECT_EQ(*none, ModelWorld());
}

}  // namespace
}  // namespace cwm::fault
