#include "collision/thread_pool/thread_pool.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

namespace cwm {
namespace {

// measured: waking a thread costs its waker up to 30 us and takes 100 us; most serial sections
// between the loops of a scan are shorter than this.
constexpr auto kSpinTime = std::chrono::microseconds(300);

// The calling thread's position in thread pools and loops.
struct ThreadContext {
  ThreadPool* pool = nullptr;    // the pool that it helps; null for a thread that owns one
  Worker* worker = nullptr;      // its entry in that pool
  ParallelLoop* loop = nullptr;  // the loop whose body it runs
};
thread_local ThreadContext context;

class LoopScope {
 public:
  explicit LoopScope(ParallelLoop& loop) : before_(std::exchange(context.loop, &loop)) {}
  ~LoopScope() { context.loop = before_; }
  LoopScope(const LoopScope&) = delete;
  LoopScope& operator=(const LoopScope&) = delete;

 private:
  ParallelLoop* const before_;
};

}  // namespace

ParallelLoop::ParallelLoop(std::size_t count, std::size_t range_size,
                           const std::function<int()>& threads, const Body& body)
    : enclosing_(context.loop),
      outermost_(enclosing_ ? enclosing_->outermost_ : *this),
      count_(count),
      range_size_(range_size),
      threads_(threads),
      body_(body) {}

void ParallelLoop::Run() {
  const std::size_t ranges = (count_ + range_size_ - 1) / range_size_;
  const int threads = static_cast<int>(std::min(ranges, static_cast<std::size_t>(MaxThreads())));
  if (threads > 1) {
    ThreadPool::Current().Run(*this, threads - 1);
  } else {
    RunRanges(0);
  }
  if (first_failure_) std::rethrow_exception(first_failure_);
}

bool ParallelLoop::IsWithin(const ParallelLoop& other) const {
  for (const ParallelLoop* loop = enclosing_; loop != nullptr; loop = loop->enclosing_) {
    if (loop == &other) return true;
  }
  return false;
}

int ParallelLoop::MaxThreads() const {
  return std::max(1, std::min(threads_(), outermost_.threads_()));
}

void ParallelLoop::RunRanges(int thread) {
  const LoopScope guard(*this);
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

ThreadPool& ThreadPool::Current() {
  if (context.pool != nullptr) return *context.pool;
  thread_local ThreadPool own;
  return own;
}

ThreadPool::~ThreadPool() {
  is_stopping_ = true;
  std::vector<Worker*> woken;
  {
    const std::lock_guard lock(mutex_);
    ++changes_;
    woken.swap(parked_);
  }
  for (Worker* worker : woken) worker->parker.Unpark();
}

void ThreadPool::Run(ParallelLoop& loop, int helpers) {
  Open(loop, helpers);
  loop.RunRanges(0);
  Close(loop);
  Worker& self = context.worker != nullptr ? *context.worker : own_;
  const ParallelLoop* const before = std::exchange(self.waiting_for, &loop);
  RunLoops(self, [&] { return loop.helpers_ == 0; });
  self.waiting_for = before;
}

bool ThreadPool::CanRun(const Worker& worker, const ParallelLoop& loop) {
  if (worker.waiting_for != nullptr) return loop.IsWithin(*worker.waiting_for);
  return worker.number < loop.outermost_.threads_();
}

void ThreadPool::Open(ParallelLoop& loop, int helpers) {
  std::vector<Worker*> woken;
  {
    const std::lock_guard lock(mutex_);
    open_.push_back(&loop);
    ++changes_;
    std::erase_if(parked_, [&](Worker* worker) {
      if (static_cast<int>(woken.size()) == helpers || !CanRun(*worker, loop)) return false;
      woken.push_back(worker);
      return true;
    });
    while (static_cast<int>(helpers_.size()) < helpers) {
      if (!StartHelper()) break;
    }
  }
  for (Worker* worker : woken) worker->parker.Unpark();
}

bool ThreadPool::StartHelper() {
  Helper& helper = helpers_.emplace_back();
  helper.worker.number = static_cast<int>(helpers_.size());
  try {
    helper.thread = std::jthread([this, &worker = helper.worker] {
      context = {.pool = this, .worker = &worker};
      RunLoops(worker, [&] { return is_stopping_.load(); });
    });
  } catch (const std::system_error&) {
    helpers_.pop_back();
    return false;
  }
  return true;
}

void ThreadPool::Close(ParallelLoop& loop) {
  const std::lock_guard lock(mutex_);
  std::erase(open_, &loop);
}

ParallelLoop* ThreadPool::Join(const Worker& worker) {
  const std::lock_guard lock(mutex_);
  for (ParallelLoop* loop : open_) {
    if (loop->next_ >= loop->count_ || !CanRun(worker, *loop)) continue;
    if (loop->helpers_ + 1 >= loop->MaxThreads()) continue;
    ++loop->helpers_;
    return loop;
  }
  return nullptr;
}

void ThreadPool::Leave(ParallelLoop& loop) {
  Worker* waiting = nullptr;
  {
    const std::lock_guard lock(mutex_);
    if (loop.helpers_ > 1) {
      --loop.helpers_;
      return;
    }
    const auto waits = [&](const Worker* worker) { return worker->waiting_for == &loop; };
    const auto found = std::ranges::find_if(parked_, waits);
    if (found != parked_.end()) {
      waiting = *found;
      parked_.erase(found);
    }
    loop.helpers_ = 0;  // from here on the loop may be destroyed
    ++changes_;         // a thread that sees this change sees that the loop is done
  }
  if (waiting != nullptr) waiting->parker.Unpark();
}

template <class Done>
void ThreadPool::RunLoops(Worker& worker, const Done& is_done) {
  for (;;) {
    const unsigned seen = changes_;
    if (is_done()) return;
    if (ParallelLoop* loop = Join(worker)) {
      loop->RunRanges(worker.number);
      Leave(*loop);
      continue;
    }
    const auto since = std::chrono::steady_clock::now();
    while (changes_ == seen && std::chrono::steady_clock::now() - since < kSpinTime) {
      std::this_thread::yield();
    }
    ParkUnlessChanged(worker, seen);
  }
}

void ThreadPool::ParkUnlessChanged(Worker& worker, unsigned seen) {
  if (changes_ != seen) return;
  worker.parker.PreparePark();
  {
    const std::lock_guard lock(mutex_);
    if (changes_ != seen) return;
    parked_.push_back(&worker);
  }
  worker.parker.Park();
}

}  // namespace cwm
