// An HTTP/1.1 server for a few users, on libmicrohttpd, that keeps what it uses
// within bounds: connections, memory, bytes of a request, time to send a
// request and to take an answer. Who is too slow is cut off, and where room is
// short, who has waited or taken longest.
//
//   MLE_ASSIGN_OR_RETURN(
//       const std::unique_ptr<Server> server,
//       Server::Start({.port = 8080}, [](const Request& request) {
//         return Response{.body = std::make_shared<std::string>("Hello")};
//       }));
//   …
//   server->Stop();

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
  // At a time; five sixths of them may be of one address, and from three
  // quarters on, who has waited longest is cut off for a new one.
  int connections = 3072;
  // Bytes of all answers that are being sent, each once; beyond, who has taken
  // longest is cut off.
  std::size_t answer_bytes = std::size_t{64} << 20;
  // From a connection or the last answer until the next request is whole; from
  // then until its answer has been taken; without taking any of it.
  absl::Duration request_time = absl::Seconds(15);
  absl::Duration response_time = absl::Seconds(60);
  absl::Duration stall_time = absl::Seconds(15);  // rounded up to seconds
};

// The largest number of a port of TCP.
inline constexpr int kMostPort = 65'535;

// Called by many threads at once; must not throw.
using Handler = std::function<Response(const Request&)>;

class Server {
 public:
  // Unavailable where it cannot listen.
  static absl::StatusOr<std::unique_ptr<Server>> Start(
      const ServerOptions& options, Handler handler);

  virtual ~Server() = default;
  virtual int port() const = 0;
  // Ends answers that have been begun, for some seconds, closes all connections
  // and ends the threads.
  virtual void Stop() = 0;
};

// "127.0.0.1:8080", "[::1]:8080", "localhost:8080" or a port alone.
// InvalidArgument for anything else.
absl::StatusOr<ServerOptions> ParseAddress(absl::string_view address);

// Whether only programs on this machine can reach it.
bool IsLoopback(absl::string_view host);

}  // namespace mle::serve

#endif  // APPS_SERVE_SERVER_H_
