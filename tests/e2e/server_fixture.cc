#include "tests/e2e/server_fixture.h"

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

namespace cwm::testing {

std::string Program(const std::string& name) {
  const char* directory = std::getenv("CWM_BIN");
  return std::string(directory != nullptr ? directory : "build/bin") + "/" + name;
}

void ServerTest::SetUp() {
  std::vector<std::string> command = Launcher();
  command.insert(command.end(),
                 {Program("cwm-server"), "--listen", address(), "--viewer", viewer()});
  server_ = std::make_unique<BackgroundProcess>(command, scratch_ / "server.log");
  for (int i = 0; i < 200; ++i) {
    if (Cwm({"status"}).exit_code == 0) return;
    ASSERT_TRUE(server_->Running()) << ServerLog();
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  FAIL() << "the server did not come up: " << ServerLog();
}

void ServerTest::TearDown() {
  if (server_ == nullptr) return;
  EXPECT_TRUE(server_->Running()) << "the server died: " << ServerLog();
  EXPECT_EQ(server_->Stop(), 0) << "the server did not end by itself: " << ServerLog();
}

std::string ServerTest::ServerLog() const {
  std::ifstream file(scratch_ / "server.log");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

int ServerTest::ViewerPort() const {
  const std::string log = ServerLog();
  const std::size_t url = log.find("shows the world at http://");
  const std::size_t slash = log.find('/', log.find("//", url) + 2);
  if (url == std::string::npos || slash == std::string::npos) return 0;
  return std::stoi(log.substr(log.rfind(':', slash) + 1));
}

ProcessResult ServerTest::Cwm(std::vector<std::string> arguments, const std::string& input) const {
  arguments.insert(arguments.begin(), {Program("cwm"), "--addr", address()});
  return RunProgram(arguments, input);
}

nlohmann::json ServerTest::CwmJson(std::vector<std::string> arguments,
                                   const std::string& input) const {
  arguments.insert(arguments.begin(), {"-o", "json"});
  const ProcessResult run = Cwm(arguments, input);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return nlohmann::json::parse(run.out, nullptr, /*allow_exceptions=*/false);
}

std::string ServerTest::Simulate(const std::string& name,
                                 const std::vector<std::string>& arguments) const {
  const std::string cloud = scratch_ / (name + ".pcd");
  std::vector<std::string> all = {Program("cwm-simulator"), "--out", cloud, "--truth",
                                  scratch_ / (name + ".json")};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const ProcessResult run = RunProgram(all);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return cloud;
}

nlohmann::json ServerTest::Truth(const std::string& name) const {
  std::ifstream file(scratch_ / (name + ".json"));
  return nlohmann::json::parse(file);
}

std::int64_t ServerTest::RevisionOf(const std::string& world) const {
  const ProcessResult run =
      Cwm({"-o", "json", "call", "cwm.v1.WorldService/GetWorld", "{\"world\": \"" + world + "\"}"});
  if (run.exit_code != 0) return -1;
  return std::stoll(nlohmann::json::parse(run.out).at("revision").get<std::string>());
}

std::string ServerTest::UidOf(const std::string& world) const {
  const std::string request = "{\"world\": \"" + world + "\"}";
  return CwmJson({"call", "cwm.v1.WorldService/GetWorld", request}).at("world_uid");
}

std::string PoseArgument(const nlohmann::json& pose) {
  std::ostringstream text;
  text.precision(17);
  const char* separator = "";
  for (const char* key : {"tx_m", "ty_m", "tz_m", "qx", "qy", "qz", "qw"}) {
    text << separator << pose.at(key).get<double>();
    separator = ",";
  }
  return text.str();
}

}  // namespace cwm::testing
