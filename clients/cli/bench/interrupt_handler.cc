#include "clients/cli/bench/interrupt_handler.h"

namespace cwm::cli {
namespace {

volatile std::sig_atomic_t interrupted = 0;

extern "C" void RecordInterrupt(int) { interrupted = 1; }

}  // namespace

InterruptHandler::InterruptHandler() {
  interrupted = 0;
  struct sigaction action = {};
  action.sa_handler = RecordInterrupt;
  // The second signal finds the previous handler; interrupted system calls continue.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, &previous_interrupt_);
  sigaction(SIGTERM, &action, &previous_terminate_);
}

InterruptHandler::~InterruptHandler() {
  sigaction(SIGINT, &previous_interrupt_, nullptr);
  sigaction(SIGTERM, &previous_terminate_, nullptr);
}

bool InterruptHandler::signalled() const { return interrupted != 0; }

}  // namespace cwm::cli
