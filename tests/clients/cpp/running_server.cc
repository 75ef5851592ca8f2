#include "tests/clients/cpp/running_server.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

namespace cwm::testing {

void RunningServer::Start() {
  const char* folder = std::getenv("CWM_BIN");
  const std::string log = scratch_ / "server.log";
  process_ = std::make_unique<BackgroundProcess>(
      std::vector<std::string>{
          std::string(folder != nullptr ? folder : "build/bin") + "/cwm-server", "--listen",
          address(), "--viewer", "off"},
      log);
  for (int i = 0; i < 800 && process_->Running(); ++i) {
    try {
      const Server connected({.address = address()});
      return;
    } catch (const Error&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
  }
  std::ifstream file(log);
  std::ostringstream text;
  text << file.rdbuf();
  FAIL() << "the server did not come up: " << text.str();
}

void RunningServer::Stop() {
  if (process_ == nullptr) return;
  EXPECT_TRUE(process_->Running()) << "the server died";
  EXPECT_EQ(process_->Stop(), 0) << "the server did not end by itself";
  process_.reset();
}

void RunningServer::Pause() {
  process_->Signal(SIGSTOP);
  const std::string tasks = "/proc/" + std::to_string(process_->pid()) + "/task";
  const auto runs = [](const std::filesystem::directory_entry& task) {
    std::ifstream file(task.path() / "stat");
    std::string text;
    std::getline(file, text);
    return text.find(") T ") == std::string::npos;  // the state follows the name
  };
  const std::filesystem::directory_iterator none;
  while (std::find_if(std::filesystem::directory_iterator(tasks), none, runs) != none) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

Eigen::Isometry3d At(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

}  // namespace cwm::testing
