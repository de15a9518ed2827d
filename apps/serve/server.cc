#include "apps/serve/server.h"

#include <arpa/inet.h>
#include <microhttpd.h>
#include <netdb.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/serve/peers.h"

namespace mle::serve {
namespace {

constexpr int kThreads = 8;
constexpr int kOtherFiles = 256;
// More than there are connections: who is turned away tries again after 1 s.
constexpr int kBacklog = 4096;
constexpr std::chrono::seconds kLastAnswers(4);
// A head, what is known of its headers, and the head of the answer.
constexpr std::size_t kPool = 2 * kMostHead + 4096;
// Bytes of an answer that the system buffers until the client reads them.
constexpr int kSendBuffer = 65'536;

// A request on its way.
struct Exchange {
  std::string target = {};
  bool has_head = false;
  Request request = {};
};

Exchange* Of(void* pointer) { return static_cast<Exchange*>(pointer); }

Peers::Peer* PeerOf(MHD_Connection* connection) {
  return static_cast<Peers::Peer*>(
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)
          ->socket_context);
}

MHD_Result AddHeader(void* head, MHD_ValueKind /*kind*/, const char* name,
                     std::size_t name_size, const char* value,
                     std::size_t value_size) {
  static_cast<Head*>(head)->headers.push_back(
      {{name, name_size}, {value, value_size}});
  return MHD_YES;
}

// The library takes heads for good that other programs may read in another way:
// lines that end in a line feed alone or are folded, blanks in the request
// line, bytes after a NUL. It reads heads where they lie, so that what is
// between their parts can be seen: one blank, or the end of a line.
bool IsPlain(const Head& head, std::size_t size) {
  constexpr std::size_t kLineEnd = 2;  // bytes
  const auto end = [](absl::string_view part) {
    return part.data() + part.size();
  };
  if (head.target.data() != end(head.method) + 1 ||
      head.version.data() != end(head.target) + 1) {
    return false;
  }
  const char* at = end(head.version);
  for (const auto& [name, value] : head.headers) {
    if (name.data() != at + kLineEnd) return false;
    at = end(value);
  }
  return head.method.data() + size == at + 2 * kLineEnd;
}

// Nothing of targets is decoded by the library.
std::size_t LeaveAsItIs(void* /*of*/, MHD_Connection* /*connection*/,
                        char* text) {
  return std::char_traits<char>::length(text);
}

void Release(void* body) {
  delete static_cast<std::shared_ptr<const std::string>*>(body);
}

MHD_Response* MakeResponse(const Response& from, bool is_last) {
  MHD_Response* response = nullptr;
  if (from.file != nullptr) {
    const int file = dup(*from.file);  // closed with the response
    response = MHD_create_response_from_fd64(from.file_bytes, file);
    if (response == nullptr) close(file);
  } else {
    static const auto* const kNothing = new std::string;
    const std::string& body = from.body == nullptr ? *kNothing : *from.body;
    response = MHD_create_response_from_buffer_with_free_callback_cls(
        body.size(), const_cast<char*>(body.data()), &Release,
        new std::shared_ptr<const std::string>(from.body));
  }
  if (response == nullptr) return nullptr;
  MHD_add_response_header(response, "Content-Type", from.content_type.c_str());
  for (const auto& [name, value] : from.headers) {
    MHD_add_response_header(response, name.c_str(), value.c_str());
  }
  if (is_last) MHD_add_response_header(response, "Connection", "close");
  return response;
}

// As many files as the system allows, if these are needed.
int AllowedConnections(int wanted) {
  rlimit files = {};
  getrlimit(RLIMIT_NOFILE, &files);
  const auto needed = static_cast<rlim_t>(wanted + kOtherFiles);
  if (files.rlim_cur < needed) {
    files.rlim_cur = std::min(needed, files.rlim_max);
    setrlimit(RLIMIT_NOFILE, &files);
  }
  const auto allowed = static_cast<int>(std::min(files.rlim_cur, needed));
  return std::max(1, std::min(wanted, allowed - kOtherFiles));
}

// −1 where it cannot.
int ListenOn(const std::string& host, int port) {
  addrinfo hints = {};
  hints.ai_flags = AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) !=
      0) {
    return -1;
  }
  int listening = -1;
  for (const addrinfo* at = found; at != nullptr && listening < 0;
       at = at->ai_next) {
    listening = socket(at->ai_family,
                       SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, IPPROTO_TCP);
    const int on = 1;
    setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    setsockopt(listening, SOL_SOCKET, SO_SNDBUF, &kSendBuffer,
               sizeof(kSendBuffer));
    if (bind(listening, at->ai_addr, at->ai_addrlen) != 0 ||
        listen(listening, kBacklog) != 0) {
      close(listening);
      listening = -1;
    }
  }
  freeaddrinfo(found);
  return listening;
}

