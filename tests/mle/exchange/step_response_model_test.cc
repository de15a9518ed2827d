#include "mle/exchange/step_response_model.h"

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/exchange/step_response_texts.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

StepResponseModel ParsedResponses(const std::string& text) {
  const absl::StatusOr<StepResponseModel> model =
      ParseStepResponseModel(text, "tank.csv");
  EXPECT_TRUE(model.ok()) << model.status();
  return model.ok() ? *model : StepResponseModel();
}

void ExpectSame(const StepResponseModel& a, const StepResponseModel& b) {
  EXPECT_TRUE(CheckSameChannels(a.channels, "a", b.channels, "b").ok());
  EXPECT_EQ(a.channels.name(), b.channels.name());
  for (int j = 0; j < a.channels.num_inputs(); ++j) {
    EXPECT_EQ(a.channels.inputs()[j].unit, b.channels.inputs()[j].unit);
    EXPECT_EQ(a.channels.inputs()[j].role, b.channels.inputs()[j].role);
  }
  EXPECT_EQ(a.interval, b.interval);
  ASSERT_EQ(a.pairs.size(), b.pairs.size());
  for (std::size_t p = 0; p < a.pairs.size(); ++p) {
    EXPECT_EQ(a.pairs[p].output, b.pairs[p].output);
    EXPECT_EQ(a.pairs[p].input, b.pairs[p].input);
    EXPECT_EQ(a.pairs[p].is_ramp, b.pairs[p].is_ramp);
    EXPECT_EQ(a.pairs[p].coefficients, b.pairs[p].coefficients);
  }
}

// Of every form: texts that are wrong, each by one replacement in a good one,
// and what the error has to name.
struct Mistake {
  std::vector<std::pair<std::string, std::string>> replaced;
  std::vector<std::string> named;
};

