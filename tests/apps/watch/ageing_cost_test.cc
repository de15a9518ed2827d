
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "apps/watch/health.h"
#include "apps/watch/report.h"
#include "control/mpc.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "sim/ageing_plant.h"
#include "sim/closed_loop.h"
#include "sim/plant.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using CostState = AgeingCost::State;

constexpr double kSampleTime = 5.0;  // min
constexpr int kSamplesOfDay = 288;
constexpr int kReferenceDays = 14;
constexpr double kSize = 0.6;  // of changes of the set point, two a day
constexpr double kWhite = 1e-3;
constexpr double kDrift = 2e-5;
constexpr double kPrice = 100.0;

ProcessModel Tank(double gain = 2.0, const std::string& time_unit = "min") {
  ProcessModel model("tank", time_unit, {{"steam", ""}}, {{"level", "mm"}});
  model.element(0, 0) = TransferFunction::FirstOrder(gain, 20.0, 10.0);
  return model;
}

Controller TankController() {
  Controller controller;
  controller.list = "list.json";
  controller.name = "tank";
  Valuation& valuation = controller.valuation.emplace();
  valuation.prices.squared_error = Eigen::VectorXd::Constant(1, kPrice);
  valuation.prices.absolute_error = Eigen::VectorXd::Zero(1);
  valuation.prices.violation = Eigen::VectorXd::Zero(1);
  valuation.prices.movement = Eigen::VectorXd::Zero(1);
  valuation.currency = "EUR";
  control::MpcOptions& tuning = controller.tuning.emplace();
  tuning.control_period = kSampleTime;
  tuning.prediction_horizon = 30;
  tuning.control_horizon = 3;
  tuning.output_weight = Eigen::MatrixXd::Ones(1, 1);
  tuning.move_weight = Eigen::MatrixXd::Ones(1, 1);
  return controller;
}

// Days of the closed loop, whose set point moves twice a day.
template <typename Control>
Record RunDays(sim::PlantModel& plant, const Control& control, int days,
               std::uint64_t seed, double white) {
  sim::SetPointProfile set_points;
  for (int day = 0; day < days; ++day) {
    for (const bool up : {true, false}) {
      set_points.steps.push_back(
          {.output = 0,
           .time = kSampleTime * (kSamplesOfDay * day + (up ? 70 : 200)),
           .value = up ? kSize : 0.0});
    }
  }
  sim::PlantConditions conditions;
  conditions.output_disturbance.drift_variance =
      Eigen::VectorXd::Constant(1, kDrift);
  absl::StatusOr<Record> record = sim::SimulateClosedLoop(
      plant, Tank(), control, set_points,
      {.sample_time = kSampleTime,
       .control_period = kSampleTime,
       .duration = kSampleTime * (kSamplesOfDay * days - 0.5),
       .noise_variance = white,
       .seed = seed},
      conditions);
  EXPECT_TRUE(record.ok()) << record.status();
  return *std::move(record);
}

Record RunDays(sim::PlantModel& plant, const ProcessModel& model, int days,
               std::uint64_t seed, double white = kWhite) {
  absl::StatusOr<control::Mpc> mpc =
      control::Mpc::Create(model, *TankController().tuning);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return RunDays(
      plant,
      [&mpc](const auto& y, const auto& r, auto next) {
        mpc->Step(y, r, next);
      },
      days, seed, white);
}

WatchBatch DayOfRecord(const Record& record, int day, int lead) {
  const int first = std::max(kSamplesOfDay * day - lead, 0);
  const int count = kSamplesOfDay * (day + 1) - first;
  WatchBatch batch;
  batch.first = kSamplesOfDay * day - first;
  batch.record.sample_time = record.sample_time;
  batch.record.outputs = record.outputs.middleCols(first, count);
  batch.record.inputs = record.inputs.middleCols(first, count);
  batch.record.set_points = record.set_points.middleCols(first, count);
  return batch;
}

