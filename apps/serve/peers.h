// Who is connected, and since when: who takes too long is cut off, and where
// room is short, who has taken longest.
//
// A peer waits (from its connection or the end of its last answer until its
// next request is whole) or is being answered.

#ifndef APPS_SERVE_PEERS_H_
#define APPS_SERVE_PEERS_H_

#include <cstddef>
#include <list>
#include <map>
#include <mutex>
#include <string>

#include "absl/time/clock.h"
#include "absl/time/time.h"

namespace mle::serve {

class Peers {
 public:
  struct Limits {
    std::size_t connections;   // beyond which the longest is cut off
    std::size_t answer_bytes;  // in memory, of all that are being sent
    absl::Duration request_time, response_time;
  };
  struct Peer {
    int socket;
    absl::Time since;
    const std::string* body;  // that is being sent, or null
    std::list<Peer>* list;    // it is in
    std::list<Peer>::iterator self;
  };

  explicit Peers(const Limits& limits) : limits_(limits) {}

  // The socket stays open until Remove().
  Peer* Add(int socket);
  void Remove(Peer* peer);
  void BeginAnswer(Peer* peer, const std::string* body);
  void EndAnswer(Peer* peer);

  void CutLate();
  bool IsAnyAnswered();

 private:
  // With mutex_ held.
  void Move(Peer& peer, std::list<Peer>& list);
  void Release(Peer& peer);
  void Cut(Peer& peer);

  const Limits limits_;
  std::mutex mutex_;                    // of what follows
  std::list<Peer> waiting_, answered_;  // the longest first
  std::list<Peer> cut_;                 // shut down, but not yet removed
  struct Held {
    std::size_t bytes;
    int by;  // so many
  };
  std::map<const std::string*, Held> bodies_;
  std::size_t held_ = 0;  // bytes of all bodies
};

}  // namespace mle::serve

#endif  // APPS_SERVE_PEERS_H_
