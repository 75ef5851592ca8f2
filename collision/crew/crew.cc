#include "collision/crew/crew.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

namespace cwm {
namespace {

// measured: waking a thread costs its waker up to 30 us and takes 100 us; most serial sections
// between the loops of a scan are shorter than this.
constexpr auto kStayAwake = std::chrono::microseconds(300);

// The calling thread's position in thread pools and loops.
struct Place {
  Crew* crew = nullptr;          // the pool that it helps; null for a thread that owns one
  CrewMember* member = nullptr;  // its entry in that pool
  Loop* around = nullptr;        // the loop whose body it runs
};
thread_local Place place;

class InBodyOf {
 public:
  explicit InBodyOf(Loop& loop) : before_(std::exchange(place.around, &loop)) {}
  ~InBodyOf() { place.around = before_; }
  InBodyOf(const InBodyOf&) = delete;
  InBodyOf& operator=(const InBodyOf&) = delete;

 private:
  Loop* const before_;
};

}  // namespace

Loop::Loop(std::size_t count, std::size_t range_size, const std::function<int()>& threads,
           const Body& body)
    : around_(place.around),
      outermost_(around_ ? around_->outermost_ : *this),
      count_(count),
      range_size_(range_size),
      threads_(threads),
      body_(body) {}

void Loop::Do() {
  const std::size_t ranges = (count_ + range_size_ - 1) / range_size_;
  const int threads = static_cast<int>(std::min(ranges, static_cast<std::size_t>(MostThreads())));
  if (threads > 1) {
    Crew::OfThisThread().Do(*this, threads - 1);
  } else {
    Run(0);
  }
  if (first_failure_) std::rethrow_exception(first_failure_);
}

bool Loop::IsWithin(const Loop& other) const {
  for (const Loop* loop = around_; loop != nullptr; loop = loop->around_) {
    if (loop == &other) return true;
  }
  return false;
}

int Loop::MostThreads() const { return std::max(1, std::min(threads_(), outermost_.threads_())); }

void Loop::Run(int thread) {
  const InBodyOf guard(*this);
  try {
    while (thread == 0 || thread < outermost_.threads_()) {
      const std::size_t begin = next_.fetch_add(range_size_);
      if (begin >= count_) return;
      body_(begin, std::min(begin + range_size_, count_));
    }
  } catch (...) {
    next_ = count_;  // the other threads stop early; the opener of the loop sees the exception
    const std::lock_guard lock(failure_mutex_);
    if (!first_failure_) first_failure_ = std::current_exception();
  }
}

Crew& Crew::OfThisThread() {
  if (place.crew != nullptr) return *place.crew;
  thread_local Crew own;
  return own;
}

Crew::~Crew() {
  is_ending_ = true;
  std::vector<CrewMember*> woken;
  {
    const std::lock_guard lock(mutex_);
    ++changes_;
    woken.swap(sleeping_);
  }
  for (CrewMember* member : woken) member->sleeper.Wake();
}

void Crew::Do(Loop& loop, int helpers) {
  Open(loop, helpers);
  loop.Run(0);
  Close(loop);
  CrewMember& self = place.member != nullptr ? *place.member : own_;
  const Loop* const before = std::exchange(self.waits_for, &loop);
  Serve(self, [&] { return loop.helpers_ == 0; });
  self.waits_for = before;
}

bool Crew::MayRun(const CrewMember& member, const Loop& loop) {
  if (member.waits_for != nullptr) return loop.IsWithin(*member.waits_for);
  return member.number < loop.outermost_.threads_();
}

void Crew::Open(Loop& loop, int helpers) {
  std::vector<CrewMember*> woken;
  {
    const std::lock_guard lock(mutex_);
    open_.push_back(&loop);
    ++changes_;
    std::erase_if(sleeping_, [&](CrewMember* member) {
      if (static_cast<int>(woken.size()) == helpers || !MayRun(*member, loop)) return false;
      woken.push_back(member);
      return true;
    });
    while (static_cast<int>(helpers_.size()) < helpers) {
      if (!StartHelper()) break;
    }
  }
  for (CrewMember* member : woken) member->sleeper.Wake();
}

bool Crew::StartHelper() {
  Helper& helper = helpers_.emplace_back();
  helper.member.number = static_cast<int>(helpers_.size());
  try {
    helper.thread = std::jthread([this, &member = helper.member] {
      place = {.crew = this, .member = &member};
      Serve(member, [&] { return is_ending_.load(); });
    });
  } catch (const std::system_error&) {
    helpers_.pop_back();
    return false;
  }
  return true;
}

void Crew::Close(Loop& loop) {
  const std::lock_guard lock(mutex_);
  std::erase(open_, &loop);
}

Loop* Crew::Join(const CrewMember& member) {
  const std::lock_guard lock(mutex_);
  for (Loop* loop : open_) {
    if (loop->next_ >= loop->count_ || !MayRun(member, *loop)) continue;
    if (loop->helpers_ + 1 >= loop->MostThreads()) continue;
    ++loop->helpers_;
    return loop;
  }
  return nullptr;
}

void Crew::Leave(Loop& loop) {
  CrewMember* waiting = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (loop.helpers_ > 1) {
      --loop.helpers_;
      return;
    }
    const auto waits = [&](const CrewMember* member) { return member->waits_for == &loop; };
    const auto found = std::ranges::find_if(sleeping_, waits);
    if (found != sleeping_.end()) {
      waiting = *found;
      sleeping_.erase(found);
    }
    loop.helpers_ = 0;  // from here on the loop may be destroyed
    ++changes_;         // a thread that sees this change sees that the loop is done
  }
  if (waiting != nullptr) waiting->sleeper.Wake();
}

template <class Done>
void Crew::Serve(CrewMember& member, const Done& is_done) {
  for (;;) {
    const unsigned seen = changes_;
    if (is_done()) return;
    if (Loop* loop = Join(member)) {
      loop->Run(member.number);
      Leave(*loop);
      continue;
    }
    const auto since = std::chrono::steady_clock::now();
    while (changes_ == seen && std::chrono::steady_clock::now() - since < kStayAwake) {
      std::this_thread::yield();
    }
    SleepUnlessChanged(member, seen);
  }
}

void Crew::SleepUnlessChanged(CrewMember& member, unsigned seen) {
  if (changes_ != seen) return;
  member.sleeper.LieDown();
  {
    const std::lock_guard lock(mutex_);
    if (changes_ != seen) return;
    sleeping_.push_back(&member);
  }
  member.sleeper.Sleep();
}

}  // namespace cwm
