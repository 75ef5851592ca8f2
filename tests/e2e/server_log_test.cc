// The server's log on stderr.
#include <gmock/gmock.h>

#include <fstream>
#include <regex>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::Not;

class ServerLogTest : public ServerTest {
 protected:
  void TearDown() override {}  // each test ends the server to read its last lines
};

TEST_F(ServerLogTest, TellsScansRobotsRefusalsSlowCallsAndChangesOfState) {
  const std::string scan = Simulate("table", {"--scene", "table", "--seed", "1"});
  ASSERT_EQ(Cwm({"ingest", scan, "--sensor", "wrist"}).exit_code, 0);
  std::ofstream(scratch() / "r.urdf") << "<robot name=\"r\"><link name=\"base\"/></robot>";
  ASSERT_EQ(Cwm({"robot", "load", scratch() / "r.urdf"}).exit_code, 0);
  EXPECT_EQ(Cwm({"get", "a_thing_with_a_name"}).exit_code, 3);
  EXPECT_NE(Cwm({"--deadline", "1.5", "call", "cwm.v1.WorldService/ListObjects",
                 "{\"at_revision\": {\"at_least\": \"99\"}}"})
                .exit_code,
            0);
  ASSERT_EQ(Cwm({"call", "cwm.v1.WorldService/DeleteWorld", "{}"}).exit_code, 0);
  ASSERT_EQ(server().Stop(), 0);
  const std::string log = ServerLog();
  EXPECT_THAT(log, HasSubstr("listens on"));
  EXPECT_THAT(log, ContainsRegex("world created: \"default\", uid [0-9a-f]+"));
  EXPECT_THAT(log, ContainsRegex("ingest: world \"default\", sensor \"wrist\", [1-9][0-9]* points, "
                                 "[0-9]+ ms, [1-9][0-9]* objects, revision 1, OK"));
  EXPECT_THAT(log, HasSubstr("robot loaded: world \"default\", robot \"r\", 1 links, revision 2"));
  EXPECT_THAT(log, ContainsRegex("refused OBJECT_UNKNOWN: /cwm.v1.WorldService/GetObject, "
                                 "NOT_FOUND, connection [0-9]+"));
  EXPECT_THAT(log, Not(HasSubstr("a_thing_with_a_name")));
  EXPECT_THAT(log, ContainsRegex("slow: /cwm.v1.WorldService/ListObjects, 1[0-9][0-9][0-9] ms, "
                                 "[1-9][0-9]* bytes asked"));
  EXPECT_THAT(log, ContainsRegex("world deleted: \"default\", uid [0-9a-f]+"));
  EXPECT_THAT(log, HasSubstr("draining after signal 15"));
  EXPECT_THAT(log, HasSubstr("stopped"));
}

}  // namespace
}  // namespace cwm::testing
