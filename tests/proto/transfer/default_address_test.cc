#include "proto/transfer/default_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "tests/support/process.h"

namespace cwm {
namespace {

using ::testing::HasSubstr;

TEST(DefaultAddress, IsWhatTheEnvironmentSaysElseASocketOfTheUser) {
  const std::string uid = std::to_string(getuid());
  unsetenv("CWM_ADDR");
  unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(DefaultAddress(), "unix:/tmp/cwm-" + uid + "/cwm.sock");
  setenv("XDG_RUNTIME_DIR", "", 1);
  EXPECT_EQ(DefaultAddress(), "unix:/tmp/cwm-" + uid + "/cwm.sock");
  setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
  EXPECT_EQ(DefaultAddress(), "unix:/run/user/7/cwm-" + uid + ".sock");
  setenv("CWM_ADDR", "127.0.0.1:50051", 1);
  EXPECT_EQ(DefaultAddress(), "127.0.0.1:50051");
  setenv("CWM_ADDR", "", 1);
  EXPECT_EQ(DefaultAddress(), "unix:/run/user/7/cwm-" + uid + ".sock");
}

TEST(DefaultAddress, IsRefusedInARuntimeDirectoryThatOthersCanWriteTo) {
  const testing::ScratchDirectory scratch;
  unsetenv("CWM_ADDR");
  setenv("XDG_RUNTIME_DIR", scratch.path().c_str(), 1);
  for (const mode_t mode : {0700U, 0755U}) {
    ASSERT_EQ(chmod(scratch.path().c_str(), mode), 0);
    EXPECT_TRUE(PrepareDefaultAddress().ok());
  }
  ASSERT_EQ(chmod(scratch.path().c_str(), 01777), 0);
  const absl::Status status = PrepareDefaultAddress();
  EXPECT_TRUE(absl::IsPermissionDenied(status)) << status;
  for (const std::string& part :
       {"XDG_RUNTIME_DIR: " + scratch.path() + ": has mode 1777", std::string("CWM_ADDR, --listen"),
        std::string("--addr (client)"), std::string("set XDG_RUNTIME_DIR to a directory")}) {
    EXPECT_THAT(std::string(status.message()), HasSubstr(part));
  }
  setenv("XDG_RUNTIME_DIR", (scratch / "missing").c_str(), 1);
  EXPECT_TRUE(absl::IsUnavailable(PrepareDefaultAddress())) << PrepareDefaultAddress();
}

TEST(DefaultAddress, IsTheUsersOwnChoiceInCwmAddr) {
  setenv("XDG_RUNTIME_DIR", "/nonexistent", 1);
  setenv("CWM_ADDR", "unix:/tmp/any.sock", 1);
  EXPECT_TRUE(PrepareDefaultAddress().ok());
  setenv("CWM_ADDR", "", 1);
  EXPECT_FALSE(PrepareDefaultAddress().ok());
}

}  // namespace
}  // namespace cwm
