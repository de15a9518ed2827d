// Who is connected, and since when: who takes too long is cut off, and where
// room is short, who has taken longest.
//
// A peer waits (from its connection or the end of its last answer until its
// next request is whole), then its answer is made, which is never its fault,
// and sent.

#ifndef APPS_SERVE_PEERS_H_
#define APPS_SERVE_PEERS_H_

#include <chrono>
#include <cstddef>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <utility>

#include "absl/time/time.h"

namespace mle::serve {

// Bytes of an answer that is no reason to cut off who takes it: it is sent at
// once to all who read, and of all others there are few enough.
inline constexpr std::size_t kSmallAnswer = 16'384;

class Peers {
 public:
  // Not the time of day, which may be set.
  using Clock = std::chrono::steady_clock;

  struct Limits {
    std::size_t connections;   // beyond which the longest is cut off
    std::size_t answer_bytes;  // in memory, of all large ones being sent
    absl::Duration request_time, response_time;
  };
  struct Peer {
    int socket;
    Clock::time_point since;
    const std::string* body;  // a large one that is being sent, or null
    std::list<Peer>* list;    // it is in
    std::list<Peer>::iterator self;
  };

  explicit Peers(const Limits& limits,
                 std::function<Clock::time_point()> now = Clock::now)
      : limits_(limits), now_(std::move(now)) {}

  // The socket stays open until Remove().
  Peer* Add(int socket);
  void Remove(Peer* peer);
  // Its request is whole.
  void BeginAnswer(Peer* peer);
  // Its answer has been made; `body` may be null.
  void SendAnswer(Peer* peer, const std::string* body);
  void EndAnswer(Peer* peer);

  void CutLate();
  // Whether an answer is being made or sent.
  bool IsAnyAnswered();

 private:
  // With mutex_ held.
  bool IsOlder(const Peer& peer, absl::Duration time) const {
    return absl::FromChrono(now_() - peer.since) > time;
  }
  void Move(Peer& peer, std::list<Peer>& list);
  void Release(Peer& peer);
  void Cut(Peer& peer);
  void CutForMemory(const Peer& newest);

  const Limits limits_;
  const std::function<Clock::time_point()> now_;
  std::mutex mutex_;                                   // of what follows
  std::list<Peer> waiting_, being_made_, being_sent_;  // the longest first
  std::list<Peer> cut_;  // shut down, but not yet removed
  struct Held {
    std::size_t bytes;
    int by;  // so many
  };
  std::map<const std::string*, Held> bodies_;
  std::size_t held_ = 0;  // bytes of all bodies
};

}  // namespace mle::serve

#endif  // APPS_SERVE_PEERS_H_
