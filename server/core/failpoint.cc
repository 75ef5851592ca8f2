#include "server/core/failpoint.h"

#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>

namespace cwm::server {
namespace internal {

std::atomic<bool> fail_point_is_set = false;

}  // namespace internal

namespace {

struct FailPointState {
  std::mutex mutex;
  std::string name;
  int passes_left = 0;
};

FailPointState& State() {
  static FailPointState state;
  return state;
}

// Reads the environment before main. A misspelt value ends the program, lest a test prove nothing.
[[maybe_unused]] const bool kIsRead = [] {
  const char* const text = std::getenv("CWM_FAILPOINT");
  if (text != nullptr && !SetFailPoint(text)) {
    std::fprintf(stderr, "CWM_FAILPOINT: is '%s', must be NAME:PASS, such as after-commit:3\n",
                 text);
    std::_Exit(2);
  }
  return true;
}();

}  // namespace

bool SetFailPoint(std::string_view name_and_pass) {
  const std::size_t colon = name_and_pass.find(':');
  if (colon == 0 || colon == std::string_view::npos) return false;
  const std::string_view number = name_and_pass.substr(colon + 1);
  int pass = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), pass);
  if (error != std::errc() || end != number.data() + number.size() || pass < 1) return false;
  FailPointState& state = State();
  const std::scoped_lock lock(state.mutex);
  state.name = name_and_pass.substr(0, colon);
  state.passes_left = pass;
  internal::fail_point_is_set = true;
  return true;
}

namespace internal {

void PassFailPoint(std::string_view name) {
  FailPointState& state = State();
  const std::scoped_lock lock(state.mutex);
  if (name == state.name && --state.passes_left == 0) std::raise(SIGKILL);
}

}  // namespace internal
}  // namespace cwm::server
