#include "apps/watch/watch_file.h"

#include <cmath>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"

namespace mle::watch {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string ErrorOf(const std::string& json) {
  return std::string(ParseWatchFile(json, "site/c.json").status().message());
}

TEST(WatchFileTest, PathsAreTakenFromTheFilesFolder) {
  const auto controllers = ParseWatchFile(
      R"({"version": 1, "controllers": [
          {"name": "C 1", "model": "m.json", "records": "/data/c1",
           "tag_file": "../tags.csv", "reference_days": 20, "level": 0.01},
          {"name": "C 2", "model": "m.json", "records": "c2"}]})",
      "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  ASSERT_EQ(controllers->size(), 2U);
  const Controller& first = controllers->front();
  EXPECT_EQ(first.name, "C 1");
  EXPECT_EQ(first.model, "site/m.json");
  EXPECT_EQ(first.records, "/data/c1");
  EXPECT_EQ(first.tag_file, "tags.csv");
  EXPECT_EQ(first.reference_days, 20);
  EXPECT_EQ(first.options.level, 0.01);
  EXPECT_EQ(controllers->back().reference_days, 14);
}

TEST(WatchFileTest, ErrorsNameThePlaceAndWhatIsRight) {
  EXPECT_THAT(ErrorOf("{"), HasSubstr("site/c.json"));
  EXPECT_THAT(ErrorOf(R"({"version": 2, "controllers": []})"),
              HasSubstr("version"));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": []})"),
              HasSubstr("controllers"));
  EXPECT_THAT(
      ErrorOf(
          R"({"version": 1, "controllers": [{"name": "a", "model": "m"}]})"),
      HasSubstr("records"));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r", "colour": 1}]})"),
              HasSubstr("colour"));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r", "level": 1.5}]})"),
              AllOf(HasSubstr("level = 1.5"), HasSubstr("(0, 1)")));
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r"},
      {"name": "a", "model": "n", "records": "s"}]})"),
              HasSubstr("is duplicated"));
  // Names go into pages and file names.
  EXPECT_THAT(ErrorOf(R"({"version": 1, "controllers": [
      {"name": "../../etc", "model": "m", "records": "r"}]})"),
              HasSubstr("name"));
}

TEST(WatchFileTest, DriversOfOdbcAreNotNamedByPaths) {
  const auto error = [](const std::string& place) {
    return ErrorOf(R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "table": "t", "records": "odbc:)" +
                   place + "\"}]}");
  };
  for (const char* place :
       {"Driver=/tmp/x.so", "DSN=plant; driver = {/tmp/x.so}", "DRIVER=../x.so",
        "FileDSN=/tmp/plant.dsn"}) {
    EXPECT_THAT(error(place), HasSubstr("not by a path")) << place;
  }
  for (const char* place : {"plant", "Driver=SQLite3;Database=/srv/plant.db"}) {
    EXPECT_EQ(error(place), "") << place;
  }
}

std::string PricedJson(const std::string& prices, const std::string& tuning) {
  return R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r", "prices": )" +
         prices + R"(, "tuning": )" + tuning + "}]}";
}

constexpr char kPrices[] =
    R"({"price_squared_error": [3, 4], "price_engineer_hour": 90,
        "currency": "EUR"})";
constexpr char kTuning[] =
    R"({"control_period": 1, "prediction_horizon": 30, "control_horizon": 5,
        "output_weight": 0.2, "move_weight": [0.1, 0.3]})";