void ExpectFaults(const std::string& good, const std::string& file,
                  const std::vector<Mistake>& mistakes) {
  for (const Mistake& mistake : mistakes) {
    const std::string bad = absl::StrReplaceAll(good, mistake.replaced);
    SCOPED_TRACE(bad);
    ASSERT_NE(bad, good);
    const absl::StatusOr<StepResponseModel> model =
        ParseStepResponseModel(bad, file);
    ASSERT_FALSE(model.ok());
    EXPECT_EQ(model.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(std::string(model.status().message()), HasSubstr(file));
    for (const std::string& name : mistake.named) {
      EXPECT_THAT(std::string(model.status().message()), HasSubstr(name));
    }
  }
}

TEST(StepResponseModel, ReadsATable) {
  const StepResponseModel model = ParsedResponses(kTankCsv);
  EXPECT_EQ(model.channels.name(), "Heated tank");
  EXPECT_EQ(model.channels.time_unit(), "min");
  EXPECT_EQ(model.channels.inputs()[1].role, InputRole::kDisturbance);
  EXPECT_EQ(model.channels.outputs()[0].unit, "degC");
  EXPECT_EQ(model.interval, 2.0);
  EXPECT_EQ(model.length(), 12);
  EXPECT_EQ(model.time_to_steady_state(), 24.0);
  EXPECT_EQ(model.pairs[1].input, 1);
  EXPECT_EQ(model.pairs[1].coefficients(2), -0.27);
  EXPECT_FALSE(model.pairs[1].is_ramp);
}

TEST(StepResponseModel, ReadsJson) {
  const StepResponseModel csv = ParsedResponses(absl::StrReplaceAll(
      kTankCsv, {{"time,", "ramp,temperature/inflow\ntime,"}}));
  ExpectSame(ParsedResponses(kTankJson), csv);
  EXPECT_TRUE(csv.pairs[1].is_ramp);
}

// What Excel makes of it in Europe, what is typed more freely, and a row of
// time 0 are the same model.
TEST(StepResponseModel, ReadsOtherSpellings) {
  const StepResponseModel model = ParsedResponses(kTankCsv);
  ExpectSame(model, ParsedResponses(absl::StrReplaceAll(
                        kTankCsv, {{",", ";"}, {".", ","}, {"\n", ";;\r\n"}})));
  ExpectSame(model,
             ParsedResponses(absl::StrReplaceAll(kTankCsv, {{",", "\t"}})));
  ExpectSame(model, ParsedResponses(absl::StrReplaceAll(
                        kTankCsv,
                        {{"time unit", "Time_Unit"},
                         {"interval,2", " Interval , 2.0"},
                         {"time,temp", "time to steady state,24\n\nTime,temp"},
                         {"2,0,-0.1\n", "0,0,0\n2,0,-0.1\n"}})));
  // Without lines of channels, the header names them.
  const StepResponseModel bare = ParsedResponses(
      absl::StrReplaceAll(kTankCsv, {{"input,steam,t/h\n", ""},
                                     {"input,inflow,m3/h,disturbance\n", ""},
                                     {"output,temperature,degC\n", ""},
                                     {"name,Heated tank\n", ""}}));
  EXPECT_EQ(bare.channels.name(), "tank");
  EXPECT_EQ(bare.channels.inputs()[1].name, "inflow");
  EXPECT_EQ(bare.pairs[1].coefficients, model.pairs[1].coefficients);
}

// Numbers that have no short decimal form come back bit by bit, and pairs in
// their order.
TEST(StepResponseModel, RoundTripsAreExact) {
  std::mt19937 random(7);
  StepResponseModel model;
  model.channels = ProcessModel("a, \"b\"", "s", {{"u/1", "%"}, {"u,2", ""}},
                                {{"y1", "K"}, {"y2", ""}});
  model.interval = 0.1;
  for (const auto& [i, j] :
       {std::pair(1, 1), std::pair(0, 0), std::pair(1, 0)}) {
    PairResponse pair{i, j, Eigen::VectorXd(40), i == j};
    for (double& c : pair.coefficients) {
      c = std::uniform_real_distribution<double>(-1e-3, 1e3)(random);
    }
    model.pairs.push_back(std::move(pair));
  }
  ASSERT_TRUE(model.Validate().ok()) << model.Validate();
  ExpectSame(ParsedResponses(FormatStepResponseCsv(model)), model);
  ExpectSame(ParsedResponses(FormatStepResponseJson(model)), model);
}

TEST(StepResponseModel, SaysWhatIsWrongInATable) {
  ExpectFaults(
      kTankCsv, "tank.csv",
      {{{{"4,1.5,-0.2\n", "4,1.5,-0.2,7\n"}}, {"line 9", "4 fields", "has 3"}},
       {{{"4,1.5,-0.2\n", "4,1.5\n"}}, {"line 9, column 3", "empty"}},
       {{{"4,1.5,-0.2\n", "4,x1.5,-0.2\n"}}, {"line 9, column 2", "'x1.5'"}},
       {{{"4,1.5,-0.2\n", "4,1.5,nan\n"}}, {"line 9, column 3", "'nan'"}},
       {{{"4,1.5,-0.2\n", "4,1.5,1e300\n"}},
        {"temperature ← inflow", "1e+100"}},
       {{{"4,1.5,-0.2\n", "5,1.5,-0.2\n"}}, {"line 9", "is 5, must be 4"}},
       {{{"2,0,-0.1\n", "0,0.5,0\n2,0,-0.1\n"}}, {"line 8", "must be 0"}},
       {{{"interval,2\n", ""}}, {"line 6", "interval,1"}},
       {{{"interval,2\n", "interval,-2\n"}}, {"line 3", "positive"}},
       {{{"interval,2\n", "interval,2\ninterval,2\n"}}, {"line 4", "line 3"}},
       {{{"interval,2\n", "interval,2,3\n"}}, {"line 3", "must have one"}},
       {{{"interval,2\n", "intreval,2\n"}},
        {"line 3", "'intreval'", "interval"}},
       {{{"interval,2\n", "interval,2\ntime to steady state,30\n"}},
        {"line 4, column 2", "is 30", "end at 24"}},
       {{{"time unit,min\n", ""}}, {"time unit,min"}},
       {{{"output,temperature,degC\n", ""}}, {"line 6", "name no output"}},
       {{{"temperature/inflow", "temperature/outflow"}},
        {"line 7, column 3", "'temperature/outflow'", "temperature/steam"}},
       {{{"temperature/inflow", "temperature/steam"}},
        {"line 7, column 3", "column 2 already"}},
       {{{"input,inflow,m3/h,disturbance", "input,steam,m3/h,disturbance"}},
        {"line 5", "'steam'", "line 4"}},
       {{{"m3/h,disturbance", "m3/h,disturbed"}}, {"line 5", "disturbance"}},
       {{{"time,", "ramp,level/steam\ntime,"}}, {"line 7", "'level/steam'"}},
       {{{"output,temperature,degC\n",
          "output,temperature,degC\noutput,level,m\nramp,level/steam\n"}},
        {"line 8, column 2", "no column"}},
       {{{"time,temperature", "Time (min),temperature"}}, {"line 7", "'time'"}},
       {{{"8,3.25", "\"8\"x,3.25"}}, {"line 11"}},
       {{{"Heated tank", "Beh\xE4lter"}},
        {"line 1, column 2", "'Beh\\xe4lter'", "UTF-8"}},
       {{{"degC", "\xED\xA0\x80"}}, {"line 6, column 3", "UTF-8"}}});
  ExpectFaults(
      absl::StrReplaceAll(kTankCsv, {{"input,steam,t/h\n", ""},
                                     {"input,inflow,m3/h,disturbance\n", ""},
                                     {"output,temperature,degC\n", ""}}),
      "tank.csv",
      {{{{"temperature/inflow", "inflow"}}, {"line 4, column 3", "'inflow'"}}});
  const std::string short_table(kTankCsv, std::string(kTankCsv).find("16,4.6"));
  const absl::Status status =
      ParseStepResponseModel(short_table, "tank.csv").status();
  EXPECT_THAT(std::string(status.message()),
              AllOf(HasSubstr("7 coefficients"), HasSubstr("10")));
  EXPECT_THAT(
      std::string(ParseStepResponseModel("", "tank.csv").status().message()),
      AllOf(HasSubstr("tank.csv"), HasSubstr("no table")));
}

TEST(StepResponseModel, SaysWhatIsWrongInJson) {
  ExpectFaults(
      kTankJson, "tank.json",
      {{{{"\"interval\": 2,", ""}}, {"\"interval\"", "missing"}},
       {{{"\"interval\": 2,", "\"interval\": 0,"}}, {"interval"}},
       {{{"4.9, 4.93]", "4.9]"}},
        {"step_responses[1].coefficients", "12", "first pair has 11"}},
       {{{"4.9, 4.93]", "4.9, \"x\"]"}}, {"coefficients[11]"}},
       {{{"4.9, 4.93]", "4.9, 4.93"}}, {"line"}},
       {{{"\"input\": \"inflow\"", "\"input\": \"outflow\""}},
        {"step_responses[1].input", "outflow", "inflow"}},
       {{{"\"input\": \"inflow\"", "\"input\": \"steam\""}},
        {"step_responses[1]", "is duplicated"}},
       {{{"\"ramp\"", "\"slope\""}}, {"step_responses[1].end", "slope"}},
       {{{"\"interval\": 2,",
          "\"interval\": 2, \"time_to_steady_state\": 30,"}},
        {"time_to_steady_state", "30", "24"}},
       {{{"\"interval\": 2,", "\"interval\": 2, \"delay\": 3,"}}, {"delay"}}});
}

// c_k + ψ_k − φ_k where these differ, the same bits where they do not.
TEST(StepResponseModel, TakesAChange) {
  const StepResponseModel model = ParsedResponses(kTankCsv);
  ProcessModel before = model.channels;
  before.element(0, 0) = TransferFunction::FirstOrder(5.0, 6.0, 2.0);
  before.element(0, 1) = TransferFunction::FirstOrder(-0.47, 7.0, 0.0);
  ProcessModel after = before;
  after.element(0, 0) = TransferFunction::FirstOrder(10.0, 6.0, 2.0);
  const StepResponseModel changed =
      WithChange(model, before.ComputeStepResponse(2.0, 13),
                 after.ComputeStepResponse(2.0, 13));
  EXPECT_EQ(changed.interval, model.interval);
  EXPECT_EQ(changed.pairs[1].coefficients, model.pairs[1].coefficients);
  const Eigen::VectorXd response =
      before.element(0, 0).StepResponse(2.0, 13).tail(12);
  EXPECT_LT(
      (changed.pairs[0].coefficients - model.pairs[0].coefficients - response)
          .cwiseAbs()
          .maxCoeff(),
      1e-12);
}

TEST(StepResponseModel, TakesAPairThatAppears) {
  StepResponseModel model = ParsedResponses(kTankCsv);
  model.pairs.pop_back();
  ProcessModel before = model.channels;
  before.element(0, 0) = TransferFunction::FirstOrder(5.0, 6.0, 2.0);
  ProcessModel after = before;
  after.element(0, 1) = TransferFunction::FirstOrder(-0.5, 7.0, 0.0);
  const StepResponseModel changed =
      WithChange(model, before.ComputeStepResponse(2.0, 13),
                 after.ComputeStepResponse(2.0, 13));
  ASSERT_EQ(changed.pairs.size(), 2U);
  EXPECT_TRUE(changed.Validate().ok());
  EXPECT_EQ(changed.pairs[0].coefficients, model.pairs[0].coefficients);
  EXPECT_EQ(changed.pairs[1].coefficients,
            after.element(0, 1).StepResponse(2.0, 13).tail(12));
}

}  // namespace
}  // namespace mle
