// A sensor's stream of frames. While one frame is processed, the next ones are read, and the newest
// of them waits; each is answered once, in order.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>

#include "cwm/v1/perception.grpc.pb.h"
#include "server/core/live/live_world.h"
#include "server/rpc/runtime.h"
#include "server/wire/sensors.h"

namespace cwm::server {

// A message is read by gRPC's thread and taken by a task of the queue `live`, which then reads the
// next one; a frame that no other one is ahead of is processed by the same task. Every event (a
// message, an answer, a drain, another stream of the sensor) is recorded under the lock, and then
// whatever can go on does. The call is finished there, once, when nothing is being taken, processed
// or written, and nothing more can come. Tasks keep the call alive.
class StreamCloudsCall final : public grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>,
                               public Drainable,
                               public std::enable_shared_from_this<StreamCloudsCall> {
 public:
  static StreamCloudsCall* Start(grpc::CallbackServerContext* context, Runtime& runtime);

  // The frame in progress is still answered; the one that waits is not.
  void Drain() override { Advance(); }

 private:
  // A frame that was read, with its share of the account of memory.
  struct Frame {
    std::int64_t number = 0;
    v1::SensorFrame message;
    MemoryCharge charge;
    Clock::time_point received;
  };

  StreamCloudsCall(grpc::CallbackServerContext* context, Runtime& runtime);

  void OnReadDone(bool ok) override;
  void OnWriteDone(bool ok) override;
  void OnCancel() override;
  void OnDone() override;

  // Writes, reads and finishes as far as possible.
  void Advance();
  void AdvanceLocked();
  bool IsOver() const;  // nothing more will come; under the lock
  void FinishIfOver();

  void Enqueue(void (StreamCloudsCall::*work)());
  // Has the frame that waits processed when its turn comes, in lockstep with other sensors.
  void EnqueueTurn();
  // Has the frame that waits processed, as a task or, `here`, at once; by then states of robots that
  // are about to come for it have come, or it has waited for long enough.
  void ProcessNext(bool here);
  bool AwaitsStates();
  void AwaitStates(Clock::time_point until);
  // True if the frame that waits has to tell its sensor's pose: then it is worked on as scans are.
  bool WaitsAsScan();
  void EnqueueScan();
  // Tasks of the queue.
  void TakeMessage();
  void ProcessWaiting() { ProcessOrRefuse(absl::OkStatus()); }
  void ProcessOrRefuse(const absl::Status& admitted);
  struct NumberedAnswer {
    std::int64_t number = 0;
    v1::StreamCloudsResponse response;
  };
  // Answers a frame, if there was one, and goes on with the next; an error ends the stream.
  void FinishFrame(const absl::Status& ended, std::optional<NumberedAnswer> answer);

  absl::Status Take();
  absl::Status TakeCalibration(const v1::SensorCalibration& calibration);
  absl::Status TakeFrame(v1::SensorFrame& message, MemoryCharge charge);
  // Answers a frame for which there is no memory.
  void RefuseUnread(const absl::Status& why);
  absl::StatusOr<FrameOutcome> Process(const Frame& frame);
  FrameOutcome RefusedOutcome(const absl::Status& why) const;
  v1::StreamCloudsResponse ResponseTo(const Frame& frame, const FrameOutcome& outcome) const;
  void Answer(std::int64_t number, v1::StreamCloudsResponse response);
  void Fail(const absl::Status& status);

  Runtime& runtime_;
  std::stop_source stop_;
  OpenCalls::Token open_{runtime_.open_calls, stop_};
  std::shared_ptr<StreamCloudsCall> self_;  // until OnDone
  grpc::CallbackServerContext* const context_;
  const ClientId client_;
  std::optional<QuotaShare> quota_share_;
  StallTimers::Guard reading_;  // while the client reads an answer

  // Set by the calibration, which is taken before any frame.
  std::optional<SensorPlan> plan_;
  std::shared_ptr<World> world_;
  std::unique_ptr<SensorStream> sensor_;

  // May be held while StartRead, StartWrite or Finish runs, because gRPC calls no reaction within
  // them.
  std::mutex mutex_;
  bool is_reading_ = false;       // a message is being read or taken
  bool is_processing_ = false;    // a frame is being processed, or a task is about to
  bool is_writing_ = false;       // an answer is being written
  bool client_is_done_ = false;   // nothing more is read
  bool client_is_gone_ = false;   // nothing more is written
  bool is_over_ = false;          // Finish was called
  absl::Status error_;            // that ends the stream, if any
  std::int64_t frame_count_ = 0;  // that were taken
  std::int64_t next_answer_ = 0;  // number of the frame to be answered next
  std::optional<Frame> waiting_;  // the newest frame
  std::map<std::int64_t, v1::StreamCloudsResponse> answers_;  // that are not written yet
  grpc::ByteBuffer read_;                                     // while is_reading_
  Clock::time_point received_;                                // when read_ was complete
  grpc::ByteBuffer written_;                                  // while is_writing_
};

}  // namespace cwm::server