// A watch of so many days of a tank whose gain has these factors over days.
Watch WatchTank(const std::vector<sim::Schedule::Point>& gain, int days,
                std::uint64_t seed = 1) {
  std::vector<sim::Schedule::Point> points = gain;
  for (sim::Schedule::Point& point : points) {
    point.time *= kSampleTime * kSamplesOfDay;
  }
  sim::AgeingSchedule ageing;
  ageing.elements.push_back({.gain = *sim::Schedule::Create(points)});
  absl::StatusOr<sim::AgeingPlant> plant =
      sim::AgeingPlant::Create(Tank(), ageing, {.sample_time = kSampleTime});
  EXPECT_TRUE(plant.ok()) << plant.status();
  const Record record = RunDays(*plant, Tank(), days, seed);
  const absl::StatusOr<ModelWatch> model =
      ModelWatch::Create(Tank(), kSampleTime, WatchOptions());
  EXPECT_TRUE(model.ok()) << model.status();
  Watch watch = EmptyWatch("tank", 1);
  watch.id = 1;
  watch.begin = watch.first = 20'500;  // 2026-02-16
  watch.sample_time = kSampleTime;
  std::vector<WatchBatch> reference;
  for (int day = 0; day < kReferenceDays; ++day) {
    reference.push_back(DayOfRecord(record, day, model->lead()));
  }
  absl::StatusOr<WatchReference> made = model->MakeReference(reference);
  EXPECT_TRUE(made.ok()) << made.status();
  watch.reference = *std::move(made);
  for (int day = 0; day < days; ++day) {
    absl::StatusOr<BatchScores> scores =
        model->Score(*watch.reference, DayOfRecord(record, day, model->lead()));
    EXPECT_TRUE(scores.ok()) << scores.status();
    watch.days[watch.first + day] = {"x", scores->state, ""};
    BatchOutput& output = scores->outputs[0];
    if (output.state != BatchState::kUsed) continue;
    StoredBatch& stored = watch.outputs[0][day];
    stored.batch = {.number = day,
                    .score = output.score,
                    .information = output.information};
    stored.evidence = {.number = day, .log_elements = {0.0}};
  }
  return watch;
}

double SumOfSquares(const Eigen::MatrixXd& errors) {
  return errors.squaredNorm();
}

// What the product missed of its set point in days of a tank of this gain: the
// inputs of the closed loop once more, without measurement noise.
Eigen::MatrixXd ErrorsOfProduct(double gain, const ProcessModel& model,
                                int days) {
  constexpr std::uint64_t kSeed = 77;
  Record record;
  for (const bool again : {false, true}) {
    absl::StatusOr<sim::Plant> plant =
        sim::Plant::Create(Tank(gain), {.sample_time = kSampleTime});
    EXPECT_TRUE(plant.ok()) << plant.status();
    if (!again) {
      record = RunDays(*plant, model, days, kSeed);
      continue;
    }
    const Eigen::MatrixXd inputs = record.inputs;
    Eigen::Index next_sample = 1;
    record = RunDays(
        *plant,
        [&](const auto&, const auto&, auto next) {
          next = inputs.col(std::min(next_sample++, inputs.cols() - 1));
        },
        days, kSeed, 0.0);
    EXPECT_EQ(record.inputs, inputs);
  }
  return record.outputs - record.set_points;
}

// By simulation: what 30 days of a plant of this gain cost more under the
// controller of old than under a corrected one, at the price of what `sum` says
// of the errors of samples.
template <typename Sum = decltype(SumOfSquares)>
double SimulatedCost(double gain, const Sum& sum = SumOfSquares) {
  constexpr int kDays = 600;
  double more = 0.0;
  for (const bool corrected : {false, true}) {
    more += (corrected ? -1.0 : 1.0) *
            sum(ErrorsOfProduct(2.0 * gain, Tank(corrected ? 2.0 * gain : 2.0),
                                kDays));
  }
  return kPrice * more * kSampleTime / 60.0 * 30.0 / kDays;
}

Report ReportOf(const Controller& controller, const Watch& watch) {
  return MakeReport(controller, Tank(), watch);
}

TEST(AgeingCostTest, IsTheSimulatedDifferenceOfCosts) {
  for (const double factor : {0.75, 1.4}) {
    const Watch watch = WatchTank({{41.0, 1.0}, {41.0, factor}}, 100);
    const Report report = ReportOf(TankController(), watch);
    const AgeingCost& cost = report.cost;
    ASSERT_EQ(cost.state, CostState::kTold) << CostText(report.model, cost);
    const double simulated = SimulatedCost(factor);
    const CourseEstimate& told = cost.points.front().cost;
    EXPECT_LT(told.low, simulated);
    EXPECT_GT(told.high, simulated);
    EXPECT_NEAR(told.mean / simulated, 1.0, 0.15);
    // An interval that is of use.
    EXPECT_LT(told.high - told.low, simulated);
    EXPECT_TRUE(cost.pays_now());
  }
}

