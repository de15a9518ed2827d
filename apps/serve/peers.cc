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
                      .since = absl::Now(),
                      .body = nullptr,
                      .list = &waiting_,
                      .self = {}});
  Peer& peer = waiting_.back();
  peer.self = std::prev(waiting_.end());
  if (waiting_.size() + answered_.size() <= limits_.connections) return &peer;
  if (waiting_.size() > 1) {
    Cut(waiting_.front());
  } else if (!answered_.empty() &&
             peer.since - answered_.front().since > kLeastAnswer) {
    Cut(answered_.front());
  }
  return &peer;
}

void Peers::Remove(Peer* peer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Release(*peer);
  peer->list->erase(peer->self);
}

void Peers::BeginAnswer(Peer* peer, const std::string* body) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (peer->list == &cut_) return;
  Move(*peer, answered_);
  peer->body = body;
  if (body != nullptr) {
    Held& held = bodies_.try_emplace(body, Held{body->size(), 0}).first->second;
    if (++held.by == 1) held_ += held.bytes;
  }
  while (held_ > limits_.answer_bytes && answered_.size() > 1) {
    Cut(answered_.front());
  }
}

void Peers::EndAnswer(Peer* peer) {
  const std::lock_guard<std::mutex> lock(mutex_);
  Release(*peer);
  if (peer->list != &cut_) Move(*peer, waiting_);
}

void Peers::CutLate() {
  const std::lock_guard<std::mutex> lock(mutex_);
  const absl::Time now = absl::Now();
  while (!waiting_.empty() &&
         now - waiting_.front().since > limits_.request_time) {
    Cut(waiting_.front());
  }
  while (!answered_.empty() &&
         now - answered_.front().since > limits_.response_time) {
    Cut(answered_.front());
  }
}

bool Peers::IsAnyAnswered() {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !answered_.empty();
}

void Peers::Move(Peer& peer, std::list<Peer>& list) {
  list.splice(list.end(), *peer.list, peer.self);
  peer.list = &list;
  peer.since = absl::Now();
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

}  // namespace mle::serve
