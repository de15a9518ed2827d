#include "apps/serve/peers.h"

#include <sys/socket.h>

namespace mle::serve {
namespace {

// An answer is not cut off for want of room before.
constexpr absl::Duration kLeastAnswer = absl::Seconds(2);

}  // namespace

Peers::Peer* Peers::Add(int socket) {
  const std::lock_guard<std::mutex> lock(mutex_);
  waiting_.push_back({.socket = socket,
                      .since = now_(),
                      .body = nullptr,
                      .list = &waiting_,
                      .self = {}});
  Peer& peer = waiting_.back();
  peer.self = std::prev(waiting_.end());
  if (waiting_.size() + being_made_.size() + being_sent_.size() <=
      limits_.connections) {
    return &peer;
  }
  if (waiting_.size() > 1) {
    Cut(waiting_.front());
  } else if (!being_sent_.empty() &&
             IsOlder(being_sent_.front(), kLeastAnswer)) {
    Cut(being_sent_.front());
  }
  return &peer;
}

void Peers::Remove(Peer* peer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Release(*peer);
  peer->list->erase(peer->self);
}

void Peers::BeginAnswer(Peer* peer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (peer->list != &cut_) Move(*peer, being_made_);
}

void Peers::SendAnswer(Peer* peer, const std::string* body) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (peer->list == &cut_) return;
  Move(*peer, being_sent_);
  if (body == nullptr || body->size() <= kSmallAnswer) return;
  peer->body = body;
  Held& held = bodies_.try_emplace(body, Held{body->size(), 0}).first->second;
  if (++held.by == 1) held_ += held.bytes;
  CutForMemory(*peer);
}

void Peers::EndAnswer(Peer* peer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Release(*peer);
  if (peer->list != &cut_) Move(*peer, waiting_);
}

void Peers::CutLate() {
  const std::lock_guard<std::mutex> lock(mutex_);
  while (!waiting_.empty() && IsOlder(waiting_.front(), limits_.request_time)) {
    Cut(waiting_.front());
  }
  while (!being_sent_.empty() &&
         IsOlder(being_sent_.front(), limits_.response_time)) {
    Cut(being_sent_.front());
  }
}

bool Peers::IsAnyAnswered() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !being_made_.empty() || !being_sent_.empty();
}

void Peers::Move(Peer& peer, std::list<Peer>& list) {
  list.splice(list.end(), *peer.list, peer.self);
  peer.list = &list;
  peer.since = now_();
}

void Peers::Release(Peer& peer) {
  if (peer.body == nullptr) return;
  const auto body = bodies_.find(peer.body);
  if (--body->second.by == 0) {
    held_ -= body->second.bytes;
    bodies_.erase(body);
  }
  peer.body = nullptr;
}

void Peers::Cut(Peer& peer) {
  shutdown(peer.socket, SHUT_RDWR);
  Release(peer);
  Move(peer, cut_);
}

void Peers::CutForMemory(const Peer& newest) {
  for (auto next = being_sent_.begin();
       held_ > limits_.answer_bytes && next != being_sent_.end();) {
    Peer& peer = *next++;
    if (peer.body != nullptr && &peer != &newest) Cut(peer);
  }
}

}  // namespace mle::serve