TEST(AgeingCostTest, ErrorsBeyondTheAllowedOneHaveTheirOwnPrice) {
  static constexpr double kAllowed =
      0.2;  // a third of a change of the set point
  const Watch watch = WatchTank({{41.0, 1.0}, {41.0, 0.7}}, 100);
  Controller controller = TankController();
  Valuation& valuation = *controller.valuation;
  valuation.prices.squared_error.setZero();
  valuation.prices.violation = Eigen::VectorXd::Constant(1, kPrice);
  valuation.allowed_error = Eigen::VectorXd::Constant(1, kAllowed);
  const Report report = ReportOf(controller, watch);
  ASSERT_EQ(report.cost.state, CostState::kTold)
      << CostText(report.model, report.cost);
  const double simulated = SimulatedCost(0.7, [](const auto& errors) {
    return (errors.cwiseAbs().array() - kAllowed).cwiseMax(0.0).sum();
  });
  const CourseEstimate& told = report.cost.points.front().cost;
  EXPECT_LT(told.low, simulated);
  EXPECT_GT(told.high, simulated);
  EXPECT_NEAR(told.mean / simulated, 1.0, 0.15);
  // No error goes as far as 10 mm.
  valuation.allowed_error *= 50.0;
  const Report wide = ReportOf(controller, watch);
  EXPECT_NEAR(wide.cost.points.front().cost.mean, 0.0, 1e-6 * simulated);
}

TEST(AgeingCostTest, AFallCostsMoreEveryMonthAndHasADate) {
  // 0.86 by the end, 0.74 in 90 days.
  const Watch watch = WatchTank({{30.0, 1.0}, {430.0, 0.46}}, 134);
  Controller controller = TankController();
  Report report = ReportOf(controller, watch);
  ASSERT_EQ(report.cost.state, CostState::kTold)
      << CostText(report.model, report.cost);
  const std::vector<CostPoint>& points = report.cost.points;
  // Not further ahead than the watch has looked back.
  ASSERT_EQ(points.size(), 4U);
  EXPECT_EQ(points[3].day - watch.last_day(), watch.last_day() - watch.first);
  EXPECT_EQ(points[2].day, watch.last_day() + 90);
  for (std::size_t k = 0; k < points.size(); ++k) {
    EXPECT_LE(points[k].cost.low, points[k].cost.mean);
    EXPECT_GE(points[k].cost.high, points[k].cost.mean);
    if (k > 0) {
      EXPECT_GT(points[k].cost.mean, points[k - 1].cost.mean);
    }
  }
  const double later = SimulatedCost(1.0 - (134 + 90 - 30) * 0.54 / 400);
  EXPECT_LT(points[2].cost.low, later);
  EXPECT_GT(points[2].cost.high, later);
  // With an update that pays from such costs on, that is its day.
  controller.valuation->prices.engineer_hour = later;
  controller.valuation->days_between_updates = 30;
  report = ReportOf(controller, watch);
  EXPECT_DOUBLE_EQ(report.cost.update, later);
  ASSERT_TRUE(report.cost.earliest.has_value());
  EXPECT_LT(*report.cost.earliest, points[2].day);
  EXPECT_TRUE(!report.cost.latest.has_value() ||
              *report.cost.latest >= points[2].day);
  ASSERT_TRUE(report.cost.pays.has_value());
  EXPECT_NEAR(*report.cost.pays, points[2].day, 45);
  EXPECT_THAT(UpdateText(report.cost), HasSubstr("It is expected to pay from"));
  // An update that nothing saves.
  controller.valuation->prices.engineer_hour = 1e9;
  report = ReportOf(controller, watch);
  EXPECT_FALSE(report.cost.earliest.has_value());
  EXPECT_THAT(UpdateText(report.cost), HasSubstr("does not pay until"));
}

TEST(AgeingCostTest, WhatHasNotAgedCostsNothingAndHasNoDate) {
  const Watch watch = WatchTank({{0.0, 1.0}}, 100);
  const Report report = ReportOf(TankController(), watch);
  EXPECT_EQ(report.cost.state, CostState::kNothingAged);
  EXPECT_FALSE(report.cost.pays.has_value());
  EXPECT_EQ(UpdateText(report.cost), "");
  EXPECT_EQ(ShortCost(report.cost), "0");
  const auto json = nlohmann::json::parse(FormatController(report));
  EXPECT_EQ(json["ageing_cost"]["told"], "nothing_aged");
}

TEST(AgeingCostTest, APageTellsOneStory) {
  Watch watch = WatchTank({{40.0, 1.0}, {40.0, 0.75}}, 100);
  const int day = watch.last_day();
  watch.alarms = {{.id = "1", .day = day, .text = "First news."},
                  {.id = "2", .element = 0, .day = day, .text = "Steam has."}};
  watch.proposals = {{.day = day, .decision = "cannot_tell"}};
  const std::string page =
      FormatControllerPage(ReportOf(TankController(), watch), ".");
  // What is known now, and why the correction says something else.
  EXPECT_THAT(page, HasSubstr("<dt>level</dt><dd>The gain of level"));
  EXPECT_THAT(page, HasSubstr("cannot tell (below). The alarm rests on all"));
  EXPECT_THAT(page, HasSubstr("It pays now. The records have not given"));
  // Alarms of an output are one, the others folded.
  EXPECT_LT(page.find("Steam has."), page.find("Alarms before these"));
  EXPECT_GT(page.find("First news."), page.find("Alarms before these"));
}

