// An HTTP/1.1 server for a few users, that keeps what it uses within bounds:
// connections, threads, bytes of a request, time to send a request and to take
// an answer.
//
//   MLE_ASSIGN_OR_RETURN(
//       const std::unique_ptr<Server> server,
//       Server::Start({.port = 8080}, [](const Request& request) {
//         return Response{.body = std::make_shared<std::string>("Hello")};
//       }));
//   …
//   server->Stop();
//
// Requests are read by ParseHead(); the library beneath (cpp-httplib) listens,
// keeps the threads and writes the answers.

#ifndef APPS_SERVE_SERVER_H_
#define APPS_SERVE_SERVER_H_

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "apps/serve/request.h"

namespace mle::serve {

struct Response {
  int status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  // Shared by all who are sent it; null: empty.
  std::shared_ptr<const std::string> body = nullptr;
  // Open for reading, in place of `body`: its first `file_bytes` are sent.
  std::shared_ptr<const int> file = nullptr;
  std::size_t file_bytes = 0;
  std::vector<std::pair<std::string, std::string>> headers = {};
};

// A line of plain text.
Response PlainResponse(int status, absl::string_view text);

struct ServerOptions {
  std::string host = "127.0.0.1";  // an address in numbers, or "localhost"
  int port = 0;                    // 0: any
  // Served at a time, each by a thread; as many again may wait.
  int connections = 64;
  // Of all of a request, of all of an answer, and between requests. While
  // others wait, a request has `hurry` and no connection rests.
  absl::Duration request_time = absl::Seconds(10);
  absl::Duration response_time = absl::Seconds(60);
  absl::Duration idle_time = absl::Seconds(15);
  absl::Duration hurry = absl::Seconds(2);
};

// Called by many threads at once; must not throw.
using Handler = std::function<Response(const Request&)>;

class Server {
 public:
  // Unavailable where it cannot listen.
  static absl::StatusOr<std::unique_ptr<Server>> Start(
      const ServerOptions& options, Handler handler);

  virtual ~Server() = default;
  virtual int port() const = 0;
  // Answers what has been asked, closes all connections and ends the threads.
  virtual void Stop() = 0;
};

// "127.0.0.1:8080", "[::1]:8080", "localhost:8080" or a port alone.
// InvalidArgument for anything else.
absl::StatusOr<ServerOptions> ParseAddress(absl::string_view address);

// Whether only programs on this machine can reach it.
bool IsLoopback(absl::string_view host);

}  // namespace mle::serve

#endif  // APPS_SERVE_SERVER_H_
