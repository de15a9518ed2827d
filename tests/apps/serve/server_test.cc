#include "apps/serve/server.h"

#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/serve/client.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::serve {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::atomic<int> large_answers = 0;  // that have been begun

std::unique_ptr<Server> Start(ServerOptions options = {}) {
  absl::StatusOr<std::unique_ptr<Server>> server =
      Server::Start(options, [](const Request& request) {
        if (request.path == "/large") {
          ++large_answers;
          static const auto body =
              std::make_shared<std::string>(std::size_t{64} << 20, 'x');
          return Response{.body = body};
        }
        return PlainResponse(
            200,
            absl::StrCat(request.method, " ", request.path, " ", request.body));
      });
  EXPECT_TRUE(server.ok()) << server.status();
  return *std::move(server);
}

TEST(ServerTest, AnswersRequestsOfOneConnection) {
  const auto server = Start();
  Client client(server->port());
  // Two at once.
  client.Send(Get("/a") + Get("/b"));
  EXPECT_EQ(BodyOf(client.Answer()), "GET /a \n");
  EXPECT_EQ(BodyOf(client.Answer()), "GET /b \n");
  client.Send("POST /c HTTP/1.1\r\nHost: a\r\nContent-Length: 4\r\n\r\nb");
  client.Send("ody");
  EXPECT_EQ(BodyOf(client.Answer()), "POST /c body\n");
  client.Send(Get("/d", "Connection: close\r\n"));
  EXPECT_THAT(client.Answer(), HasSubstr("Connection: close"));
  EXPECT_TRUE(client.IsClosed());
}

TEST(ServerTest, AHeadHasTheLengthAndNoBody) {
  const auto server = Start();
  Client client(server->port());
  client.Send("HEAD /a HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n");
  std::string all = client.Answer();
  EXPECT_THAT(all, HasSubstr("Content-Length: 9\r\n"));
  EXPECT_EQ(BodyOf(all), "");
}

TEST(ServerTest, NeitherRangesNorCompressionAreTheClients) {
  const auto server = Start();
  const std::string answer =
      Ask(server->port(),
          Get("/abc", "Range: bytes=0-1,0-1\r\nAccept-Encoding: gzip, br\r\n"));
  EXPECT_EQ(StatusOf(answer), 200);
  EXPECT_EQ(BodyOf(answer), "GET /abc \n");
}

