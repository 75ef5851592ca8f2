#include "proto/transfer/default_address.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

namespace cwm {
namespace {

TEST(DefaultAddress, IsWhatTheEnvironmentSaysElseASocketOfTheUser) {
  const std::string socket = "/cwm-" + std::to_string(getuid()) + ".sock";
  unsetenv("CWM_ADDR");
  unsetenv("XDG_RUNTIME_DIR");
  EXPECT_EQ(DefaultAddress(), "unix:/tmp" + socket);
  setenv("XDG_RUNTIME_DIR", "", 1);
  EXPECT_EQ(DefaultAddress(), "unix:/tmp" + socket);
  setenv("XDG_RUNTIME_DIR", "/run/user/7", 1);
  EXPECT_EQ(DefaultAddress(), "unix:/run/user/7" + socket);
  setenv("CWM_ADDR", "127.0.0.1:50051", 1);
  EXPECT_EQ(DefaultAddress(), "127.0.0.1:50051");
  setenv("CWM_ADDR", "", 1);
  EXPECT_EQ(DefaultAddress(), "unix:/run/user/7" + socket);
}

}  // namespace
}  // namespace cwm
