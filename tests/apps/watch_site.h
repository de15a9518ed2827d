// A site with a tank for tests of mle_watch: days of its records, the list of
// controllers, a program that takes alarms.

#ifndef TESTS_APPS_WATCH_SITE_H_
#define TESTS_APPS_WATCH_SITE_H_

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "mle/base/random.h"
#include "mle/model/process_model.h"
#include "mle/model/process_simulator.h"
#include "tests/apps/command_runner.h"

namespace mle {

inline constexpr int kSamplesOfDay = 288;  // every 5 min
inline constexpr double kSampleTime = 5.0;

inline std::string TankJson(double gain) {
  return absl::StrCat(R"({"name": "tank", "time_unit": "min",
    "inputs": [{"name": "steam", "unit": ""}],
    "outputs": [{"name": "level", "unit": ""}],
    "elements": [{"output": "level", "input": "steam", "gain": )",
                      gain, R"(, "time_constant": 20, "delay": 10}]})");
}

// Days of a tank whose operator moves the steam, from 2026-01-01 on; its gain
// falls by a tenth on day `aged`, and is what it was from day `back` on.
class TankDays {
 public:
  TankDays(int days, int aged, int back = 1'000'000) {
    Eigen::MatrixXd inputs = Eigen::MatrixXd::Zero(1, days * kSamplesOfDay);
    for (int day = 0; day < days; ++day) {
      const double size = day % 2 == 0 ? 1.0 : -0.8;
      inputs.row(0)
          .segment(day * kSamplesOfDay + 60 + 7 * (day % 9), 120)
          .setConstant(size);
    }
    const Eigen::MatrixXd before = Response(2.0, inputs);
    const Eigen::MatrixXd after = Response(1.8, inputs);
    GaussianNoise noise(1, kRunStream);
    outputs_ = before;
    const int end = std::min(days, back) * kSamplesOfDay;
    for (int k = aged * kSamplesOfDay; k < end; ++k) {
      outputs_(0, k) = after(0, k);
    }
    outputs_ += noise.DrawMatrix(1, static_cast<int>(inputs.cols()), 0.05);
    inputs_ = inputs;
  }

  // A row of CSV, or of SQL with `quote` around its time. `spoilt`: an output
  // of that many is added to one sample.
  std::string Row(int day, int k, const std::string& quote = "",
                  double spoilt = 0.0) const {
    const int at = day * kSamplesOfDay + k;
    const double level = outputs_(0, at) + (k == 100 ? spoilt : 0.0);
    // January has 31 days.
    return absl::StrFormat("%s2026-%02d-%02d %02d:%02d%s,%.6f,%.6f", quote,
                           day < 31 ? 1 : 2, day < 31 ? day + 1 : day - 30,
                           k / 12, 5 * (k % 12), quote, level, inputs_(0, at));
  }
  // Of a table (time, level, steam).
  std::string Insert(const std::string& table, int first, int last,
                     double spoilt = 0.0) const {
    std::vector<std::string> rows;
    for (int day = first; day < last; ++day) {
      for (int k = 0; k < kSamplesOfDay; ++k) {
        rows.push_back(absl::StrCat("(", Row(day, k, "'", spoilt), ")"));
      }
    }
    return absl::StrCat("INSERT INTO ", table, " VALUES ",
                        absl::StrJoin(rows, ",\n"), ";");
  }
  void Write(int day, const std::string& folder, double spoilt = 0.0) const {
    std::string text = "time,level,steam\n";
    for (int k = 0; k < kSamplesOfDay; ++k) {
      absl::StrAppend(&text, Row(day, k, "", spoilt), "\n");
    }
    ASSERT_TRUE(WriteFileAtomically(
                    absl::StrFormat("%s/day%03d.csv", folder, day), text)
                    .ok());
  }

 private:
  static Eigen::MatrixXd Response(double gain, const Eigen::MatrixXd& inputs) {
    const absl::StatusOr<ProcessModel> model =
        ParseProcessModel(TankJson(gain), "tank");
    EXPECT_TRUE(model.ok()) << model.status();
    const absl::StatusOr<Eigen::MatrixXd> response =
        SimulateResponse(*model, kSampleTime, inputs);
    EXPECT_TRUE(response.ok()) << response.status();
    return *response;
  }

  Eigen::MatrixXd inputs_;
  Eigen::MatrixXd outputs_;
};

class WatchSite : public ::testing::Test {
 protected:
  WatchSite() : days_(40, 25) {
    scratch_.Write("tank.json", TankJson(2.0));
    std::filesystem::create_directories(scratch_ / "records");
    scratch_.Write("controllers.json", R"({"version": 1, "controllers": [
        {"name": "tank", "model": "tank.json", "records": "records",
         "reference_days": 8}]})");
    alarms_ = scratch_ / "alarms.txt";
    WriteAlarmCommand(absl::StrCat("cat >>", alarms_));
  }

  void WriteAlarmCommand(const std::string& line) const {
    scratch_.Write("alarm.sh", absl::StrCat("#!/bin/sh\n", line, "\n"));
    std::filesystem::permissions(scratch_ / "alarm.sh",
                                 std::filesystem::perms::owner_all);
  }
  void WriteDays(int first, int last) const {
    for (int day = first; day < last; ++day) {
      days_.Write(day, scratch_ / "records");
    }
  }
  std::vector<std::string> Arguments(const std::string& out) const {
    return {absl::StrCat("--controllers=", scratch_ / "controllers.json"),
            absl::StrCat("--out=", scratch_ / out), "--propose=false",
            absl::StrCat("--alarm_command=", scratch_ / "alarm.sh")};
  }
  report::ProcessResult Watch(const std::string& out = "watch") const {
    return RunTested(Arguments(out));
  }
  nlohmann::json Tank(const std::string& out = "watch") const {
    return ParsedJson(scratch_ / (out + "/watch.json"))["controllers"][0];
  }
  int AlarmsHandedOn() const {
    if (!std::filesystem::exists(alarms_)) return 0;
    int count = 0;
    const std::string text = Content(alarms_);
    for (std::size_t at = text.find("\"id\""); at != std::string::npos;
         at = text.find("\"id\"", at + 1)) {
      ++count;
    }
    return count;
  }

  const TankDays days_;
  ScratchFolder scratch_;
  std::string alarms_;
};

}  // namespace mle

#endif  // TESTS_APPS_WATCH_SITE_H_
