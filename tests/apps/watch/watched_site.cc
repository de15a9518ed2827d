#include "tests/apps/watch/watched_site.h"

#include <filesystem>

#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

constexpr int kFirstDay = 20'500;  // 2026-02-16

std::string TankJson() {
  return nlohmann::json({{"name", "tank"},
                         {"time_unit", "min"},
                         {"inputs", {{{"name", "steam"}, {"unit", ""}}}},
                         {"outputs", {{{"name", kHostileTag}, {"unit", ""}}}},
                         {"elements",
                          {{{"output", kHostileTag},
                            {"input", "steam"},
                            {"gain", 2.0},
                            {"time_constant", 20.0},
                            {"delay", 10.0}}}}})
      .dump();
}

}  // namespace

WatchedSite::WatchedSite() {
  std::filesystem::create_directories(folder_ / "proposals/b/2026-01-01");
  folder_.Write("proposals/b/2026-01-01/report.html", "<p>r</p>");
  folder_.Write("tank.json", TankJson());
  folder_.Write("controllers.json", R"({"version": 1, "controllers": [
      {"name": "b", "model": "tank.json", "records": "r"},
      {"name": "a 1", "model": "tank.json", "records": "r"},
      {"name": "c", "model": "tank.json", "records": "r"}]})");
  State state = OpenState();
  for (const char* controller : {"a 1", "b"}) {
    Watch watch = MakeWatch(controller, controller[0] == 'a');
    EXPECT_TRUE(state.Save(watch).ok());
  }
}

State WatchedSite::OpenState() const {
  absl::StatusOr<State> state = State::Open(StatePath());
  EXPECT_TRUE(state.ok()) << state.status();
  return *std::move(state);
}

Watch WatchedSite::MakeWatch(const std::string& controller, bool is_aged) {
  Watch watch;
  watch.controller = controller;
  watch.basis = "basis";
  watch.begin = watch.first = kFirstDay;
  watch.sample_time = 1.0;
  watch.reference = WatchReference{};
  watch.reference->low = watch.reference->high = Eigen::VectorXd::Zero(1);
  watch.outputs.resize(1);
  for (int day = 0; day < 3; ++day) {
    watch.days[kFirstDay + day] = {"x", BatchState::kUsed, ""};
    StoredBatch& stored = watch.outputs[0][day];
    stored.batch.number = day;
    stored.batch.score = Eigen::VectorXd::Ones(3);
    stored.batch.information = Eigen::MatrixXd::Identity(3, 3);
    stored.evidence.number = day;
    stored.evidence.log_output = is_aged ? 3.0 * day : -1.0;
    stored.evidence.log_elements = {0.0};
  }
  if (is_aged) {
    watch.alarms.push_back(
        {.id = kAlarmId,
         .day = kFirstDay + 2,
         .began = kFirstDay + 1,
         .text = std::string("The model of ") + kHostileTag + " has aged."});
  }
  return watch;
}

}  // namespace mle::watch
