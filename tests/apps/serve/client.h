// A client that sends what no browser would.

#ifndef TESTS_APPS_SERVE_CLIENT_H_
#define TESTS_APPS_SERVE_CLIENT_H_

#include <string>

#include "absl/strings/string_view.h"

namespace mle::serve {

class Client {
 public:
  // To that port of the loopback interface.
  explicit Client(int port);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  bool connected() const { return connected_; }
  // False once the other end is gone.
  bool Send(absl::string_view bytes) const;
  // Waits until there is something to read, ten seconds at most.
  bool HasBytes() const;
  // The next answer with its body, or all until the end of the connection.
  std::string Answer();
  // Whether the other end closes within ten seconds.
  bool IsClosed();

 private:
  int socket_;
  bool connected_ = false;
  std::string read_;
};

// "GET PATH HTTP/1.1" with a Host and further lines, each ending in "\r\n".
std::string Get(const std::string& path, const std::string& headers = "");
// The answer to one request on a connection of its own.
std::string Ask(int port, const std::string& request);
int StatusOf(const std::string& answer);
std::string BodyOf(const std::string& answer);

}  // namespace mle::serve

#endif  // TESTS_APPS_SERVE_CLIENT_H_
