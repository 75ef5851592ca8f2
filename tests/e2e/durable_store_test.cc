// Worlds that outlive their server: restarts, backups, and stores that cannot be opened.
#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string TextOf(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class DurableStore : public ::testing::Test {
 protected:
  std::vector<std::string> Command(const std::string& store) const {
    return {Program("cwm-server"), "--listen", address_, "--viewer", "off", "--store", store};
  }
  // Starts a server on the store of that directory and waits until it serves.
  void Start(const std::string& directory) {
    server_ = std::make_unique<BackgroundProcess>(Command("sqlite:" + directory), log_);
    for (int i = 0; i < 400; ++i) {
      if (Cwm({"status"}).exit_code == 0) return;
      ASSERT_TRUE(server_->Running()) << TextOf(log_);
      std::this_thread::sleep_for(std::chrono::milliseconds(25));
    }
    FAIL() << "the server does not serve: " << TextOf(log_);
  }
  void Stop() { EXPECT_EQ(server_->Stop(), 0) << TextOf(log_); }
  void Kill() {
    server_->Signal(SIGKILL);
    EXPECT_EQ(server_->Stop(), -1);
  }

  ProcessResult Cwm(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {Program("cwm"), "--addr", address_});
    return RunProgram(arguments);
  }
  std::string Output(const std::vector<std::string>& arguments) const {
    const ProcessResult run = Cwm(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out;
  }
  // What clients see of two worlds, with uids and revisions.
  std::string Seen() const {
    const nlohmann::json status = nlohmann::json::parse(Output({"status", "-o", "json"}));
    return status.at("worlds").dump() + Output({"objects", "-o", "json"}) +
           Output({"objects", "-w", "shelf", "-o", "json"}) + Output({"rules", "-o", "json"});
  }
  // What the worlds hold, without the revision at which they are.
  std::string Contents() const {
    std::string text;
    for (const char* world : {"default", "shelf"}) {
      for (const char* command : {"objects", "rules"}) {
        auto message = nlohmann::json::parse(Output({command, "-w", world, "-o", "json"}));
        message.erase("revision");
        message.erase("world");
        text += message.dump();
      }
    }
    return text;
  }
  void MakeWorlds() const {
    Output({"put", "crate", "--box", "0.3,0.2,0.2", "--at", "0,0,1"});
    Output({"put", "ball", "--sphere", "0.1", "--at", "1,0,1"});
    Output({"move", "crate", "--at", "0,0,2"});
    Output({"allow", "crate", "ball"});
    Output({"put", "post", "--cylinder", "0.1,1", "--at", "0,0,1", "-w", "shelf"});
    Output({"remove", "ball"});
  }

  ScratchDirectory scratch_;
  const std::string address_ = "unix:" + scratch_ / "cwm.sock";
  const std::string log_ = scratch_ / "server.log";
  const std::string store_ = scratch_ / "store";
  std::unique_ptr<BackgroundProcess> server_;
};

TEST_F(DurableStore, WorldsAreTheSameAfterAStop) {
  Start(store_);
  MakeWorlds();
  const std::string before = Seen();
  Stop();
  Start(store_);
  EXPECT_EQ(Seen(), before);
  Stop();
}

TEST_F(DurableStore, WorldsAreTheSameAfterAKill) {
  Start(store_);
  MakeWorlds();
  const std::string before = Seen();
  Kill();
  Start(store_);
  EXPECT_EQ(Seen(), before);
  EXPECT_THAT(Output({"put", "late", "--sphere", "0.1", "--at", "0,0,9"}), HasSubstr("revision 6"));
  Kill();
  Start(store_);
  EXPECT_THAT(Output({"get", "late"}), HasSubstr("late"));
  Stop();
}

TEST_F(DurableStore, StatusShowsTheStore) {
  Start(store_);
  EXPECT_THAT(Output({"status"}), HasSubstr("store   sqlite:" + store_));
  const nlohmann::json status = nlohmann::json::parse(Output({"status", "-o", "json"}));
  EXPECT_EQ(status.at("server_info").at("store"), "sqlite:" + store_);
  EXPECT_EQ(status.at("server_info").at("store_info").at("replayed"), 1);
  EXPECT_EQ(status.at("server_info").at("store_info").at("epoch"), "1");
  Stop();
}

