#include "apps/serve/server.h"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/syscall.h>
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

// In the place of the system's: threads of libmicrohttpd that stop to listen
// take their time, so that they meet.
extern "C" int epoll_ctl(int set, int operation, int file,
                         epoll_event* event) noexcept {
  int listens = 0;
  socklen_t size = sizeof(listens);
  if (operation == EPOLL_CTL_DEL &&
      getsockopt(file, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) == 0 &&
      listens != 0) {
    usleep(20'000);
  }
  return static_cast<int>(syscall(SYS_epoll_ctl, set, operation, file, event));
}

namespace mle::serve {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kLarge = std::size_t{64} << 20;
constexpr std::size_t kMedium = std::size_t{2} << 20;  // more than is buffered

std::atomic<int> medium_answers = 0;  // that have been begun

// Made before a server starts, as that takes time; kept by answers that are
// being sent.
const std::shared_ptr<const std::string>& Large() {
  static const auto* const kText = new std::shared_ptr<const std::string>(
      std::make_shared<std::string>(kLarge, 'x'));
  return *kText;
}

std::unique_ptr<Server> Start(ServerOptions options = {}) {
  Large();
  absl::StatusOr<std::unique_ptr<Server>> server =
      Server::Start(options, [](const Request& request) {
        if (request.path == "/large") return Response{.body = Large()};
        if (request.path == "/medium") {
          ++medium_answers;
          return Response{.body = std::make_shared<std::string>(kMedium, 'x')};
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
  client.Send("G@T / HTTP/1.1\r\n\r\n");
  EXPECT_EQ(StatusOf(client.Answer()), 400);
  EXPECT_TRUE(client.IsClosed());
  EXPECT_EQ(StatusOf(Ask(server->port(), std::string(40'000, 'a'))), 414);
  EXPECT_EQ(StatusOf(Ask(server->port(), Get("/", std::string(40'000, 'a')))),
            431);
  // The head is as long as it may be, or longer by one byte, and has ended.
  const std::size_t rest = Get("/", "X: \r\n").size();
  for (const std::size_t more : {0U, 1U}) {
    const std::string value(kMostHead - rest + more, 'a');
    EXPECT_EQ(StatusOf(Ask(server->port(), Get("/", "X: " + value + "\r\n"))),
              more == 0 ? 200 : 431);
  }
  for (const std::size_t more : {0U, 1U}) {
    const std::string body(kMostBody + more, 'a');
    EXPECT_EQ(StatusOf(Ask(server->port(),
                           absl::StrCat("POST / HTTP/1.1\r\nHost: a\r\n"
                                        "Content-Length: ",
                                        body.size(), "\r\n\r\n", body))),
              more == 0 ? 200 : 413);
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
  EXPECT_TRUE(never.IsClosed());
  Client dripping(server->port());
  for (const char c : std::string(1000, 'a')) {
    if (!dripping.Send(std::string(1, c))) break;
    absl::SleepFor(absl::Milliseconds(20));
  }
  EXPECT_TRUE(dripping.IsClosed());
  // Between two requests, too.
  // A busy machine may send a request too late.
  for (int status = 0; status != 200;) {
    Client resting(server->port());
    resting.Send(Get("/"));
    status = StatusOf(resting.Answer());
    EXPECT_TRUE(resting.IsClosed());
  }
}

// However long an answer takes to be made, it is not the client's fault.
TEST(ServerTest, WhoseAnswerTakesTimeIsNotCutOff) {
  auto server = *Server::Start({.request_time = absl::Seconds(1)},
                               [](const Request& request) {
                                 absl::SleepFor(absl::Milliseconds(1500));
                                 return PlainResponse(200, request.path);
                               });
  EXPECT_EQ(BodyOf(Ask(server->port(), Get("/slow"))), "/slow\n");
}

TEST(ServerTest, WhoTakesNothingIsCutOff) {
  for (const ServerOptions& options :
       {ServerOptions{.response_time = absl::Milliseconds(300)},
        ServerOptions{.stall_time = absl::Seconds(1)}}) {
    const auto server = Start(options);
    Client client(server->port());
    client.Send(Get("/large"));
    EXPECT_TRUE(client.HasBytes());
    // The server has let go of its answer.
    while (Large().use_count() > 1) absl::SleepFor(absl::Milliseconds(5));
    // What the system holds, and then the end.
    EXPECT_LT(client.Answer().size(), kLarge);
  }
}

TEST(ServerTest, WhoHasWaitedLongestMakesRoom) {
  const auto server = Start({.connections = 300});
  std::deque<Client> slow;
  for (int i = 0; i < 320; ++i) {
    slow.emplace_back(server->port());
    slow.back().Send(i % 2 == 0 ? "GET" : "");
  }
  EXPECT_TRUE(slow.front().IsClosed());
  // As soon as those who were cut off are gone.
  int status = 0;
  for (int i = 0; i < 2000 && status != 200; ++i) {
    absl::SleepFor(absl::Milliseconds(10));
    status = StatusOf(Ask(server->port(), Get("/")));
  }
  EXPECT_EQ(status, 200);
}

TEST(ServerTest, AnswersThatNobodyTakesMakeRoom) {
  static constexpr std::size_t kBytes = std::size_t{4} << 20;
  auto server =
      *Server::Start({.answer_bytes = 4 * kBytes}, [](const Request& request) {
        if (request.path != "/own") return PlainResponse(200, "small");
        return Response{.body = std::make_shared<std::string>(kBytes, 'x')};
      });
  std::deque<Client> stalled;
  for (int i = 0; i < 12; ++i) {
    stalled.emplace_back(server->port());
    stalled.back().Send(Get("/own"));
    EXPECT_TRUE(stalled.back().HasBytes());
    EXPECT_EQ(StatusOf(Ask(server->port(), Get("/"))), 200) << i;
  }
  EXPECT_LT(stalled.front().Answer().size(), kBytes);
  EXPECT_GT(stalled.back().Answer().size(), kBytes);
}

TEST(ServerTest, WhoReadsNothingOfManyAnswersKeepsNobodyOut) {
  const auto server = Start();
  std::string requests;
  for (int i = 0; i < 400; ++i) requests += Get("/large");
  std::deque<Client> stalled;
  for (int i = 0; i < 70; ++i) {
    stalled.emplace_back(server->port());
    stalled.back().Send(requests);
  }
  EXPECT_EQ(StatusOf(Ask(server->port(), Get("/"))), 200);
}

TEST(ServerTest, StopEndsAnswersAndClosesTheRest) {
  auto server = Start();
  Client resting(server->port());
  resting.Send(Get("/"));
  EXPECT_EQ(StatusOf(resting.Answer()), 200);
  Client large(server->port());
  large.Send(Get("/medium"));
  std::string answer;
  std::thread reader([&] { answer = large.Answer(); });
  while (medium_answers == 0) absl::SleepFor(absl::Milliseconds(1));
  server->Stop();
  reader.join();
  EXPECT_EQ(BodyOf(answer).size(), kMedium);
  EXPECT_TRUE(resting.IsClosed());
  EXPECT_FALSE(Client(server->port()).connected());
  server->Stop();
}

TEST(ServerTest, StopsWhileOthersAsk) {
  for (int run = 0; run < 10; ++run) {
    auto server = Start();
    const int port = server->port();
    std::vector<std::thread> busy;
    for (int i = 0; i < 8; ++i) {
      busy.emplace_back([port] {
        for (bool connected = true; connected;) {
          Client client(port);
          connected = client.connected() && client.Send(Get("/"));
          client.Answer();
        }
      });
    }
    absl::SleepFor(absl::Milliseconds(20));
    server->Stop();
    for (std::thread& one : busy) one.join();
  }
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
