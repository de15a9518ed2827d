#include "apps/serve/peers.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>

#include "absl/time/time.h"
#include "gtest/gtest.h"

namespace mle::serve {
namespace {

// Two ends of a connection.
class Ends {
 public:
  Ends() {
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends_.data()),
              0);
  }
  ~Ends() {
    close(ends_[0]);
    close(ends_[1]);
  }
  Ends(const Ends&) = delete;
  Ends& operator=(const Ends&) = delete;

  int server() const { return ends_[0]; }
  bool IsCut() const {
    char byte = 0;
    return recv(ends_[1], &byte, 1, 0) == 0;
  }

 private:
  std::array<int, 2> ends_ = {};
};

class PeersTest : public ::testing::Test {
 protected:
  Peers Make(std::size_t connections, std::size_t answer_bytes = 1 << 20) {
    return Peers({.connections = connections,
                  .answer_bytes = answer_bytes,
                  .request_time = absl::Seconds(10),
                  .response_time = absl::Seconds(60)},
                 [this] { return now_; });
  }

  Peers::Clock::time_point now_;
};

TEST_F(PeersTest, WhoIsLateIsCutOffButNotWhileItsAnswerIsMade) {
  Peers peers = Make(10);
  const Ends waits;
  const Ends asks;
  peers.Add(waits.server());
  Peers::Peer* const asking = peers.Add(asks.server());
  peers.BeginAnswer(asking);
  now_ += std::chrono::seconds(11);
  peers.CutLate();
  EXPECT_TRUE(waits.IsCut());
  EXPECT_FALSE(asks.IsCut());
  EXPECT_TRUE(peers.IsAnyAnswered());
  peers.SendAnswer(asking, nullptr);
  now_ += std::chrono::seconds(59);
  peers.CutLate();
  EXPECT_FALSE(asks.IsCut());
  peers.EndAnswer(asking);
  EXPECT_FALSE(peers.IsAnyAnswered());
  now_ += std::chrono::seconds(9);
  peers.CutLate();
  EXPECT_FALSE(asks.IsCut());
  now_ += std::chrono::seconds(2);
  peers.CutLate();
  EXPECT_TRUE(asks.IsCut());
}

TEST_F(PeersTest, WhoTakesAnAnswerTooLongIsCutOff) {
  Peers peers = Make(10);
  const Ends ends;
  Peers::Peer* const peer = peers.Add(ends.server());
  peers.BeginAnswer(peer);
  peers.SendAnswer(peer, nullptr);
  now_ += std::chrono::seconds(61);
  peers.CutLate();
  EXPECT_TRUE(ends.IsCut());
  EXPECT_FALSE(peers.IsAnyAnswered());
}

TEST_F(PeersTest, WhoHasWaitedLongestMakesRoom) {
  Peers peers = Make(2);
  const Ends first;
  const Ends second;
  const Ends third;
  peers.Add(first.server());
  peers.Add(second.server());
  EXPECT_FALSE(first.IsCut());
  peers.Add(third.server());
  EXPECT_TRUE(first.IsCut());
  EXPECT_FALSE(second.IsCut());
  EXPECT_FALSE(third.IsCut());
}

TEST_F(PeersTest, LargeAnswersMakeRoomForLargeOnesAndSmallOnesStay) {
  const std::string large_a(600'000, 'a');
  const std::string large_b(600'000, 'b');
  const std::string small(kSmallAnswer, 'c');
  Peers peers = Make(10);
  const Ends a;
  const Ends again;
  const Ends b;
  const Ends s;
  const auto send = [&](const Ends& ends, const std::string& body) {
    Peers::Peer* const peer = peers.Add(ends.server());
    peers.BeginAnswer(peer);
    peers.SendAnswer(peer, &body);
  };
  send(s, small);
  send(a, large_a);
  send(again, large_a);  // which is in memory once
  EXPECT_FALSE(a.IsCut());
  send(b, large_b);
  EXPECT_TRUE(a.IsCut());
  EXPECT_TRUE(again.IsCut());
  EXPECT_FALSE(b.IsCut());
  EXPECT_FALSE(s.IsCut());
}

}  // namespace
}  // namespace mle::serve
