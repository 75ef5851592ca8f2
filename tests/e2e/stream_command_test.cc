// `cwm stream` and `cwm sensors` with sequences of the virtual scanner, and depth images in
// `cwm ingest`.
#include <gmock/gmock.h>

#include <chrono>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

class StreamCommand : public ServerTest {
 protected:
  // The folder of a sensor that looks at the kitchen counter for half a second.
  std::string Sequence() const {
    std::ofstream(scratch() / "script.yaml")
        << "scene: kitchen\nduration_s: 0.5\nsensors:\n  - {name: front, model: kinect}\n";
    const ProcessResult made = RunProgram({Program("cwm-simulator"), "--script",
                                           scratch() / "script.yaml", "--out", scratch() / "out"});
    EXPECT_EQ(made.exit_code, 0) << made.err;
    return scratch() / "out/front";
  }
  static constexpr int kFrames = 15;  // 30 a second

  static std::vector<json> Lines(const std::string& out) {
    std::vector<json> lines;
    std::istringstream text(out);
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    return lines;
  }
};

TEST_F(StreamCommand, AnswersEachFrameOfASequence) {
  const std::string folder = Sequence();
  const ProcessResult run = Cwm({"stream", folder, "-o", "ndjson"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::vector<json> answers = Lines(run.out);
  ASSERT_EQ(answers.size(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 0; i < answers.size(); ++i) {
    EXPECT_EQ(answers[i].at("frame"), std::to_string(i));
    EXPECT_EQ(answers[i].at("fate"), "FRAME_FATE_PROCESSED") << answers[i];
    EXPECT_EQ(answers[i].at("sequence_number"), std::to_string(i + 1));
    EXPECT_FALSE(answers[i].at("stages").empty());
  }
  const json sensors = CwmJson({"sensors"}).at("sensors");
  ASSERT_EQ(sensors.size(), 1u);
  EXPECT_EQ(sensors[0].at("name"), "front");
  EXPECT_EQ(sensors[0].at("processed_count"), std::to_string(kFrames));
  EXPECT_EQ(sensors[0].at("dropped_count"), "0");
  EXPECT_EQ(sensors[0].at("sensor_model").at("kind"), "KIND_KINECT") << "as its camera.json says";
}

TEST_F(StreamCommand, GoesOnWhereAnEarlierStreamEnded) {
  const std::string folder = Sequence();
  for (int run = 1; run <= 2; ++run) {
    const ProcessResult result = Cwm({"stream", folder, "--loop", "2"});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, HasSubstr("30 processed, 0 dropped, 0 refused\nlatency: "));
  }
  const std::string table = Cwm({"sensors"}).out;
  EXPECT_THAT(table, AllOf(HasSubstr("NAME "), HasSubstr("front"), HasSubstr("60")));
}

TEST_F(StreamCommand, FollowsWhatItHasFound) {
  const std::string folder = Sequence();
  json objects = json::array();
  for (int run = 0; run < 20 && objects.empty(); ++run) {  // it is interpreted beside the frames
    ASSERT_EQ(Cwm({"stream", folder, "--realtime", "--loop", "2"}).exit_code, 0);
    objects = CwmJson({"objects", "--kind", "object"}).at("objects");
  }
  ASSERT_FALSE(objects.empty());
  EXPECT_EQ(objects[0].at("motion"), "MOTION_AT_REST");
  EXPECT_THAT(Cwm({"objects"}).out, HasSubstr("at rest"));
}

TEST_F(StreamCommand, InLockstepHasFoundTheThingsWhenItEnds) {
  const ProcessResult run = Cwm({"stream", Sequence(), "--lockstep", "-o", "ndjson"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const json& answer : Lines(run.out)) EXPECT_EQ(answer.at("interpreting"), false);
  EXPECT_FALSE(CwmJson({"objects", "--kind", "object"}).at("objects").empty());
}

TEST_F(StreamCommand, ReadsAListOfFiles) {
  const std::string folder = Sequence();
  const ProcessResult run =
      Cwm({"stream", "-", "--sensor", "listed", "--x-world-sensor", "0,0,1.5,1,0,0,0"},
          folder + "/000000.png\n\n" + folder + "/000001.png\n");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 processed, 0 dropped, 0 refused"));
  const ProcessResult absent = Cwm({"stream", "-", "--x-world-sensor", "0,0,1.5,1,0,0,0"},
                                   folder + "/000000.png\n" + folder + "/absent.png\n");
  EXPECT_EQ(absent.exit_code, 8);
  EXPECT_THAT(absent.err, HasSubstr("-:2: "));
  EXPECT_THAT(absent.out, HasSubstr("1 processed")) << "what was sent before is told";
}

TEST_F(StreamCommand, EndsWithASummaryWhenItIsInterrupted) {
  const std::string folder = Sequence();
  const std::string log = scratch() / "stream.log";
  BackgroundProcess stream(
      {Program("cwm"), "--addr", address(), "stream", folder, "--realtime", "--loop", "1000"}, log);
  const auto text = [&] {
    std::ostringstream all;
    all << std::ifstream(log).rdbuf();
    return all.str();
  };
  const auto processed = [&] {
    const json sensors = CwmJson({"sensors"}).at("sensors");
    return !sensors.empty() && sensors[0].at("processed_count") != "0";
  };
  for (int i = 0; i < 400 && (RevisionOf("default") < 0 || !processed()); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  EXPECT_EQ(stream.Stop(), 0) << text();
  EXPECT_THAT(text(), HasSubstr(" processed, "));
}

TEST_F(StreamCommand, TellsWhatIsWrong) {
  const std::string folder = Sequence();
  const ProcessResult robot = Cwm({"stream", folder, "--mount", "nobody/hand"});
  EXPECT_EQ(robot.exit_code, 3) << robot.err;
  EXPECT_THAT(robot.err, HasSubstr("ROBOT_UNKNOWN"));
  const ProcessResult rate = Cwm({"stream", folder, "--rate", "15"});
  EXPECT_EQ(rate.exit_code, 1);
  EXPECT_THAT(rate.err, HasSubstr("frames.jsonl:1 has one"));
  EXPECT_EQ(Cwm({"sensors", "set", "nobody", "--x-world-sensor", "0,0,1"}).exit_code, 3);
}

TEST_F(StreamCommand, PlacesASensor) {
  const std::string folder = Sequence();
  ASSERT_EQ(Cwm({"stream", folder, "--x-world-sensor", "0,0,1.5,1,0,0,0"}).exit_code, 0);
  const ProcessResult set = Cwm({"sensors", "set", "front", "--x-world-sensor", "0,0,1.6,1,0,0,0"});
  EXPECT_EQ(set.exit_code, 0) << set.err;
  EXPECT_THAT(set.out, HasSubstr("front at 0.000 0.000 1.600 m"));
}

TEST_F(StreamCommand, DepthImagesAreIngestedAsTheyAre) {
  const std::string image = Sequence() + "/000000.png";
  const json scan = CwmJson({"ingest", image});
  EXPECT_GT(scan.at("objects").size(), 4u);
  EXPECT_EQ(scan.at("report").at("points_in"), "307200");
  // With labels it is sent as points; they show the same.
  const json points =
      CwmJson({"ingest", image, "--world", "points", "--labels", scratch() / "l.pcd"});
  EXPECT_EQ(points.at("objects").size(), scan.at("objects").size());
}

}  // namespace
}  // namespace cwm::testing