TEST(WatchFileTest, PricesAndTuningAreThoseOfTheLifeCycle) {
  auto controllers =
      ParseWatchFile(PricedJson(kPrices, kTuning), "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  Controller& controller = controllers->front();
  const ProcessModel model("m", "min", {{"u1", ""}, {"u2", ""}},
                           {{"y1", ""}, {"y2", ""}});
  ASSERT_TRUE(FitToModel(model, controller).ok());
  const Valuation& valuation = *controller.valuation;
  EXPECT_EQ(valuation.prices.squared_error, Eigen::Vector2d(3.0, 4.0));
  EXPECT_EQ(valuation.prices.absolute_error, Eigen::Vector2d::Zero());
  EXPECT_EQ(valuation.prices.violation, Eigen::Vector2d::Zero());
  EXPECT_TRUE(valuation.allowed_error.array().isInf().all());
  EXPECT_EQ(valuation.prices.movement, Eigen::Vector2d::Zero());
  EXPECT_EQ(valuation.prices.engineer_hour, 90.0);
  EXPECT_EQ(valuation.prices.hours_per_update, 1.0);
  EXPECT_EQ(valuation.currency, "EUR");
  EXPECT_EQ(valuation.days_between_updates, 365);
  EXPECT_EQ(controller.tuning->prediction_horizon, 30);
  EXPECT_EQ(controller.tuning->output_weight.diagonal(),
            Eigen::Vector2d(0.2, 0.2));
  EXPECT_EQ(controller.tuning->move_weight.diagonal(),
            Eigen::Vector2d(0.1, 0.3));
}

TEST(WatchFileTest, ViolationsHaveAPriceBeyondAnAllowedError) {
  auto controllers = ParseWatchFile(
      PricedJson(R"({"price_violation": 7, "allowed_error": [0.1, 0.4],
                     "price_engineer_hour": 90})",
                 kTuning),
      "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  const ProcessModel model("m", "min", {{"u1", ""}, {"u2", ""}},
                           {{"y1", ""}, {"y2", ""}});
  ASSERT_TRUE(FitToModel(model, controllers->front()).ok());
  const Valuation& valuation = *controllers->front().valuation;
  EXPECT_EQ(valuation.prices.violation, Eigen::Vector2d(7.0, 7.0));
  EXPECT_EQ(valuation.allowed_error, Eigen::Vector2d(0.1, 0.4));
  for (const char* half : {"price_violation", "allowed_error"}) {
    EXPECT_THAT(
        ErrorOf(PricedJson(absl::StrCat("{\"", half,
                                        R"(": 1, "price_squared_error": 2,
                                             "price_engineer_hour": 90})"),
                           kTuning)),
        AllOf(HasSubstr("controllers[0].prices"), HasSubstr("together")));
  }
  EXPECT_THAT(
      ErrorOf(PricedJson(R"({"price_violation": 1, "allowed_error": -0.1,
                             "price_engineer_hour": 90})",
                         kTuning)),
      AllOf(HasSubstr("prices.allowed_error"), HasSubstr("≥ 0")));
}

TEST(WatchFileTest, MistakesInPricesAndTuningAreNamed) {
  const auto prices_error = [](const std::string& prices) {
    return ErrorOf(PricedJson(prices, kTuning));
  };
  EXPECT_THAT(prices_error(R"({"price_squared_error": 3})"),
              AllOf(HasSubstr("site/c.json: controllers[0].prices"),
                    HasSubstr("price_engineer_hour")));
  EXPECT_THAT(prices_error(R"({"price_engineer_hour": 90})"),
              HasSubstr("price_squared_error, price_absolute_error or "
                        "price_violation must be > 0"));
  EXPECT_THAT(
      prices_error(R"({"price_engineer_hour": 90, "price_squared_error": -1})"),
      AllOf(HasSubstr("controllers[0].prices.price_squared_error"),
            HasSubstr("≥ 0"), HasSubstr("-1")));
  EXPECT_THAT(prices_error(
                  R"({"price_engineer_hour": 90, "price_squared_error": "x"})"),
              AllOf(HasSubstr("price_squared_error"), HasSubstr("\"x\"")));
  EXPECT_THAT(prices_error(R"({"price_engineer_hour": 90, "price": 1})"),
              HasSubstr("price"));
  EXPECT_THAT(prices_error(R"({"price_engineer_hour": 90,
                  "price_squared_error": 1, "currency": "pounds sterling"})"),
              AllOf(HasSubstr("prices.currency"), HasSubstr("at most 12")));
  EXPECT_THAT(ErrorOf(PricedJson(kPrices, R"({"control_period": 1})")),
              HasSubstr("controllers[0].tuning"));
  EXPECT_THAT(
      ErrorOf(PricedJson(kPrices,
                         R"({"control_period": 1, "prediction_horizon": 3,
                             "control_horizon": 5, "output_weight": 0.2,
                             "move_weight": 0.1})")),
      AllOf(HasSubstr("tuning.control_horizon"), HasSubstr("at most")));
}

