// One connection of a server: bytes in and out, with deadlines.

#ifndef APPS_SERVE_CONNECTION_H_
#define APPS_SERVE_CONNECTION_H_

#include <functional>
#include <string>

#include "absl/strings/string_view.h"
#include "absl/time/time.h"
#include "apps/serve/request.h"

namespace mle::serve {

// The largest number of a port of TCP.
inline constexpr int kMostPort = 65'535;

class Connection {
 public:
  // `is_needed`: whether others wait for a connection; `is_stopping`: whether
  // the server wants to end. The socket stays the caller's.
  Connection(int socket, std::function<bool()> is_needed,
             std::function<bool()> is_stopping);

  enum class Reading {
    kRequest,
    kFault,  // a request that is refused, with the status in `head`
    kEnd,    // closed, too slow to answer, or not wanted any more
  };
  struct Limits {
    absl::Duration idle, request, hurry;
  };
  // The next request with its body.
  Reading Read(const Limits& limits, ParsedHead& head);

  // All of it, or false once the deadline has passed or the other end is gone.
  bool Write(absl::string_view bytes, absl::Time deadline) const;

  // Says that nothing more comes, and takes what the other end still sends, so
  // that an answer to a request not read whole is not lost.
  void Finish() const;

 private:
  // Waits for bytes and adds them to read_; false at the deadline or the end.
  enum class Arrival { kBytes, kNothing, kClosed };
  Arrival Receive(absl::Duration wait);
  Reading ReadBody(absl::Time begin, const Limits& limits, ParsedHead& head);
  bool IsLate(absl::Time begin, const Limits& limits) const;

  int socket_;
  std::function<bool()> is_needed_;
  std::function<bool()> is_stopping_;
  std::string read_;  // not yet used; at most kMostHead + kMostBody
};

}  // namespace mle::serve

#endif  // APPS_SERVE_CONNECTION_H_
