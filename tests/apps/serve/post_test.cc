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

// Answers one request with a line that goes on, a byte now and then, until the
// other end is gone.
class DrippingServer {
 public:
  explicit DrippingServer(const std::string& begin)
      : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
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
    stop_ = true;
    shutdown(socket_, SHUT_RDWR);
    thread_.join();
    close(socket_);
  }
  DrippingServer(const DrippingServer&) = delete;
  DrippingServer& operator=(const DrippingServer&) = delete;

  std::string url() const { return absl::StrCat("http://127.0.0.1:", port_); }
  bool is_left() const { return is_left_; }

 private:
  void Drip(const std::string& begin) {
    const int other = accept(socket_, nullptr, nullptr);
    if (other < 0) return;
    std::string rest = begin;
    while (!stop_ && !is_left_) {
      is_left_ = send(other, rest.data(), rest.size(), MSG_NOSIGNAL) <= 0;
      rest = "a";
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    close(other);
  }

  int socket_;
  int port_ = 0;
  std::atomic<bool> stop_{false};
  std::atomic<bool> is_left_{false};
  std::thread thread_;
};

TEST(PostTest, AnAnswerThatDripsIsLeft) {
  for (const char* const begin :
       {"HTTP/1.1 200 OK\r\nX: ", "HTTP/1.1 500 Busy\r\n\r\n", "H"}) {
    const DrippingServer server(begin);
    const absl::Status status =
        PostJson(server.url(), "{}", "id", std::chrono::milliseconds(200));
    EXPECT_FALSE(status.ok()) << begin;
    const auto deadline =
        std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!server.is_left() && std::chrono::steady_clock::now() < deadline) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_TRUE(server.is_left()) << begin;
  }
}

}  // namespace
}  // namespace mle::serve