int PortOf(int socket) {
  sockaddr_in6 address = {};  // the port is where that of version 4 is
  socklen_t size = sizeof(address);
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin6_port);
}

class MicroServer : public Server {
 public:
  MicroServer(const ServerOptions& options, int connections, Handler handler)
      : options_(options),
        connections_(connections),
        handler_(std::move(handler)),
        peers_({.connections = static_cast<std::size_t>(
                    std::max(1, connections - connections / 4)),
                .answer_bytes = options.answer_bytes,
                .request_time = options.request_time,
                .response_time = options.response_time}) {}
  ~MicroServer() override { MicroServer::Stop(); }

  absl::Status Listen() {
    const int listening = ListenOn(options_.host, options_.port);
    if (listening < 0) return NoListening();
    port_ = PortOf(listening);
    // Signals are the main thread's.
    sigset_t stop;
    sigset_t before;
    sigemptyset(&stop);
    sigaddset(&stop, SIGINT);
    sigaddset(&stop, SIGTERM);
    sigaddset(&stop, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &stop, &before);
    daemon_ = StartDaemon(listening);
    if (daemon_ != nullptr) watch_ = std::thread([this] { Watch(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    if (daemon_ != nullptr) return absl::OkStatus();
    close(listening);
    return NoListening();
  }

  int port() const override { return port_; }

  void Stop() override {
    if (daemon_ == nullptr) return;
    stopping_ = true;  // Accept() takes nobody any more
    const Peers::Clock::time_point end = Peers::Clock::now() + kLastAnswers;
    while (peers_.IsAnyAnswered() && Peers::Clock::now() < end) {
      absl::SleepFor(absl::Milliseconds(5));
    }
    MHD_stop_daemon(daemon_);
    daemon_ = nullptr;
    watch_.join();
  }

 private:
  absl::Status NoListening() const {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", options_.host, ", port ",
                     options_.port, ": is it in use, or reserved?"));
  }

  MHD_Daemon* StartDaemon(int listening) {
    const auto connections = static_cast<unsigned>(connections_);
    // With poll() each thread looks at all that its connections have sent at
    // every event.
    return MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_ITC, 0, &Accept, this, &Answer,
        this, MHD_OPTION_LISTEN_SOCKET, listening, MHD_OPTION_THREAD_POOL_SIZE,
        std::min<unsigned>(kThreads, connections), MHD_OPTION_CONNECTION_LIMIT,
        connections, MHD_OPTION_PER_IP_CONNECTION_LIMIT,
        connections - connections / 6, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
        kPool, MHD_OPTION_CONNECTION_TIMEOUT,
        static_cast<unsigned>(absl::ToInt64Seconds(
            absl::Ceil(options_.stall_time, absl::Seconds(1)))),
        MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_URI_LOG_CALLBACK, &Begin,
        nullptr, MHD_OPTION_UNESCAPE_CALLBACK, &LeaveAsItIs, nullptr,
        MHD_OPTION_NOTIFY_CONNECTION, &NotifyConnection, this,
        MHD_OPTION_NOTIFY_COMPLETED, &NotifyCompleted, this, MHD_OPTION_END);
  }

  void Watch() {
    while (!stopping_) {
      peers_.CutLate();
      absl::SleepFor(absl::Milliseconds(50));
    }
  }

  // The library's own way to take no more connections, MHD_quiesce_daemon(),
  // removes the socket from a thread's epoll set at the same time as that
  // thread may, and ends the program where both do.
  static MHD_Result Accept(void* server, const sockaddr* /*address*/,
                           socklen_t /*size*/) {
    return static_cast<MicroServer*>(server)->stopping_ ? MHD_NO : MHD_YES;
  }

