#include "apps/serve/connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <utility>

#include "absl/time/clock.h"

namespace mle::serve {
namespace {

// How often a wait looks whether it is still wanted.
constexpr absl::Duration kSlice = absl::Milliseconds(100);
constexpr absl::Duration kFarewell = absl::Milliseconds(300);
constexpr std::size_t kFarewellBytes = 65'536;
constexpr std::string_view kHeadEnd = "\r\n\r\n";

// Whether the socket is ready, waiting for that at most `wait`.
bool IsReady(int socket, short events, absl::Duration wait) {
  pollfd waited = {.fd = socket, .events = events, .revents = 0};
  const auto milliseconds = static_cast<int>(
      std::clamp<std::int64_t>(absl::ToInt64Milliseconds(wait), 0, 60'000));
  return poll(&waited, 1, milliseconds) > 0;
}

}  // namespace

Connection::Connection(int socket, std::function<bool()> is_needed,
                       std::function<bool()> is_stopping)
    : socket_(socket),
      is_needed_(std::move(is_needed)),
      is_stopping_(std::move(is_stopping)) {}

Connection::Arrival Connection::Receive(absl::Duration wait) {
  if (!IsReady(socket_, POLLIN, wait)) return Arrival::kNothing;
  std::array<char, 4096> bytes;
  const ssize_t count = recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
  if (count > 0) {
    read_.append(bytes.data(), static_cast<std::size_t>(count));
    return Arrival::kBytes;
  }
  const bool again = count < 0 && (errno == EAGAIN || errno == EINTR);
  return again ? Arrival::kNothing : Arrival::kClosed;
}

bool Connection::IsLate(absl::Time begin, const Limits& limits) const {
  const absl::Duration since = absl::Now() - begin;
  return since > limits.request ||
         (since > limits.hurry && (is_needed_() || is_stopping_()));
}

Connection::Reading Connection::Read(const Limits& limits, ParsedHead& head) {
  const absl::Time idle_since = absl::Now();
  while (read_.empty()) {
    // A request that is on its way already is taken.
    const Arrival arrival = Receive(kSlice);
    if (arrival == Arrival::kClosed) return Reading::kEnd;
    if (arrival == Arrival::kNothing &&
        (is_stopping_() || is_needed_() ||
         absl::Now() - idle_since > limits.idle)) {
      return Reading::kEnd;
    }
  }
  const absl::Time begin = absl::Now();
  std::size_t end = read_.find(kHeadEnd);
  while (end == std::string::npos && read_.size() <= kMostHead) {
    if (IsLate(begin, limits)) {
      head = {.status = 408, .fault = "The request took too long to arrive."};
      return Reading::kFault;
    }
    const std::size_t sought = read_.size();
    if (Receive(kSlice) == Arrival::kClosed) return Reading::kEnd;
    end = read_.find(kHeadEnd, sought < 3 ? 0 : sought - 3);
  }
  // Also one that has not ended.
  if (end > kMostHead - kHeadEnd.size()) {
    head = {.status = 431, .fault = "The head of the request is too long."};
    return Reading::kFault;
  }
  head = ParseHead(absl::string_view(read_.data(), end + kHeadEnd.size()));
  read_.erase(0, end + kHeadEnd.size());
  return head.status == 200 ? ReadBody(begin, limits, head) : Reading::kFault;
}

Connection::Reading Connection::ReadBody(absl::Time begin, const Limits& limits,
                                         ParsedHead& head) {
  const std::size_t length = head.request.body_bytes;
  while (read_.size() < length) {
    if (IsLate(begin, limits)) {
      head = {.status = 408, .fault = "The request took too long to arrive."};
      return Reading::kFault;
    }
    if (Receive(kSlice) == Arrival::kClosed) return Reading::kEnd;
  }
  head.request.body = read_.substr(0, length);
  read_.erase(0, length);
  return Reading::kRequest;
}

bool Connection::Write(absl::string_view bytes, absl::Time deadline) const {
  while (!bytes.empty()) {
    const ssize_t sent =
        send(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (sent == 0 || (errno != EAGAIN && errno != EINTR) ||
               absl::Now() > deadline) {
      return false;
    } else {
      IsReady(socket_, POLLOUT, kSlice);
    }
    // One that takes a byte now and then is late, too.
    if (!bytes.empty() && absl::Now() > deadline) return false;
  }
  return true;
}

void Connection::Finish() const {
  shutdown(socket_, SHUT_WR);
  const absl::Time end = absl::Now() + kFarewell;
  std::array<char, 4096> ignored;
  std::size_t taken = 0;
  while (taken < kFarewellBytes && absl::Now() < end) {
    if (!IsReady(socket_, POLLIN, end - absl::Now())) return;
    const ssize_t count =
        recv(socket_, ignored.data(), ignored.size(), MSG_DONTWAIT);
    if (count <= 0) return;
    taken += static_cast<std::size_t>(count);
  }
}

}  // namespace mle::serve
