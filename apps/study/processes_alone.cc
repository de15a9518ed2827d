// Processes where there is but one.

#include <string>

#include "apps/study/processes.h"

namespace mle::study {
namespace {

class Alone : public Processes {
 public:
  int rank() const override { return 0; }
  int count() const override { return 1; }
  int on_this_machine() const override { return 1; }
  std::optional<std::string> Broadcast(
      const std::optional<std::string>& text) override {
    return text;
  }
  void Assign(int, const Assignment&) override {}
  void Dismiss(int, bool) override {}
  std::vector<Report> Receive() override { return {}; }
  void Send(const Report&) override {}
  Order TakeOrder() override { return {Order::Kind::kNoMore, {}}; }
};

}  // namespace

std::unique_ptr<Processes> OneProcess() { return std::make_unique<Alone>(); }

}  // namespace mle::study
