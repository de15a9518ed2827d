#include "apps/serve/server.h"

#include <httplib.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <limits>
#include <mutex>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/serve/connection.h"

namespace mle::serve {
namespace {

constexpr absl::Duration kLastAnswers = absl::Seconds(5);
constexpr std::size_t kBlock = 65'536;

// Threads, and jobs that wait for one: at most as many; then whoever brings
// another waits himself, and so do those who knock, at the operating system.
class Workers : public httplib::TaskQueue {
 public:
  Workers(int threads, const std::atomic<bool>& stopping)
      : most_(static_cast<std::size_t>(threads)), stopping_(stopping) {
    for (int i = 0; i < threads; ++i) {
      threads_.emplace_back([this] { Work(); });
    }
  }

  void enqueue(std::function<void()> job) override {
    std::unique_lock<std::mutex> lock(mutex_);
    while (jobs_.size() >= most_ && !stopping_) {
      room_.wait_for(lock, std::chrono::milliseconds(100));
    }
    jobs_.push_back(std::move(job));
    lock.unlock();
    work_.notify_one();
  }

  void shutdown() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ended_ = true;
    }
    work_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  // For a thread: a job that a free one only has not woken up for is not.
  bool IsAnyWaiting() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return jobs_.size() > free_;
  }

 private:
  void Work() {
    while (true) {
      std::unique_lock<std::mutex> lock(mutex_);
      ++free_;
      work_.wait(lock, [this] { return ended_ || !jobs_.empty(); });
      --free_;
      if (jobs_.empty()) return;
      const std::function<void()> job = std::move(jobs_.front());
      jobs_.pop_front();
      lock.unlock();
      room_.notify_one();
      job();
    }
  }

  const std::size_t most_;
  const std::atomic<bool>& stopping_;
  std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable room_;
  std::deque<std::function<void()>> jobs_;
  std::size_t free_ = 0;  // threads without a job
  std::vector<std::thread> threads_;
  bool ended_ = false;
};

// What the library reads of a request, which is nothing of the client's, and
// where its answer goes.
class AnswerStream : public httplib::Stream {
 public:
  AnswerStream(const Connection& connection, bool is_head, bool keep_alive,
               absl::Duration time)
      : connection_(connection),
        head_(absl::StrCat(is_head ? "HEAD" : "GET", " / HTTP/1.1\r\n",
                           keep_alive ? "" : "Connection: close\r\n", "\r\n")),
        deadline_(absl::Now() + time) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override { return !broken_; }
  ssize_t read(char* bytes, std::size_t size) override {
    const std::size_t count = head_.copy(bytes, size, at_);
    at_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* bytes, std::size_t size) override {
    broken_ = broken_ || !connection_.Write({bytes, size}, deadline_);
    return broken_ ? -1 : static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    ip.clear();
    port = 0;
  }
  socket_t socket() const override { return 0; }

  bool broken() const { return broken_; }

 private:
  const Connection& connection_;
  const std::string head_;
  const absl::Time deadline_;
  std::size_t at_ = 0;
  bool broken_ = false;
};

bool SendFile(int file, std::size_t offset, std::size_t bytes,
              httplib::DataSink& sink) {
  std::string block(std::min(bytes, kBlock), '\0');
  const ssize_t count =
      pread(file, block.data(), block.size(), static_cast<off_t>(offset));
  return count > 0 && sink.write(block.data(), static_cast<std::size_t>(count));
}

void Fill(const Response& response, httplib::Response& out) {
  out.status = response.status;
  for (const auto& [name, value] : response.headers) {
    out.headers.erase(name);
    out.set_header(name, value);
  }
  if (response.file != nullptr && response.file_bytes > 0) {
    const std::shared_ptr<const int> file = response.file;
    out.set_content_provider(
        response.file_bytes, response.content_type,
        [file](std::size_t offset, std::size_t bytes, httplib::DataSink& sink) {
          return SendFile(*file, offset, bytes, sink);
        });
  } else if (response.body != nullptr && !response.body->empty()) {
    const std::shared_ptr<const std::string> body = response.body;
    out.set_content_provider(
        body->size(), response.content_type,
        [body](std::size_t offset, std::size_t bytes, httplib::DataSink& sink) {
          return sink.write(body->data() + offset, bytes);
        });
  }
}

// The answer of the connection that a thread is at.
thread_local const Response* t_response = nullptr;