TEST_F(DurableStore, ABackupTakenWhileItServesIsRestoredElsewhere) {
  Start(store_);
  MakeWorlds();
  const std::string before = Contents();
  EXPECT_THAT(Output({"backup", scratch_ / "copy"}), StartsWith("backed up "));
  Output({"remove", "crate"});
  const ProcessResult again = Cwm({"backup", scratch_ / "copy"});
  EXPECT_EQ(again.exit_code, 8);
  EXPECT_THAT(again.err, HasSubstr("exists, must be new"));
  for (const char* name : {"second", "third", "fourth"}) Output({"backup", scratch_ / name});
  Stop();
  EXPECT_THAT(Output({"store", "check", scratch_ / "copy"}), HasSubstr("worlds"));
  EXPECT_THAT(Output({"restore", scratch_ / "copy", scratch_ / "restored"}),
              HasSubstr("restored 2 worlds"));
  Start(scratch_ / "restored");
  EXPECT_EQ(Contents(), before);
  EXPECT_THAT(before, HasSubstr("crate"));
  // Numbers of revisions that were made after the copy are not given again.
  EXPECT_THAT(Output({"put", "late", "--sphere", "0.1", "--at", "0,0,9"}),
              HasSubstr("revision 4294967302"));
  Stop();
  EXPECT_EQ(Cwm({"restore", scratch_ / "copy", store_}).exit_code, 4) << "a store is there already";
}

TEST_F(DurableStore, ASecondServerOnTheSameStoreIsRefused) {
  Start(store_);
  std::vector<std::string> command = Command("sqlite:" + store_);
  command[2] = "unix:" + scratch_ / "other.sock";
  const ProcessResult second = RunProgram(command);
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_THAT(second.err,
              HasSubstr("process " + std::to_string(server_->pid()) + " has the store"));
  const ProcessResult check = Cwm({"store", "check", store_});
  EXPECT_EQ(check.exit_code, 4);
  EXPECT_THAT(check.err, HasSubstr("STORE_LOCKED"));
  Stop();
}

TEST_F(DurableStore, ADamagedStoreIsNamedAndNotServed) {
  Start(store_);
  Output({"put", "a_name_to_look_for", "--sphere", "0.1", "--at", "0,0,1"});
  Stop();
  const std::string database = store_ + "/store.db";
  const std::size_t at = TextOf(database).find("a_name_to_look_for");
  ASSERT_NE(at, std::string::npos);
  std::fstream(database, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(static_cast<std::streamoff>(at))
      .put('A');
  const ProcessResult check = Cwm({"store", "check", store_});
  EXPECT_EQ(check.exit_code, 70);
  EXPECT_THAT(check.out, HasSubstr("fault: "));
  EXPECT_THAT(check.err, HasSubstr("STORE_DAMAGED"));
  const ProcessResult server = RunProgram(Command("sqlite:" + store_));
  EXPECT_EQ(server.exit_code, 2) << server.err;
  EXPECT_THAT(server.err, HasSubstr("record 1"));
}

TEST_F(DurableStore, AForeignDirectoryIsLeftAlone) {
  fs::create_directory(store_);
  std::ofstream(store_ + "/thesis.txt") << "years of work";
  const ProcessResult server = RunProgram(Command("sqlite:" + store_));
  EXPECT_EQ(server.exit_code, 2);
  EXPECT_THAT(server.err, HasSubstr("thesis.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(store_), fs::directory_iterator()), 1);
}

TEST_F(DurableStore, OptionsOfStoresAreChecked) {
  const ProcessResult unknown = RunProgram(Command("postgresql://localhost"));
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, HasSubstr("must be memory or sqlite:PATH"));
  std::vector<std::string> command = Command("memory");
  command.push_back("--store-accept-loss");
  const ProcessResult accepting = RunProgram(command);
  EXPECT_EQ(accepting.exit_code, 1);
  EXPECT_THAT(accepting.err, HasSubstr("--store-accept-loss: must come with"));
}

TEST_F(DurableStore, TheEnvironmentNamesTheStore) {
  server_ = std::make_unique<BackgroundProcess>(
      std::vector<std::string>{"env", "CWM_STORE=sqlite:" + store_, Program("cwm-server"),
                               "--listen", address_, "--viewer", "off"},
      log_);
  for (int i = 0; i < 400 && Cwm({"status"}).exit_code != 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(25));
  }
  EXPECT_THAT(Output({"status"}), HasSubstr("sqlite:" + store_));
  Stop();
}

class MemoryStoreServer : public ServerTest {};

TEST_F(MemoryStoreServer, SaysFirstThatWorldsEndWithIt) {
  EXPECT_THAT(ServerLog(), ::testing::ContainsRegex("^cwm-server [0-9.]+ keeps worlds in memory"));
  EXPECT_THAT(Cwm({"status"}).out, HasSubstr("memory: worlds end with the server"));
  const ProcessResult backup = Cwm({"backup", scratch() / "copy"});
  EXPECT_EQ(backup.exit_code, 4);
  EXPECT_THAT(backup.err, HasSubstr("STORE_IN_MEMORY"));
  EXPECT_FALSE(fs::exists(scratch() / "copy"));
}

}  // namespace
}  // namespace cwm::testing
