#include "tests/apps/serve/client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "absl/strings/str_cat.h"

namespace mle::serve {
namespace {

constexpr int kPatience = 10'000;  // ms

bool IsReadable(int socket) {
  pollfd waited = {.fd = socket, .events = POLLIN, .revents = 0};
  return poll(&waited, 1, kPatience) > 0;
}

std::size_t LengthOf(const std::string& head) {
  constexpr absl::string_view kName = "Content-Length: ";
  const std::size_t at = head.find(kName.data());
  return at == std::string::npos
             ? 0
             : std::strtoul(head.c_str() + at + kName.size(), nullptr, 10);
}

}  // namespace

Client::Client(int port) : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  connected_ = connect(socket_, reinterpret_cast<const sockaddr*>(&address),
                       sizeof(address)) == 0;
}

Client::~Client() { close(socket_); }

bool Client::Send(absl::string_view bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent =
        send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool Client::HasBytes() const { return IsReadable(socket_); }

std::string Client::Answer() {
  std::array<char, 65'536> bytes;
  while (true) {
    const std::size_t end = read_.find("\r\n\r\n");
    if (end != std::string::npos) {
      const std::size_t whole = end + 4 + LengthOf(read_.substr(0, end + 2));
      if (read_.size() >= whole) {
        std::string answer = read_.substr(0, whole);
        read_.erase(0, whole);
        return answer;
      }
    }
    const ssize_t count =
        IsReadable(socket_) ? recv(socket_, bytes.data(), bytes.size(), 0) : 0;
    if (count <= 0) return std::exchange(read_, "");
    read_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

bool Client::IsClosed() {
  std::array<char, 65'536> bytes;
  while (IsReadable(socket_)) {
    if (recv(socket_, bytes.data(), bytes.size(), 0) <= 0) return true;
  }
  return false;
}

std::string Get(const std::string& path, const std::string& headers) {
  return absl::StrCat("GET ", path, " HTTP/1.1\r\nHost: localhost\r\n", headers,
                      "\r\n");
}

std::string Ask(int port, const std::string& request) {
  Client client(port);
  client.Send(request);
  return client.Answer();
}

int StatusOf(const std::string& answer) {
  return answer.size() < 12 ? 0 : std::atoi(answer.c_str() + 9);
}

std::string BodyOf(const std::string& answer) {
  const std::size_t end = answer.find("\r\n\r\n");
  return end == std::string::npos ? "" : answer.substr(end + 4);
}

}  // namespace mle::serve