class HttplibServer : public httplib::Server, public Server {
 public:
  HttplibServer(const ServerOptions& options, serve::Handler handler)
      : options_(options), handler_(std::move(handler)) {
    set_tcp_nodelay(true);
    // The library's own let other programs of the user listen, too.
    set_socket_options([](socket_t socket) {
      const int on = 1;
      setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on));
    });
    set_keep_alive_timeout(absl::ToInt64Seconds(options_.idle_time));
    set_keep_alive_max_count(std::numeric_limits<int>::max());
    // The library's owner deletes it.
    new_task_queue = [this] {
      auto workers = std::make_unique<Workers>(options_.connections, stopping_);
      workers_ = workers.get();
      return workers.release();
    };
    set_pre_routing_handler(
        [](const httplib::Request&, httplib::Response& out) {
          Fill(*t_response, out);
          return HandlerResponse::Handled;
        });
  }
  ~HttplibServer() override { HttplibServer::Stop(); }

  absl::Status Listen() {
    if (!Bind()) {
      return absl::UnavailableError(
          absl::StrCat("cannot listen on ", options_.host, ", port ",
                       options_.port, ": is it in use, or reserved?"));
    }
    // Signals are the main thread's.
    sigset_t stop;
    sigset_t before;
    sigemptyset(&stop);
    sigaddset(&stop, SIGINT);
    sigaddset(&stop, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &stop, &before);
    thread_ = std::thread([this] { Run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return absl::OkStatus();
  }

  int port() const override { return port_; }

  void Stop() override {
    stopping_ = true;
    if (!thread_.joinable()) return;
    const absl::Time end = absl::Now() + kLastAnswers;
    while (busy_ > 0 && absl::Now() < end) {
      absl::SleepFor(absl::Milliseconds(5));
    }
    // The library does not hear it before it listens, and must not hear it
    // twice.
    while (!ended_) {
      if (is_running() && svr_sock_ != INVALID_SOCKET) stop();
      absl::SleepFor(absl::Milliseconds(5));
    }
    thread_.join();
  }

 private:
  bool Bind() {
    if (port_ == 0 && options_.port == 0) {
      port_ = bind_to_any_port(options_.host);
      return port_ > 0;
    }
    if (port_ == 0) port_ = options_.port;
    return bind_to_port(options_.host, port_);
  }

  // A connection that was given up before it was accepted ends the library's
  // loop: it listens anew.
  void Run() {
    // At least once, so that what was bound is closed.
    do {
      listen_after_bind();
      while (!stopping_ && !Bind()) absl::SleepFor(absl::Milliseconds(100));
    } while (!stopping_);
    ended_ = true;
  }

  bool process_and_close_socket(socket_t socket) override {
    Serve(socket);
    close(socket);
    return true;
  }

  void Serve(int socket) {
    Connection connection(
        socket, [this] { return workers_->IsAnyWaiting(); },
        [this] { return stopping_.load(); });
    const Connection::Limits limits = {.idle = options_.idle_time,
                                       .request = options_.request_time,
                                       .hurry = options_.hurry};
    while (true) {
      ParsedHead head;
      const Connection::Reading reading = connection.Read(limits, head);
      if (reading == Connection::Reading::kEnd) return;
      const bool is_fault = reading == Connection::Reading::kFault;
      ++busy_;
      const Response response = is_fault
                                    ? PlainResponse(head.status, head.fault)
                                    : handler_(head.request);
      const bool keep_alive =
          !is_fault && head.request.keep_alive && !stopping_;
      const bool sent = Answer(connection, response,
                               head.request.method == "HEAD", keep_alive);
      if (!keep_alive && sent) connection.Finish();
      --busy_;
      if (!keep_alive || !sent) return;
    }
  }

  bool Answer(const Connection& connection, const Response& response,
              bool is_head, bool keep_alive) {
    AnswerStream stream(connection, is_head, keep_alive,
                        options_.response_time);
    bool closed = false;
    t_response = &response;
    const bool whole = process_request(stream, !keep_alive, closed, nullptr);
    t_response = nullptr;
    return whole && !stream.broken();
  }

  const ServerOptions options_;
  const serve::Handler handler_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> ended_{false};
  std::atomic<int> busy_{0};
  Workers* workers_ = nullptr;  // the library's
  std::thread thread_;
  int port_ = 0;
};

}  // namespace

Response PlainResponse(int status, absl::string_view text) {
  return {.status = status,
          .body = std::make_shared<std::string>(absl::StrCat(text, "\n"))};
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(
    const ServerOptions& options, Handler handler) {
  auto server = std::make_unique<HttplibServer>(options, std::move(handler));
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
