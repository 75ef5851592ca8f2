// Independent tools must be able to use the server: buf, through reflection.
#include <filesystem>

#include "absl/strings/escaping.h"
#include "proto/transfer/crc32c.h"
#include "proto/transfer/sha256.h"
#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

constexpr char kBuf[] = "proto/node_modules/.bin/buf";  // installed by ./dev test

TEST(Protos, AreCleanUnderBufLint) {
  ASSERT_TRUE(std::filesystem::exists(kBuf)) << "buf is missing: ./dev setup test installs it";
  const ProcessResult lint = RunProgram({kBuf, "lint", "proto"});
  EXPECT_EQ(lint.exit_code, 0) << lint.out << lint.err;
}

class Reflection : public ServerTest {
 protected:
  ProcessResult BufCurl(const std::string& method, const std::string& request) const {
    return RunProgram({kBuf, "curl", "--protocol", "grpc", "--http2-prior-knowledge",
                       "--unix-socket", address().substr(5), "--reflect-protocol", "grpc-v1alpha",
                       "-d", request, "http://localhost/" + method});
  }
};

TEST_F(Reflection, ListsEveryService) {
  const ProcessResult run =
      RunProgram({kBuf, "curl", "--protocol", "grpc", "--http2-prior-knowledge", "--unix-socket",
                  address().substr(5), "--reflect-protocol", "grpc-v1alpha", "--list-services",
                  "http://localhost"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* service :
       {"cwm.v1.PerceptionService", "cwm.v1.WorldService", "cwm.v1.QueryService",
        "cwm.v1.AdminService", "cwm.v1.RobotService", "grpc.health.v1.Health"}) {
    EXPECT_NE(run.out.find(service), std::string::npos) << service << " not in " << run.out;
  }
}

TEST_F(Reflection, CallsTheServices) {
  const ProcessResult put =
      BufCurl("cwm.v1.WorldService/ApplyChanges", R"({"changes": [{"put": {"object": {
      "name": "ball", "shapes": [{"sphere": {"radiusM": 0.1}}]}}}]})");
  ASSERT_EQ(put.exit_code, 0) << put.err;
  EXPECT_EQ(nlohmann::json::parse(put.out).at("revision"), "1");

  const ProcessResult distance = BufCurl("cwm.v1.QueryService/GetDistances", R"({
      "subject": {"shapes": {"shapes": [{"sphere": {"radiusM": 0.1}}], "xWorldBody": {"data":
        "AAAAAAAA8D8AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA8D8="}}},
      "options": {"resultForm": "RESULT_FORM_ROWS"}})");  // one pose: 1 m along x
  ASSERT_EQ(distance.exit_code, 0) << distance.err;
  const nlohmann::json answer = nlohmann::json::parse(distance.out)["rows"][0]["answers"][0];
  EXPECT_NEAR(answer.at("distanceM").get<double>(), 0.8, 1e-12);
  EXPECT_EQ(answer.at("object"), "ball");

  const ProcessResult info = BufCurl("cwm.v1.AdminService/GetServerInfo", "{}");
  ASSERT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(nlohmann::json::parse(info.out)["engines"].size(), 3U);

  const ProcessResult health = BufCurl("grpc.health.v1.Health/Check", "{}");
  ASSERT_EQ(health.exit_code, 0) << health.err;
  EXPECT_EQ(nlohmann::json::parse(health.out).at("status"), "SERVING");
}

// A square of 41 x 41 points, 0.4 m wide, 1 m in front of the sensor: x y z as floats, row by row.
std::string Square() {
  std::string bytes;
  for (int row = 0; row < 41; ++row) {
    for (int column = 0; column < 41; ++column) {
      const float point[3] = {0.01F * static_cast<float>(column - 20),
                              0.01F * static_cast<float>(row - 20), 1};
      bytes.append(reinterpret_cast<const char*>(point), sizeof(point));
    }
  }
  return bytes;
}

TEST_F(Reflection, CallsThePerceptionServiceWithAStreamOfRequests) {
  const std::string bytes = Square();
  const nlohmann::json header = {
      {"header",
       {{"pointCount", 41 * 41},
        {"totalBytes", bytes.size()},
        {"width", 41},
        {"height", 41},
        {"up", {{"z", -1}}},
        {"layout",
         {{"pointStep", 12},
          {"fields",
           {{{"name", "x"}, {"type", "FIELD_TYPE_F32"}},
            {{"name", "y"}, {"offset", 4}, {"type", "FIELD_TYPE_F32"}},
            {{"name", "z"}, {"offset", 8}, {"type", "FIELD_TYPE_F32"}}}}}}}}};
  const nlohmann::json chunk = {
      {"chunk", {{"data", absl::Base64Escape(bytes)}, {"crc32c", Crc32c(bytes)}}}};
  const nlohmann::json finish = {{"finish", {{"sha256", Sha256Hex(bytes)}}}};
  const ProcessResult ingest = BufCurl("cwm.v1.PerceptionService/IngestCloud",
                                       header.dump() + "\n" + chunk.dump() + "\n" + finish.dump());
  ASSERT_EQ(ingest.exit_code, 0) << ingest.err;
  const nlohmann::json answer = nlohmann::json::parse(ingest.out);
  EXPECT_EQ(answer.at("revision"), "1");
  EXPECT_EQ(answer.at("report").at("pointsIn"), "1681");
  EXPECT_EQ(answer.at("report").at("pointsFinite"), "1681");
  ASSERT_EQ(answer.at("supports").size(), 1U);
  EXPECT_EQ(answer["supports"][0].at("kind"), "OBJECT_KIND_SUPPORT");

  const ProcessResult cut =
      BufCurl("cwm.v1.PerceptionService/IngestCloud", header.dump() + "\n" + finish.dump());
  EXPECT_NE(cut.exit_code, 0);
  EXPECT_NE(cut.err.find("invalid_argument"), std::string::npos) << cut.err;
}

}  // namespace
}  // namespace cwm::testing
