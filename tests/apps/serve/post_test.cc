#include "apps/serve/post.h"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace mle::serve {
namespace {

constexpr std::chrono::milliseconds kPause(10);
constexpr std::chrono::milliseconds kNoPause(0);

// Answers one request with a beginning and then the same again and again, until
// the other end is gone.
class DrippingServer {
 public:
  explicit DrippingServer(const std::string& begin,
                          const std::string& again = "a",
                          std::chrono::milliseconds pause = kPause)
      : again_(again), pause_(pause), socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(socket_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(listen(socket_, 1), 0);
    getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this, begin] { Drip(begin); });
  }
  ~DrippingServer() {
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    close(socket_);
  }
  DrippingServer(const DrippingServer&) = delete;
  DrippingServer& operator=(const DrippingServer&) = delete;

  std::string url() const { return absl::StrCat("http://127.0.0.1:", port_); }
  bool is_asked() const { return is_asked_; }
  bool is_left() const { return is_left_; }

 private:
  void Drip(const std::string& begin) {
    const int other = accept(socket_, nullptr, nullptr);
    if (other < 0) return;
    is_asked_ = true;
    std::string rest = begin;
    while (send(other, rest.data(), rest.size(), MSG_NOSIGNAL) >= 0) {
      rest = again_;
      std::this_thread::sleep_for(pause_);
    }
    is_left_ = true;
    close(other);
  }

  const std::string again_;
  const std::chrono::milliseconds pause_;
  int socket_;
  int port_ = 0;
  std::atomic<bool> is_asked_{false};
  std::atomic<bool> is_left_{false};
  std::thread thread_;
};

TEST(PostTest, AnAnswerThatGoesOnIsLeft) {
  for (const char* const begin :
       {"HTTP/1.1 200 OK\r\nX: ", "HTTP/1.1 200 OK\r\n", "HTTP/1.1 ", ""}) {
    // Not by the time.
    const DrippingServer server(begin, "X: y\r\n", kNoPause);
    EXPECT_FALSE(PostJson(server.url(), "{}", "id", std::chrono::hours(1)).ok())
        << begin;
  }
  const DrippingServer endless("HTTP/1.1 200 OK\r\nX: ", "a", kNoPause);
  EXPECT_FALSE(PostJson(endless.url(), "{}", "id", std::chrono::hours(1)).ok());
  // What comes after the head is of no interest.
  const DrippingServer taken("HTTP/1.1 204 No\r\n\r\n", "a", kNoPause);
  EXPECT_TRUE(PostJson(taken.url(), "{}", "id", std::chrono::hours(1)).ok());
}

TEST(PostTest, RedirectionsAreNotFollowed) {
  const DrippingServer other("HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n");
  const DrippingServer server(absl::StrCat(
      "HTTP/1.1 307 Go\r\nContent-Length: 0\r\nLocation: ", other.url(),
      "\r\n\r\n"));
  const absl::Status status =
      PostJson(server.url(), "{}", "id", std::chrono::seconds(20));
  EXPECT_EQ(status.code(), absl::StatusCode::kUnavailable);
  EXPECT_NE(status.message().find("307"), std::string::npos) << status;
  EXPECT_FALSE(other.is_asked());
}

TEST(PostTest, AnAnswerThatDripsIsLeft) {
  for (const char* const begin :
       {"HTTP/1.1 200 OK\r\nX: ", "HTTP/1.1 500 Busy\r\n\r\n", "H"}) {
    const DrippingServer server(begin);
    const absl::Status status =
        PostJson(server.url(), "{}", "id", std::chrono::milliseconds(200));
    EXPECT_FALSE(status.ok()) << begin;
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!server.is_left() && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(server.is_left()) << begin;
  }
}

}  // namespace
}  // namespace mle::serve
