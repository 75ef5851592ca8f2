// A wall clock that is set while the server runs: temporary allowances last as long as they were
// given.
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <thread>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

constexpr std::int64_t kHour_s = 3'600;

class SetClock : public ServerTest {
 protected:
  void SetUp() override {
    offset_ = open((scratch() / "offset").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    Set(0);
    setenv("CWM_CLOCK_OFFSET", (scratch() / "offset").c_str(), 1);
    setenv("LD_PRELOAD", CWM_SETTABLE_CLOCK, 1);
    ServerTest::SetUp();
    unsetenv("LD_PRELOAD");
    unsetenv("CWM_CLOCK_OFFSET");
    ASSERT_EQ(Cwm({"put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0"}).exit_code, 0);
  }
  void TearDown() override {
    ServerTest::TearDown();
    close(offset_);
  }
  // Sets the server's wall clock ahead of ours by `ahead_s` seconds.
  void Set(std::int64_t ahead_s) const {
    ASSERT_EQ(pwrite(offset_, &ahead_s, sizeof(ahead_s), 0), static_cast<ssize_t>(sizeof(ahead_s)));
  }
  // The end of the first rule by the server's clock, in seconds since 1970; 0 if there is none.
  std::int64_t Expiry() const {
    const std::string request = "{\"world\": \"default\"}";
    const auto rules = CwmJson({"call", "cwm.v1.WorldService/GetWorld", request})["pair_rules"];
    if (rules.empty()) return 0;
    std::tm time{};
    strptime(rules[0].at("expires").get<std::string>().c_str(), "%Y-%m-%dT%H:%M:%S", &time);
    return timegm(&time);
  }

 private:
  int offset_ = -1;
};

TEST_F(SetClock, BackLengthensNoAllowance) {
  ASSERT_EQ(Cwm({"allow", "crate", "*", "--for", "2"}).exit_code, 0);
  EXPECT_LE(Expiry(), std::time(nullptr) + 3);
  Set(-kHour_s);
  ASSERT_EQ(Cwm({"allow", "crate", "*", "--for", "2"}).exit_code, 0);
  ASSERT_GT(Expiry(), 0);
  EXPECT_LE(Expiry(), std::time(nullptr) - kHour_s + 3) << "the server's clock was not set";
  Set(-2 * kHour_s);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  for (int i = 0; i < 100 && Expiry() != 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  EXPECT_EQ(Expiry(), 0);
}

TEST_F(SetClock, ForwardShortensNoAllowance) {
  ASSERT_EQ(Cwm({"allow", "crate", "*", "--for", "60"}).exit_code, 0);
  Set(kHour_s);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_GT(Expiry(), 0);
}

}  // namespace
}  // namespace cwm::testing