std::string PlannedJson(const std::string& plan) {
  return R"({"version": 1, "controllers": [
      {"name": "a", "model": "m", "records": "r", "plan": )" +
         plan + "}]}";
}

ProcessModel OneTank() {
  ProcessModel model("m", "min", {{"feed", ""}}, {{"level", ""}});
  model.element(0, 0) = TransferFunction::FirstOrder(1.0, 5.0, 0.0);
  return model;
}

TEST(WatchFileTest, APlanHasTheOptionsOfACorrection) {
  auto controllers = ParseWatchFile(PlannedJson("{}"), "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  EXPECT_TRUE(controllers->front().plan->wanted);
  EXPECT_EQ(controllers->front().plan->error, 0.1);
  EXPECT_EQ(controllers->front().plan->max_output.size(), 0);
  controllers =
      ParseWatchFile(PlannedJson(R"({"error": 0.05, "longest": 600, "quiet": 10,
                      "set_points": ["level"], "min_output": [-1],
                      "max_input": "none"})"),
                     "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  ASSERT_TRUE(FitToModel(OneTank(), controllers->front()).ok());
  const correct::NextMoveOptions& plan = *controllers->front().plan;
  EXPECT_EQ(plan.error, 0.05);
  EXPECT_EQ(plan.longest, 600.0);
  EXPECT_EQ(plan.quiet, 10.0);
  EXPECT_EQ(plan.set_points, std::vector<std::string>{"level"});
  EXPECT_EQ(plan.min_output[0], -1.0);
  EXPECT_TRUE(std::isinf(plan.max_input[0]));
}

TEST(WatchFileTest, MistakesInPlansAreNamed) {
  EXPECT_THAT(ErrorOf(PlannedJson(R"({"error": 2})")),
              AllOf(HasSubstr("controllers[0].plan.error"), HasSubstr("2")));
  EXPECT_THAT(ErrorOf(PlannedJson(R"({"plan_error": 0.1})")),
              AllOf(HasSubstr("controllers[0].plan"), HasSubstr("error")));
  EXPECT_THAT(ErrorOf(PlannedJson(R"({"max_output": "high"})")),
              AllOf(HasSubstr("plan.max_output"), HasSubstr("\"high\"")));
  const auto fit = [](const char* plan) {
    auto controllers = ParseWatchFile(PlannedJson(plan), "site/c.json");
    EXPECT_TRUE(controllers.ok()) << controllers.status();
    return std::string(FitToModel(OneTank(), controllers->front()).message());
  };
  EXPECT_THAT(fit(R"({"max_output": [1, 2]})"),
              AllOf(HasSubstr("site/c.json: controller \"a\""),
                    HasSubstr("plan.max_output: 2 values")));
  EXPECT_THAT(
      fit(R"({"set_points": ["flow"]})"),
      AllOf(HasSubstr("plan: "), HasSubstr("flow"), HasSubstr("it has level")));
}

TEST(WatchFileTest, AsManyValuesAsTheModelHasChannels) {
  auto controllers =
      ParseWatchFile(PricedJson(kPrices, kTuning), "site/c.json");
  ASSERT_TRUE(controllers.ok()) << controllers.status();
  const ProcessModel model("m", "min", {{"u1", ""}, {"u2", ""}},
                           {{"y1", ""}, {"y2", ""}, {"y3", ""}});
  const std::string error(FitToModel(model, controllers->front()).message());
  EXPECT_THAT(error, AllOf(HasSubstr("site/c.json: controller \"a\""),
                           HasSubstr("prices.price_squared_error: 2 values"),
                           HasSubstr("each of 3 channels")));
}

}  // namespace
}  // namespace mle::watch
