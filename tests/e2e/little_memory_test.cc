// A server with a limited address space, and clients that need more than it has.
#include <chrono>
#include <thread>

#include "clients/cpp/connection.h"
#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

class LittleMemory : public ServerTest {
 protected:
  std::vector<std::string> Launcher() const override {
    return {"/bin/sh", "-c", "ulimit -v 3000000; exec \"$@\"", "sh"};  // kibibytes
  }
};

// Each call waits for a revision that is never made, and takes 15 MiB.
TEST_F(LittleMemory, ACrowdThatSendsMoreThanThereIsIsRefusedAndOthersAreAnswered) {
  constexpr int kConnections = 4, kCalls = 45;  // 2.7 GB
  struct Wait {
    grpc::ClientContext context;
    v1::GetDistancesResponse response;
    grpc::Status status;
    std::thread thread;
  };
  v1::GetDistancesRequest request;
  request.mutable_options()->mutable_at_revision()->set_at_least(1'000'000'000);
  request.mutable_subject()->mutable_points()->mutable_data()->resize(15 << 20);
  std::vector<std::unique_ptr<client::Connection>> connections;
  std::vector<std::unique_ptr<Wait>> waits;
  ASSERT_EQ(Cwm({"put", "crate", "--box", "1,1,1", "--at", "0,0,0"}).exit_code, 0);
  for (int i = 0; i < kConnections; ++i) {
    connections.push_back(std::make_unique<client::Connection>(
        client::ConnectOptions{.address = address(), .deadline = {}}));
    for (int k = 0; k < kCalls; ++k) {
      waits.push_back(std::make_unique<Wait>());
      waits.back()->thread =
          std::thread([&request, &queries = connections.back()->queries(), &wait = *waits.back()] {
            wait.status = queries.GetDistances(&wait.context, request, &wait.response);
          });
    }
  }
  for (int i = 0; i < 20; ++i) {
    const ProcessResult put = Cwm({"put", "other", "--box", "1,1,1", "--at", "3,0,0"});
    EXPECT_EQ(put.exit_code, 0) << put.err;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  int refused = 0;
  for (const auto& wait : waits) wait->context.TryCancel();
  for (const auto& wait : waits) {
    wait->thread.join();
    if (wait->status.error_code() == grpc::StatusCode::RESOURCE_EXHAUSTED) ++refused;
  }
  EXPECT_GT(refused, 0);
  EXPECT_TRUE(server().Running()) << ServerLog();
  EXPECT_EQ(Cwm({"put", "third", "--box", "1,1,1", "--at", "6,0,0"}).exit_code, 0);
}

}  // namespace
}  // namespace cwm::testing