  static void NotifyConnection(void* server, MHD_Connection* connection,
                               void** peer,
                               MHD_ConnectionNotificationCode code) {
    Peers& peers = static_cast<MicroServer*>(server)->peers_;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
      *peer = peers.Add(
          MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)
              ->connect_fd);
    } else {
      peers.Remove(static_cast<Peers::Peer*>(*peer));
    }
  }

  static void* Begin(void* /*of*/, const char* target,
                     MHD_Connection* /*connection*/) {
    return new Exchange{.target = target == nullptr ? "" : target};
  }

  static void NotifyCompleted(void* server, MHD_Connection* connection,
                              void** exchange,
                              MHD_RequestTerminationCode /*code*/) {
    delete Of(*exchange);
    *exchange = nullptr;
    static_cast<MicroServer*>(server)->peers_.EndAnswer(PeerOf(connection));
  }

  // Called with the head, then with each part of a body, then at the end.
  static MHD_Result Answer(void* server, MHD_Connection* connection,
                           const char* target, const char* method,
                           const char* version, const char* body,
                           std::size_t* body_bytes, void** context) {
    auto& self = *static_cast<MicroServer*>(server);
    Exchange& exchange = *Of(*context);
    if (!exchange.has_head) {
      exchange.has_head = true;
      Head head = {.method = method,
                   .target = {target, exchange.target.size()},
                   .version = version,
                   .headers = {}};
      MHD_get_connection_values_n(connection, MHD_HEADER_KIND, &AddHeader,
                                  &head);
      ParsedHead parsed = Read(connection, head, exchange.target);
      if (parsed.status != 200) {
        return self.Send(connection, PlainResponse(parsed.status, parsed.fault),
                         true);
      }
      exchange.request = std::move(parsed.request);
      return MHD_YES;
    }
    if (*body_bytes > 0) {
      exchange.request.body.reserve(exchange.request.body_bytes);
      exchange.request.body.append(body, *body_bytes);
      *body_bytes = 0;
      return MHD_YES;
    }
    self.peers_.BeginAnswer(PeerOf(connection));
    const Response answer = self.handler_(exchange.request);
    return self.Send(connection, answer, self.stopping_);
  }

  static ParsedHead Read(MHD_Connection* connection, Head& head,
                         const std::string& target) {
    const std::size_t size =
        MHD_get_connection_info(connection,
                                MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE)
            ->header_size;
    if (size > kMostHead) {
      return {.status = 431, .fault = "The head of the request is too long."};
    }
    if (!IsPlain(head, size)) {
      return {.status = 400, .fault = "The head of the request is malformed."};
    }
    head.target = target;
    return ParseHead(head);
  }

  MHD_Result Send(MHD_Connection* connection, const Response& answer,
                  bool is_last) {
    MHD_Response* const response = MakeResponse(answer, is_last);
    if (response == nullptr) return MHD_NO;
    peers_.SendAnswer(PeerOf(connection), answer.body.get());
    const MHD_Result queued = MHD_queue_response(
        connection, static_cast<unsigned>(answer.status), response);
    MHD_destroy_response(response);
    return queued;
  }

  const ServerOptions options_;
  const int connections_;
  const Handler handler_;
  Peers peers_;
  std::atomic<bool> stopping_{false};
  MHD_Daemon* daemon_ = nullptr;
  std::thread watch_;
  int port_ = 0;
};

}  // namespace

Response PlainResponse(int status, absl::string_view text) {
  return {.status = status,
          .body = std::make_shared<std::string>(absl::StrCat(text, "\n"))};
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(
    const ServerOptions& options, Handler handler) {
  auto server = std::make_unique<MicroServer>(
      options, AllowedConnections(options.connections), std::move(handler));
  if (const absl::Status status = server->Listen(); !status.ok()) {
    return status;
  }
  return server;
}

absl::StatusOr<ServerOptions> ParseAddress(absl::string_view address) {
  ServerOptions options;
  absl::string_view port = address;
  const std::size_t colon = address.rfind(':');
  if (colon != absl::string_view::npos) {
    absl::string_view host = address.substr(0, colon);
    port = address.substr(colon + 1);
    if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
      host = host.substr(1, host.size() - 2);
    } else if (absl::StrContains(host, ':')) {
      host = "";
    }
    options.host = std::string(host);
  }
  unsigned char bytes[sizeof(in6_addr)];
  const bool is_host = options.host == "localhost" ||
                       inet_pton(AF_INET, options.host.c_str(), bytes) == 1 ||
                       inet_pton(AF_INET6, options.host.c_str(), bytes) == 1;
  if (!is_host || !absl::SimpleAtoi(port, &options.port) || options.port < 0 ||
      options.port > kMostPort) {
    return absl::InvalidArgumentError(
        "is not an address in numbers with a port, as 127.0.0.1:8080, "
        "[::1]:8080, localhost:8080 or 8080");
  }
  return options;
}

bool IsLoopback(absl::string_view host) {
  return host == "localhost" || host == "::1" || absl::StartsWith(host, "127.");
}

}  // namespace mle::serve