TEST(ServerTest, AFileIsSent) {
  const ScratchFolder folder;
  const std::string text(200'000, 'y');
  const std::string path = folder.Write("served", text);
  const auto file = std::shared_ptr<const int>(
      new int(open(path.c_str(), O_RDONLY)), [](const int* descriptor) {
        close(*descriptor);
        delete descriptor;
      });
  const auto server = Server::Start({}, [&](const Request&) {
    return Response{.file = file, .file_bytes = text.size()};
  });
  ASSERT_TRUE(server.ok());
  EXPECT_EQ(BodyOf(Ask((*server)->port(), Get("/"))), text);
}

TEST(ServerTest, BadRequestsAreAnsweredAndClosed) {
  const auto server = Start();
  Client client(server->port());
  client.Send("NONSENSE\r\n\r\n");
  EXPECT_EQ(StatusOf(client.Answer()), 400);
  EXPECT_TRUE(client.IsClosed());
  EXPECT_EQ(StatusOf(Ask(server->port(), std::string(40'000, 'a'))), 431);
  // The head is as long as it may be, or longer by one byte, and has ended.
  const std::size_t rest = Get("/", "X: \r\n").size();
  for (const std::size_t more : {0, 1}) {
    const std::string value(kMostHead - rest + more, 'a');
    EXPECT_EQ(StatusOf(Ask(server->port(), Get("/", "X: " + value + "\r\n"))),
              more == 0 ? 200 : 431);
  }
  EXPECT_EQ(StatusOf(Ask(server->port(),
                         "POST / HTTP/1.1\r\nHost: a\r\n"
                         "Content-Length: 100000\r\n\r\n" +
                             std::string(100'000, 'a'))),
            413);
  EXPECT_EQ(StatusOf(Ask(server->port(), Get("/after"))), 200);
}

TEST(ServerTest, WhoSendsSlowlyIsCutOff) {
  const auto server = Start({.request_time = absl::Milliseconds(300)});
  Client never(server->port());
  never.Send("GET / HT");
  EXPECT_EQ(StatusOf(never.Answer()), 408);
  EXPECT_TRUE(never.IsClosed());
  Client dripping(server->port());
  std::string answer;
  for (const char c : std::string(1000, 'a')) {
    if (!dripping.Send(std::string(1, c))) break;
    absl::SleepFor(absl::Milliseconds(20));
  }
  EXPECT_TRUE(dripping.IsClosed());
}

TEST(ServerTest, WhoRestsTooLongIsCutOff) {
  const auto server = Start({.idle_time = absl::Milliseconds(200)});
  Client client(server->port());
  client.Send(Get("/"));
  EXPECT_EQ(StatusOf(client.Answer()), 200);
  EXPECT_TRUE(client.IsClosed());
}

TEST(ServerTest, WhoRestsIsNotCutOffForThoseWhoNeedNotWait) {
  const auto server = Start();
  std::deque<Client> resting;
  for (int i = 0; i < 20; ++i) {
    resting.emplace_back(server->port());
    resting.back().Send(Get("/"));
    EXPECT_EQ(StatusOf(resting.back().Answer()), 200);
  }
  std::vector<std::thread> others;
  for (int i = 0; i < 2; ++i) {
    others.emplace_back([&server] {
      const absl::Time end = absl::Now() + absl::Seconds(1);
      while (absl::Now() < end) {
        EXPECT_EQ(StatusOf(Ask(server->port(), Get("/"))), 200);
      }
    });
  }
  for (std::thread& other : others) other.join();
  for (Client& client : resting) {
    client.Send(Get("/again"));
    EXPECT_EQ(StatusOf(client.Answer()), 200);
  }
}

TEST(ServerTest, WhoTakesNothingIsCutOff) {
  const auto server = Start({.response_time = absl::Milliseconds(300)});
  Client client(server->port());
  client.Send(Get("/large"));
  absl::SleepFor(absl::Seconds(1));
  // What the system holds, and then the end.
  EXPECT_LT(client.Answer().size(), std::size_t{64} << 20);
}

TEST(ServerTest, SlowClientsDoNotKeepOthersOut) {
  const auto server = Start({.connections = 2, .hurry = absl::Milliseconds(1)});
  // cpp-httplib makes its table of methods at its first request, under a guard
  // that the thread sanitizer does not see: let it be one alone.
  EXPECT_EQ(StatusOf(Ask(server->port(), Get("/"))), 200);
  std::deque<Client> slow;
  for (int i = 0; i < 8; ++i) {
    slow.emplace_back(server->port());
    slow.back().Send(i % 2 == 0 ? "GET" : "");
  }
  EXPECT_EQ(StatusOf(Ask(server->port(), Get("/"))), 200);
}

TEST(ServerTest, StopAnswersWhatWasAskedAndClosesTheRest) {
  auto server = Start();
  Client resting(server->port());
  resting.Send(Get("/"));
  EXPECT_EQ(StatusOf(resting.Answer()), 200);
  Client large(server->port());
  const int before = large_answers;
  large.Send(Get("/large"));
  std::string answer;
  std::thread reader([&] { answer = large.Answer(); });
  while (large_answers == before) absl::SleepFor(absl::Milliseconds(1));
  server->Stop();
  reader.join();
  EXPECT_EQ(BodyOf(answer).size(), std::size_t{64} << 20);
  EXPECT_TRUE(resting.IsClosed());
  EXPECT_FALSE(Client(server->port()).connected());
  server->Stop();
}

TEST(ServerTest, APortInUseIsSaid) {
  const auto first = Start();
  const auto second = Server::Start({.port = first->port()}, nullptr);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kUnavailable);
  EXPECT_THAT(std::string(second.status().message()),
              HasSubstr(absl::StrCat(first->port())));
}

TEST(ParseAddressTest, TakesAddressesInNumbers) {
  EXPECT_EQ(ParseAddress("127.0.0.1:8080")->port, 8080);
  EXPECT_EQ(ParseAddress("8080")->host, "127.0.0.1");
  EXPECT_EQ(ParseAddress("[::1]:1")->host, "::1");
  EXPECT_EQ(ParseAddress("localhost:1")->host, "localhost");
  for (const char* bad : {"", "a:1", "1.2.3:1", "127.0.0.1:", "127.0.0.1:x",
                          "127.0.0.1:65536", "127.0.0.1:-1", "::1:80", ":80"}) {
    EXPECT_FALSE(ParseAddress(bad).ok()) << bad;
  }
  EXPECT_TRUE(IsLoopback("127.0.0.1"));
  EXPECT_TRUE(IsLoopback("::1"));
  EXPECT_FALSE(IsLoopback("0.0.0.0"));
}

}  // namespace
}  // namespace mle::serve