TEST(AgeingCostTest, PagesAndProgramsAreTold) {
  const Watch watch = WatchTank({{40.0, 1.0}, {40.0, 0.75}}, 100);
  const Report report = ReportOf(TankController(), watch);
  EXPECT_THAT(FormatControllerPage(report, "."),
              AllOf(HasSubstr("Costs"), HasSubstr(" EUR a month"),
                    HasSubstr("It pays now.")));
  EXPECT_THAT(FormatOverview({report}), HasSubstr(">now<"));
  const auto json = nlohmann::json::parse(FormatController(report));
  const auto& cost = json["ageing_cost"];
  EXPECT_EQ(cost["told"], "told");
  EXPECT_EQ(cost["currency"], "EUR");
  EXPECT_EQ(cost["per_month"]["mean"], report.cost.points[0].cost.mean);
  EXPECT_EQ(cost["forecast"].size(), report.cost.points.size());
  EXPECT_EQ(cost["update"]["pays"], json["last_day"]);
  EXPECT_EQ(cost["update"]["pays_now"], true);
  EXPECT_EQ(cost["update"]["cost"], 100.0);
  EXPECT_THAT(FormatMetrics({report}, 0),
              AllOf(HasSubstr("mle_watch_ageing_cost_per_month{controller"),
                    HasSubstr("mle_watch_update_pays_timestamp_seconds{")));
}

TEST(AgeingCostTest, WithoutPricesOrTuningWhatToGiveIsSaid) {
  const Watch watch = WatchTank({{40.0, 1.0}, {40.0, 0.75}}, 100);
  Controller controller = TankController();
  controller.tuning.reset();
  Report report = ReportOf(controller, watch);
  EXPECT_EQ(report.cost.state, CostState::kNotAsked);
  EXPECT_THAT(report.cost.reason, HasSubstr("has to have the controller's "
                                            "tuning"));
  controller.valuation.reset();
  report = ReportOf(controller, watch);
  EXPECT_THAT(report.cost.reason, HasSubstr("prices (prices) and"));
  EXPECT_EQ(ShortCost(report.cost), "–");
  EXPECT_THAT(FormatMetrics({report}, 0),
              Not(HasSubstr("ageing_cost_per_month{")));
}

TEST(AgeingCostTest, WhatCannotBeToldIsNotTold) {
  const Watch watch = WatchTank({{40.0, 1.0}, {40.0, 0.75}}, 100);
  Controller controller = TankController();
  // Another tuning than that of the reference.
  controller.tuning->move_weight *= 6e4;
  AgeingCost cost = ReportOf(controller, watch).cost;
  EXPECT_EQ(cost.state, CostState::kCannotTell);
  EXPECT_THAT(cost.reason, HasSubstr("Is it another tuning that runs"));
  controller = TankController();
  controller.tuning->control_period = 7.0;
  cost = ReportOf(controller, watch).cost;
  EXPECT_EQ(cost.state, CostState::kCannotTell);
  EXPECT_THAT(cost.reason, HasSubstr("whole multiple"));
  EXPECT_FALSE(cost.wrong_list);
  controller = TankController();
  controller.valuation->prices.squared_error = Eigen::VectorXd::Ones(3);
  cost = ReportOf(controller, watch).cost;
  EXPECT_TRUE(cost.wrong_list);
  EXPECT_THAT(cost.reason,
              AllOf(HasSubstr("list.json: controller \"tank\""),
                    HasSubstr("prices.price_squared_error: 3 values")));
  // The model's file has changed since, and nobody has looked.
  cost = MakeReport(TankController(), Tank(2.0, "samples"), watch).cost;
  EXPECT_EQ(cost.state, CostState::kCannotTell);
  EXPECT_THAT(cost.reason, HasSubstr("its time unit is \"samples\""));
  // A state of before.
  Watch earlier = watch;
  earlier.reference->operation.clear();
  cost = ReportOf(TankController(), earlier).cost;
  EXPECT_EQ(cost.state, CostState::kCannotTell);
  EXPECT_THAT(cost.reason, HasSubstr("changes of set points"));
}

}  // namespace
}  // namespace mle::watch
