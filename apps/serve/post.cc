#include "apps/serve/post.h"

#include <httplib.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "apps/serve/connection.h"

namespace mle::serve {
namespace {

constexpr int kSeconds = 10;  // for a connection, and for a single read
constexpr std::chrono::milliseconds kAgain(100);
constexpr std::size_t kMostAnswer = 65'536;  // bytes that are read

struct Url {
  std::string origin;  // "https://host:port"
  std::string path;
};

bool IsHost(absl::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' ||
           c == '-' || c == '_';
  });
}

// Empty where it is not such.
Url Split(const std::string& url) {
  const std::size_t scheme = absl::StartsWith(url, "http://")    ? 7
                             : absl::StartsWith(url, "https://") ? 8
                                                                 : 0;
  const bool is_visible = std::all_of(
      url.begin(), url.end(), [](char c) { return c > ' ' && c < '\x7f'; });
  if (scheme == 0 || !is_visible) return {};
  const std::size_t slash = std::min(url.find('/', scheme), url.size());
  const std::string authority = url.substr(scheme, slash - scheme);
  const std::size_t colon = authority.find(':');
  int port = 1;
  if (!IsHost(authority.substr(0, colon)) ||
      (colon != std::string::npos &&
       (!absl::SimpleAtoi(authority.substr(colon + 1), &port) || port < 1 ||
        port > kMostPort))) {
    return {};
  }
  return {url.substr(0, slash), slash == url.size() ? "/" : url.substr(slash)};
}

// Ends what the client is at once a time is over: the library's times are
// those of single reads, which an answer that drips never exceeds.
class Deadline {
 public:
  Deadline(httplib::Client& client, std::chrono::milliseconds time)
      : thread_([this, &client, time] { Watch(client, time); }) {}
  ~Deadline() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      done_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

 private:
  void Watch(httplib::Client& client, std::chrono::milliseconds time) {
    std::unique_lock<std::mutex> lock(mutex_);
    if (changed_.wait_for(lock, time, [this] { return done_; })) return;
    do {  // a connection may be opened after it
      client.stop();
    } while (!changed_.wait_for(lock, kAgain, [this] { return done_; }));
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  bool done_ = false;
  std::thread thread_;
};

// Whether the request may have arrived.
bool MayHaveArrived(httplib::Error error) {
  return error == httplib::Error::Read || error == httplib::Error::Unknown;
}

}  // namespace

absl::Status CheckUrl(const std::string& url) {
  if (!Split(url).origin.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "is not an address as https://host.example:8443/path");
}

absl::Status PostJson(const std::string& url, const std::string& text,
                      const std::string& id, std::chrono::milliseconds time) {
  const Url parts = Split(url);
  if (parts.origin.empty()) return CheckUrl(url);
  httplib::Client client(parts.origin);
  client.set_connection_timeout(kSeconds);
  client.set_read_timeout(kSeconds);
  client.set_write_timeout(kSeconds);
  httplib::Request request;
  request.method = "POST";
  request.path = parts.path;
  request.body = text;
  request.headers = {{"Content-Type", "application/json"},
                     {"Idempotency-Key", id},
                     {"User-Agent", "mle_watch"}};
  // What comes with the status is of no interest.
  int status = 0;
  std::size_t bytes = 0;
  request.response_handler = [&](const httplib::Response& response) {
    status = response.status;
    return true;
  };
  request.content_receiver = [&](const char*, std::size_t count, std::uint64_t,
                                 std::uint64_t) {
    bytes += count;
    return bytes <= kMostAnswer;
  };
  httplib::Response response;
  httplib::Error error = httplib::Error::Success;
  const Deadline deadline(client, time);
  const bool sent = client.send(request, response, error);
  if (sent && status == 0) status = response.status;
  if (status >= 200 && status < 300) return absl::OkStatus();
  if (status != 0) {
    return absl::UnavailableError(
        absl::StrCat("it answered with status ", status));
  }
  if (error == httplib::Error::SSLServerVerification) {
    return absl::UnavailableError(
        "its certificate is of another name, or not one that the system "
        "believes (the environment variable SSL_CERT_FILE names others)");
  }
  const std::string word = httplib::to_string(error);
  return MayHaveArrived(error) ? absl::DeadlineExceededError(
                                     absl::StrCat("no answer came: ", word))
                               : absl::UnavailableError(absl::StrCat(
                                     "it could not be reached: ", word));
}

}  // namespace mle::serve
