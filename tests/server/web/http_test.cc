#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

#include "proto/transfer/sha256.h"
#include "tests/server/web/running_viewer.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;
using testing::HttpResponse;
using ::testing::Not;
using testing::RawConnection;
using testing::RequestText;

class HttpTest : public RunningViewer {
 protected:
  using RunningViewer::RunningViewer;

  // Pseudo-random bytes, so that a misplaced chunk is detected.
  std::string PutBlob(std::size_t labels) {
    std::string bytes;
    for (std::uint32_t i = 0; i < labels; ++i) {
      const std::uint32_t label = i * 2'654'435'761U;
      bytes.append(reinterpret_cast<const char*>(&label), sizeof(label));
    }
    EXPECT_TRUE(application_.geometry.Put(BlobFormat::kLabelsU32, bytes).ok());
    return bytes;
  }
  HttpResponse Raw(const std::string& bytes) {
    RawConnection connection(port());
    connection.Send(bytes);
    return connection.Receive();
  }
};

TEST_F(HttpTest, ThePageComesWithItsFilesAndKeepsToItself) {
  const HttpResponse page = SendRequest("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.body, "<!doctype html>page");
  EXPECT_EQ(page.fields.at("content-type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.fields.at("x-content-type-options"), "nosniff");
  EXPECT_EQ(page.fields.at("referrer-policy"), "no-referrer");
  const std::string policy = page.fields.at("content-security-policy");
  for (const std::string& rule :
       {std::string("default-src 'none'"), std::string("script-src 'self';"),
        std::string("worker-src 'self'"), std::string("frame-ancestors 'none'"),
        "connect-src 'self' ws://127.0.0.1:" + std::to_string(port()) + ";"}) {
    EXPECT_THAT(policy, HasSubstr(rule));
  }
  EXPECT_THAT(policy, Not(HasSubstr("unsafe")));
  EXPECT_EQ(SendRequest("/viewer.js").fields.at("content-type"), "text/javascript; charset=utf-8");
  EXPECT_EQ(SendRequest("/viewer.js?v=1").body, "script()");
  EXPECT_EQ(SendRequest("/style.css").fields.at("content-type"), "text/css; charset=utf-8");
  EXPECT_EQ(SendRequest("/worker.js").status, 404) << "this page has none";
}

TEST_F(HttpTest, AFileThatIsKnownIsNotSentAgain) {
  const HttpResponse first = SendRequest("/viewer.js");
  EXPECT_EQ(first.fields.at("cache-control"), "no-cache");
  const HttpResponse second =
      SendRequest("/viewer.js", {{"If-None-Match", first.fields.at("etag")}});
  EXPECT_EQ(second.status, 304);
  EXPECT_EQ(second.body, "");
  EXPECT_EQ(SendRequest("/viewer.js", {{"If-None-Match", "\"other\""}}).status, 200);
}

TEST_F(HttpTest, WhoTakesGzipGetsIt) {
  for (const char* accepted : {"gzip", "br, gzip;q=0.5", "deflate,GZIP ; q=1"}) {
    const HttpResponse zipped = SendRequest("/viewer.js", {{"Accept-Encoding", accepted}});
    EXPECT_EQ(zipped.body, "zipped") << accepted;
    EXPECT_EQ(zipped.fields.at("content-encoding"), "gzip");
    EXPECT_EQ(zipped.fields.at("vary"), "Accept-Encoding");
    EXPECT_EQ(zipped.fields.at("content-type"), "text/javascript; charset=utf-8");
  }
  for (const char* accepted :
       {"", "identity", "gzip;q=0", "br, gzip; q=0.000", "xgzip", "gzip;q=x", ";;;,,", "gzip;q"}) {
    const HttpResponse plain = SendRequest("/viewer.js", {{"Accept-Encoding", accepted}});
    EXPECT_EQ(plain.body, "script()") << accepted;
    EXPECT_FALSE(plain.fields.contains("content-encoding")) << accepted;
    EXPECT_EQ(plain.fields.at("vary"), "Accept-Encoding");
  }
  // Each of the two representations has its own ETag.
  const HttpResponse zipped = SendRequest("/viewer.js", {{"Accept-Encoding", "gzip"}});
  const std::string etag = zipped.fields.at("etag");
  EXPECT_EQ(SendRequest("/viewer.js", {{"If-None-Match", etag}}).status, 200);
  EXPECT_EQ(
      SendRequest("/viewer.js", {{"If-None-Match", etag}, {"Accept-Encoding", "gzip"}}).status,
      304);
  EXPECT_FALSE(SendRequest("/style.css", {{"Accept-Encoding", "gzip"}}).fields.contains("vary"));
}

TEST_F(HttpTest, HeadTellsTheSameWithoutTheBody) {
  const std::string bytes = PutBlob(700'000);
  for (const std::string& target : {std::string("/"), "/geometry/" + Sha256Hex(bytes)}) {
    RawConnection connection(port());
    for (int round = 0; round < 2; ++round) {  // the connection stays open
      ASSERT_TRUE(connection.Send(RequestText(port(), "HEAD", target)));
      const HttpResponse head = connection.Receive(/*to_head=*/true);
      EXPECT_EQ(head.status, 200);
      EXPECT_EQ(head.body, "");
      ASSERT_TRUE(connection.Send(RequestText(port(), "GET", target)));
      const HttpResponse get = connection.Receive();
      EXPECT_EQ(head.fields, get.fields);
      EXPECT_EQ(head.fields.at("content-length"), std::to_string(get.body.size()));
    }
  }
}

TEST_F(HttpTest, BlobsAreReadByTheirHash) {
  RawConnection connection(port());
  for (const std::size_t labels : {1U, 262'144U, 1'000'000U}) {
    const std::string bytes = PutBlob(labels);
    ASSERT_TRUE(connection.Send(RequestText(port(), "GET", "/geometry/" + Sha256Hex(bytes))));
    const HttpResponse blob = connection.Receive();
    EXPECT_EQ(blob.status, 200);
    EXPECT_TRUE(blob.body == bytes);
    EXPECT_EQ(blob.fields.at("content-type"), "application/octet-stream");
    EXPECT_EQ(blob.fields.at("cache-control"), "public, max-age=31536000, immutable");
    EXPECT_EQ(blob.fields.at("x-content-type-options"), "nosniff");
  }
}

TEST_F(HttpTest, BlobsThatAreNotThereAreSaidToBe) {
  const HttpResponse unknown = SendRequest("/geometry/" + std::string(64, '0'));
  EXPECT_EQ(unknown.status, 404);
  EXPECT_THAT(unknown.body, HasSubstr("no geometry"));
  for (const std::string& name : {std::string(), std::string("x"), std::string(63, '0'),
                                  std::string(65, '0'), std::string(64, 'g'), std::string(64, 'A'),
                                  std::string("../../etc/passwd"), std::string(64, '0') + "/"}) {
    const HttpResponse bad = SendRequest("/geometry/" + name);
    EXPECT_EQ(bad.status, 400) << name;
    EXPECT_THAT(bad.body, HasSubstr("hash: must be the 64 lower-case hex digits"));
  }
}

TEST_F(HttpTest, OnlyWhatIsInTheTableIsThere) {
  for (const char* target :
       {"/../../etc/passwd", "/..%2f..%2fetc/passwd", "//etc/passwd", "/index.html", "/viewer.js/",
        "/style.css/..", "/%2e%2e/", "/.git/config", "/socket/", "/geometry", "*", "/\\..\\"}) {
    const HttpResponse answer = SendRequest(target);
    EXPECT_EQ(answer.status, 404) << target;
    EXPECT_THAT(answer.body, HasSubstr("path: there is no such page"));
  }
  ExpectServes();
}

TEST_F(HttpTest, ForeignHostsAreRefusedEverywhere) {
  const std::string blob = "/geometry/" + Sha256Hex(PutBlob(1));
  for (const std::string& target : {std::string("/"), std::string("/viewer.js"),
                                    std::string("/socket"), blob, std::string("/nothing")}) {
    const HttpResponse answer = SendRequest(target, {{"Host", "evil.example"}});
    EXPECT_EQ(answer.status, 403) << target;
    EXPECT_THAT(answer.body, HasSubstr("Host: is \"evil.example\", must be one of 127.0.0.1:"));
  }
  const std::string own = "127.0.0.1:" + std::to_string(port());
  EXPECT_EQ(SendRequest("/", {{"Host", own}, {"Host", own}}).status, 403);
  EXPECT_EQ(Raw("GET / HTTP/1.1\r\n\r\n").status, 403) << "no Host at all";
  EXPECT_EQ(Raw("GET / HTTP/1.0\r\n\r\n").status, 403);
}

TEST_F(HttpTest, NothingIsChangedByIt) {
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "BREW"}) {
    const HttpResponse answer = SendRequest("/", {}, method);
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_EQ(answer.fields.at("allow"), "GET, HEAD");
  }
  EXPECT_EQ(Raw(RequestText(port(), "POST", "/", {{"Content-Length", "4"}}) + "body").status, 405);
}

TEST_F(HttpTest, MalformedRequestsAreRefusedAndTheConnectionEnds) {
  const ViewerLimits limits;
  struct Case {
    std::string bytes;
    int status;
    std::string said;
  };
  const std::string long_value(limits.header_bytes, 'a');
  const Case cases[] = {
      {RequestText(port(), "GET", "/", {{"X", long_value}}), 431, "must have at most 16384 bytes"},
      {"GET /" + long_value + " HTTP/1.1\r\n\r\n", 431, "must have at most 16384 bytes"},
      {RequestText(port(), "GET", "/", {{"Content-Length", "5"}}) + "hello", 413, "must be empty"},
      {RequestText(port(), "GET", "/", {{"Content-Length", "99999999999"}}), 413, "must be empty"},
      {RequestText(port(), "GET", "/", {{"Transfer-Encoding", "chunked"}}) + "5\r\nhello\r\n", 413,
       "must be empty"},
      {std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11), 400, "request: "},
      {"GET / HTTP/9.9\r\n\r\n", 400, "request: "},
      {"GET\r\n\r\n", 400, "request: "},
      {std::string("GET /\0 HTTP/1.1\r\n\r\n", 19), 400, "request: "},
      {RequestText(port(), "GET", "/", {{"Content-Length", "-1"}}), 400, "request: "},
  };
  for (const Case& hostile : cases) {
    SCOPED_TRACE(hostile.bytes.substr(0, 60));
    RawConnection connection(port());
    connection.Send(hostile.bytes);
    const HttpResponse answer = connection.Receive();
    EXPECT_EQ(answer.status, hostile.status);
    EXPECT_THAT(answer.body, HasSubstr(hostile.said));
    EXPECT_TRUE(connection.Ends(std::chrono::seconds(5)));
  }
  ExpectServes();
}

TEST_F(HttpTest, TheSocketIsNoPage) {
  const HttpResponse answer = SendRequest("/socket");
  EXPECT_EQ(answer.status, 426);
  EXPECT_EQ(answer.fields.at("upgrade"), "websocket");
}

TEST_F(HttpTest, PipelinedRequestsAreAnsweredInOrder) {
  RawConnection connection(port());
  ASSERT_TRUE(connection.Send(RequestText(port(), "GET", "/") +
                              RequestText(port(), "GET", "/viewer.js") +
                              RequestText(port(), "GET", "/nothing")));
  EXPECT_EQ(connection.Receive().body, "<!doctype html>page");
  EXPECT_EQ(connection.Receive().body, "script()");
  EXPECT_EQ(connection.Receive().status, 404);
}

TEST_F(HttpTest, AnAddressThatIsTakenIsSaidToBe) {
  const auto second = ViewerServer::Start(At("127.0.0.1", port()), server_->InProcessChannel());
  EXPECT_EQ(second.status().code(), absl::StatusCode::kAlreadyExists) << second.status();
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr("127.0.0.1:" + std::to_string(port())));
}

TEST_F(HttpTest, BeyondLoopbackATokenIsMade) {
  const auto open = ViewerServer::Start(At("0.0.0.0", 0), server_->InProcessChannel());
  ASSERT_TRUE(open.ok()) << open.status();
  for (const std::string& url : (*open)->urls()) {
    EXPECT_THAT(url,
                ::testing::MatchesRegex("http://[a-zA-Z0-9._-]+:[0-9]+/\\?token=[0-9a-f]{32}"));
    EXPECT_THAT(url, Not(HasSubstr("0.0.0.0"))) << "nobody else can open that";
  }
  ViewerOptions options = At("127.0.0.1", 0);
  options.token = "short";
  const auto weak = ViewerServer::Start(options, server_->InProcessChannel());
  EXPECT_EQ(weak.status().code(), absl::StatusCode::kInvalidArgument);
}

// Checks independently of the server whether the system supports IPv6.
bool HasIPv6() {
  const int probe = socket(AF_INET6, SOCK_STREAM, 0);
  if (probe < 0) return false;
  sockaddr_in6 everywhere = {};
  everywhere.sin6_family = AF_INET6;
  const bool bound =
      bind(probe, reinterpret_cast<const sockaddr*>(&everywhere), sizeof(everywhere)) == 0;
  close(probe);
  return bound;
}

TEST_F(HttpTest, OnAllInterfacesOfIPv6ThoseOfIPv4AreHeardToo) {
  ViewerOptions options = At("::", 0);
  options.files = Files();
  options.token = "a-token-of-a-user";
  const auto open = ViewerServer::Start(options, server_->InProcessChannel());
  if (!HasIPv6()) {  // a machine without IPv6 gets an error that names the address
    ASSERT_FALSE(open.ok());
    EXPECT_NE(open.status().message().find("[::]"), std::string::npos) << open.status();
    return;
  }
  ASSERT_TRUE(open.ok()) << open.status();
  const std::string url = (*open)->urls().front();
  const std::size_t path = url.rfind('/');
  const std::size_t colon = url.rfind(':', path);
  const int its_port = std::stoi(url.substr(colon + 1, path - colon - 1));
  EXPECT_EQ(testing::SendRequest(its_port, "/?token=a-token-of-a-user").status, 200)
      << "by 127.0.0.1";
}

class TokenTest : public HttpTest {
 protected:
  TokenTest() : HttpTest(ViewerLimits{}, "a-token-of-a-user") {}
};

TEST_F(TokenTest, WithoutTheTokenNothingIsTold) {
  const std::string blob = "/geometry/" + Sha256Hex(PutBlob(1));
  for (const std::string& target :
       {std::string("/"), std::string("/viewer.js"), std::string("/socket"), blob,
        std::string("/nothing"), std::string("/?token=wrong-token-here")}) {
    const HttpResponse answer = SendRequest(target);
    EXPECT_EQ(answer.status, 403) << target;
    EXPECT_THAT(answer.body, HasSubstr("token: is "));
    EXPECT_FALSE(answer.fields.contains("set-cookie"));
  }
  EXPECT_EQ(testing::WebSocketClient(port()).status(), 403);
}

TEST_F(TokenTest, TheTokenInTheAddressOpensTheRest) {
  const HttpResponse page = SendRequest("/?token=a-token-of-a-user");
  ASSERT_EQ(page.status, 200);
  EXPECT_EQ(page.fields.at("cache-control"), "no-store") << "it names a secret";
  const std::string cookie = page.fields.at("set-cookie");
  EXPECT_THAT(cookie, HasSubstr("HttpOnly"));
  EXPECT_THAT(cookie, HasSubstr("SameSite=Strict"));
  const std::string pair = cookie.substr(0, cookie.find(';'));
  const std::string blob = "/geometry/" + Sha256Hex(PutBlob(1));
  for (const std::string& target : {std::string("/"), std::string("/viewer.js"), blob}) {
    EXPECT_EQ(SendRequest(target, {{"Cookie", pair}}).status, 200) << target;
  }
  EXPECT_EQ(testing::WebSocketClient(port(), {.fields = {{"Cookie", pair}}}).status(), 101);
}

class SmallLimits : public HttpTest {
 protected:
  static ViewerLimits Limits() {
    ViewerLimits limits;
    limits.connections = 8;
    limits.http_idle_timeout = std::chrono::milliseconds(300);
    limits.write_timeout = std::chrono::milliseconds(300);
    return limits;
  }
  SmallLimits() : HttpTest(Limits()) {}
};

TEST_F(SmallLimits, WhoAsksNothingMakesRoomForWhoDoes) {
  std::vector<std::unique_ptr<RawConnection>> silent;
  for (int i = 0; i < 50; ++i) silent.push_back(std::make_unique<RawConnection>(port()));
  ExpectServes();
  for (const auto& connection : silent) EXPECT_TRUE(connection->Ends(std::chrono::seconds(5)));
}

TEST_F(SmallLimits, ARequestThatDribblesIsCutShort) {
  RawConnection slow(port());
  ASSERT_TRUE(slow.Send("GET / HTTP/1.1\r\nHost:"));
  const auto start = std::chrono::steady_clock::now();
  bool cut = false;
  while (!cut && std::chrono::steady_clock::now() - start < std::chrono::seconds(10)) {
    cut = !slow.Send(" ") || slow.Ends(std::chrono::milliseconds(50));
  }
  EXPECT_TRUE(cut);
  ExpectServes();
}

// A file of the page that is larger than what the kernel takes at once.
class LargeFile : public HttpTest {
 protected:
  static PageFiles Files() {
    static const std::string script(24 << 20, 's');
    PageFiles files = RunningViewer::Files();
    files.script = {.bytes = script};
    return files;
  }
  static ViewerLimits Limits() {
    ViewerLimits limits;
    limits.write_timeout = std::chrono::milliseconds(1'500);
    return limits;
  }
  LargeFile() : HttpTest(Limits(), "", Files()) {}
};

TEST_F(LargeFile, ComesWholeOnASlowLineAndNotAtAllWhereNobodyReads) {
  RawConnection slow(port());
  RawConnection never(port());
  for (RawConnection* connection : {&slow, &never}) {
    ASSERT_TRUE(connection->Send(RequestText(port(), "GET", "/viewer.js")));
  }
  // Altogether longer than a reader may take no byte.
  std::size_t taken = 0;
  for (int i = 0; i < 8; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    for (std::size_t piece = 0; piece < (std::size_t{3} << 20);) {
      const std::size_t read = slow.Take((std::size_t{3} << 20) - piece);
      ASSERT_GT(read, 0U) << taken;
      piece += read;
    }
    taken += std::size_t{3} << 20;
  }
  EXPECT_EQ(taken, Files().script.bytes.size());
  EXPECT_GT(slow.Take(4096), 0U) << "the header's bytes are left";
  const HttpResponse late = never.Receive();
  EXPECT_EQ(late.status, 0) << "it ends before the length that it named";
  ExpectServes();
}

TEST_F(SmallLimits, ABlobThatNobodyReadsIsGivenUp) {
  const std::string hash = Sha256Hex(PutBlob(5'000'000));
  RawConnection client(port());
  ASSERT_TRUE(client.Send(RequestText(port(), "GET", "/geometry/" + hash)));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const HttpResponse late = client.Receive();
  EXPECT_EQ(late.status, 0) << "it ends before the length that it named";
  ExpectServes();
}

}  // namespace
}  // namespace cwm::server
