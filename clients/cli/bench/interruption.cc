#include "clients/cli/bench/interruption.h"

namespace cwm::cli {
namespace {

volatile std::sig_atomic_t interrupted = 0;

extern "C" void NoteInterruption(int) { interrupted = 1; }

}  // namespace

Interruption::Interruption() {
  interrupted = 0;
  struct sigaction action = {};
  action.sa_handler = NoteInterruption;
  // The second signal finds the previous handler; interrupted system calls continue.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, &interrupt_before_);
  sigaction(SIGTERM, &action, &terminate_before_);
}

Interruption::~Interruption() {
  sigaction(SIGINT, &interrupt_before_, nullptr);
  sigaction(SIGTERM, &terminate_before_, nullptr);
}

bool Interruption::came() const { return interrupted != 0; }

}  // namespace cwm::cli
