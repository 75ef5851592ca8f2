// The server's memory for clients that keep streams open without queries.
#include "clients/cpp/connection.h"
#include "clients/cpp/row_bytes.h"
#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using Stream = grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>;

// derived: the memory of a few messages in progress, and of the allocator's share of it. Streams
// that kept their messages took 840 MiB and 200 MiB.
constexpr double kMax_MiB = 150;

class IdleStreams : public ServerTest {
 protected:
  static constexpr int kStreams = 100;

  struct Open {
    grpc::ClientContext context;
    std::unique_ptr<Stream> wire;
  };

  // Each stream sends one query and stays open.
  std::vector<std::unique_ptr<Open>> OpenAll(const client::Connection& connection,
                                             const v1::StreamQueriesRequest& query) {
    std::vector<std::unique_ptr<Open>> streams;
    for (int i = 0; i < kStreams; ++i) {
      streams.push_back(std::make_unique<Open>());
      streams.back()->wire = connection.queries().StreamQueries(&streams.back()->context);
      v1::StreamQueriesResponse response;
      EXPECT_TRUE(streams.back()->wire->Write(query));
      EXPECT_TRUE(streams.back()->wire->Read(&response)) << "stream " << i;
    }
    return streams;
  }
  void ExpectLittleKept(const client::Connection& connection,
                        const v1::StreamQueriesRequest& query) {
    const double before_MiB = server().ResidentMebibytes();
    const auto streams = OpenAll(connection, query);
    const double after_MiB = server().ResidentMebibytes();
    RecordProperty("resident_MiB_before", std::to_string(before_MiB));
    RecordProperty("resident_MiB_after", std::to_string(after_MiB));
    EXPECT_LT(after_MiB - before_MiB, kMax_MiB);
    CloseAll(streams);
  }
  void CloseAll(const std::vector<std::unique_ptr<Open>>& streams) {
    for (const auto& stream : streams) {
      stream->wire->WritesDone();
      EXPECT_TRUE(stream->wire->Finish().ok());
    }
  }
};

TEST_F(IdleStreams, KeepNoRequestOfEightMebibytes) {
  const client::Connection connection({.address = address(), .deadline = {}});
  v1::StreamQueriesRequest query;  // refused at once because of its rows
  query.mutable_get_distances()->mutable_subject()->mutable_points()->mutable_data()->resize(8
                                                                                             << 20);
  ExpectLittleKept(connection, query);
}

TEST_F(IdleStreams, KeepNoAnswerOfTheLargestBatch) {
  ASSERT_EQ(Cwm({"put", "crate", "--box", "1,1,1", "--at", "0,0,0"}).exit_code, 0);
  const client::Connection connection({.address = address(), .deadline = {}});
  constexpr std::size_t kRows = 65'536;  // 1.5 MiB of points
  v1::StreamQueriesRequest query;
  query.mutable_get_distances()->mutable_subject()->mutable_points()->set_data(
      client::RowBytes(std::vector<client::PointRow>(kRows, {2, 0, 0})));
  ExpectLittleKept(connection, query);
}

}  // namespace
}  // namespace cwm::testing
