#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "apps/experiment/campaign_json.h"
#include "apps/experiment/study.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/file.h"
#include "tests/apps/experiment/small_campaign.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::experiment {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::json;

absl::StatusOr<Campaign> Parse(const Json& json) {
  const auto resolved = ResolveCampaign(json.dump(), "c.json", "");
  if (!resolved.ok()) return resolved.status();
  return ParseCampaign(*resolved, "c.json");
}

struct BadCampaign {
  std::function<void(Json&)> spoil;
  std::vector<std::string> named;  // what the message must hold
};

void ExpectRefused(const std::vector<BadCampaign>& campaigns) {
  for (const BadCampaign& bad : campaigns) {
    Json json = SmallCampaign(2);
    bad.spoil(json);
    const absl::StatusOr<Campaign> campaign = Parse(json);
    SCOPED_TRACE(::testing::PrintToString(bad.named));
    ASSERT_FALSE(campaign.ok());
    EXPECT_EQ(campaign.status().code(), absl::StatusCode::kInvalidArgument);
    const std::string message(campaign.status().message());
    EXPECT_THAT(message, HasSubstr("c.json"));
    for (const std::string& name : bad.named) {
      EXPECT_THAT(message, HasSubstr(name));
    }
  }
}

TEST(CampaignTest, DefaultsAreThePapers) {
  Json json = SmallCampaign(3);
  for (const char* key : {"windows", "selections", "sample_time", "order",
                          "response_horizon", "lambda_grid", "conversion"}) {
    json.erase(key);
  }
  const absl::StatusOr<Campaign> campaign = Parse(json);
  ASSERT_TRUE(campaign.ok()) << campaign.status();
  EXPECT_EQ(campaign->seeds, (std::vector<std::uint64_t>{1, 2, 3}));
  EXPECT_EQ(campaign->settings.conversion.order, 150);
  EXPECT_EQ(campaign->settings.correction.lambdas.size(), 10001);
  EXPECT_EQ(campaign->noise_variances, std::vector<double>{0.001});
  EXPECT_EQ(campaign->drift_variances, std::vector<double>{0.0});
  ASSERT_EQ(campaign->controllers.size(), 1U);
  EXPECT_EQ(campaign->controllers[0].mpc.prediction_horizon, 30);
  ASSERT_EQ(campaign->windows.size(), 1U);
  EXPECT_EQ(campaign->windows[0].step_time, 500.0);
  ASSERT_EQ(campaign->methods.size(), 1U);
  EXPECT_EQ(campaign->methods[0].name(), "arx:none");
}

TEST(CampaignTest, MethodsAreTheProductOfWhatTheyUse) {
  Json json = SmallCampaign(1);
  json["estimators"] = {"none", "arx", "output_error"};
  json["selections"] = {"paper", "bic"};
  json["solvers"] = {"homotopy", "coordinate_descent"};
  const absl::StatusOr<Campaign> campaign = Parse(json);
  ASSERT_TRUE(campaign.ok()) << campaign.status();
  EXPECT_EQ(campaign->methods.size(), 1U + 2U * 2U + 1U);
}

TEST(CampaignTest, SizesMakeAMismatchEach) {
  Json json = SmallCampaign(1);
  json["mismatches"][0]["sizes"] = {0.5, 1, 2};
  const absl::StatusOr<Campaign> campaign = Parse(json);
  ASSERT_TRUE(campaign.ok()) << campaign.status();
  ASSERT_EQ(campaign->mismatches.size(), 4U);
  EXPECT_EQ(campaign->mismatches[2].name, "gain");
  EXPECT_EQ(campaign->mismatches[2].size, 2.0);
}

TEST(CampaignTest, GridOfLambdaInEqualFactors) {
  Json json = SmallCampaign(1);
  json["lambda_grid"] = {{"min", 1e-6}, {"max", 1e-2}, {"count", 5}};
  const absl::StatusOr<Campaign> campaign = Parse(json);
  ASSERT_TRUE(campaign.ok()) << campaign.status();
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(campaign->settings.correction.lambdas(i), std::pow(10.0, i - 6),
                1e-15);
  }
  EXPECT_EQ(campaign->settings.correction.lambdas(4), 1e-2);
}

TEST(CampaignTest, KeysAndTypes) {
  ExpectRefused({
      {[](Json& j) { j["sedes"] = 3; }, {"unknown key \"sedes\"", "seeds"}},
      {[](Json& j) { j.erase("models"); }, {"\"models\" is missing"}},
      {[](Json& j) { j = Json::array(); }, {"must be an object", "array"}},
      {[](Json& j) { j["version"] = 2; }, {"version", "from 1 to 1", "2"}},
      {[](Json& j) { j["name"] = 3; }, {"name", "string", "number 3"}},
      {[](Json& j) { j["name"] = "a/b\n"; }, {"name", "letters"}},
      {[](Json& j) { j["order"] = 1.5; }, {"order", "whole number", "1.5"}},
      {[](Json& j) { j["sample_time"] = 0; }, {"sample_time", "> 0"}},
      {[](Json& j) { j["sample_time"] = "1"; },
       {"sample_time", "the string \"1\""}},
      {[](Json& j) { j["scaling"] = "none"; }, {"scaling", "standardise"}},
      {[](Json& j) { j["conversion"]["seed"] = 1; },
       {"conversion", "unknown key \"seed\""}},
  });
}

TEST(CampaignTest, SeedsAndNumbers) {
  ExpectRefused({
      {[](Json& j) { j["seeds"] = 5; }, {"seeds", "list of seeds"}},
      {[](Json& j) { j["seeds"] = Json::array(); }, {"seeds", "empty list"}},
      {[](Json& j) {
         j["seeds"] = {1, 2, 1};
       },
       {"seeds[2]", "1 is duplicated"}},
      {[](Json& j) {
         j["seeds"] = {1, -2};
       },
       {"seeds[1]", "-2"}},
      {[](Json& j) { j["seeds"]["count"] = 0; }, {"seeds.count", "from 1"}},
      {[](Json& j) { j["seeds"]["first"] = 1e300; }, {"seeds.first"}},
      {[](Json& j) { j["noise_variances"] = Json::array(); },
       {"noise_variances", "empty list"}},
      {[](Json& j) {
         j["noise_variances"] = {1e-3, 1e-3};
       },
       {"noise_variances[1]", "is duplicated"}},
      {[](Json& j) { j["noise_variances"] = {-1}; },
       {"noise_variances[0]", "≥ 0", "-1"}},
      {[](Json& j) { j["drift_variances"] = {nullptr}; },
       {"drift_variances[0]", "null"}},
  });
}

TEST(CampaignTest, ModelsAndMismatches) {
  ExpectRefused({
      {[](Json& j) { j["models"].push_back(j["models"][0]); },
       {"models[1]", "'column' is duplicated"}},
      {[](Json& j) {
         j["models"][0]["model"]["inputs"][0]["transform"] = {{"kind", "log"},
                                                              {"at", 1.0}};
       },
       {"model 'column'", "the model has transforms"}},
      {[](Json& j) { j["models"][0]["random"] = Json::object(); },
       {"models[0]", "one of file"}},
      {[](Json& j) { j["models"][0]["file"] = "no/such.json"; },
       {"models[0]", "only one"}},
      {[](Json& j) {
         j["models"][0] = {{"name", "x"}, {"file", "no/such.json"}};
       },
       {"models[0].file", "no/such.json"}},
      {[](Json& j) { j["models"][0]["model"]["elements"][0]["gain"] = "x"; },
       {"models[0].model", "elements[0]"}},
      {[](Json& j) {
         j["models"][0] = {{"name", "r"}, {"random", {{"gain", {5, 1}}}}};
       },
       {"models[0].random.gain", "5 is above 1"}},
      {[](Json& j) { j["mismatches"][0]["name"] = "delay"; },
       {"mismatches[1]", "'delay' is duplicated"}},
      {[](Json& j) { j["mismatches"][0]["changes"][0]["input"] = "feed"; },
       {"mismatches[0]", "column", "'feed'", "no element"}},
      {[](Json& j) { j["mismatches"][0]["changes"][0] = Json::object(); },
       {"mismatches[0].changes[0]", "changes nothing"}},
      {[](Json& j) { j["mismatches"][0]["changes"][0]["gain_factor"] = 0; },
       {"mismatches[0].changes[0].gain_factor", "> 0"}},
      {[](Json& j) { j["mismatches"][1]["changes"][0]["delay_shift"] = -3; },
       {"mismatches[1]", "dead time", "negative"}},
      {[](Json& j) {
         j["mismatches"][0] = {{"name", "none"}, {"sizes", {1}}};
       },
       {"mismatches[0].sizes", "only changes"}},
      {[](Json& j) {
         Json other = j["models"][0]["model"];
         other["inputs"][0]["name"] = "feed";
         for (Json& e : other["elements"]) {
           if (e["input"] == "reflux") e["input"] = "feed";
         }
         j["mismatches"][0] = {{"name", "other"}, {"plant", other}};
       },
       {"mismatches[0]", "feed"}},
  });
}

Json Sine(double amplitude) {
  return {{"outputs",
           {{{"name", "top"},
             {"sines", {{{"amplitude", amplitude}, {"period", 20}}}}}}}};
}

TEST(CampaignTest, EffectsAreOfTheChannelsOfEveryModel) {
  Json json = SmallCampaign(2);
  EXPECT_EQ(Parse(json)->effects.size(), 1u);
  EXPECT_EQ(Parse(json)->effects[0].name, "none");
  const ScratchFolder folder;
  const std::string path = folder.Write("effects.json", Sine(0.3).dump());
  json["effects"] = {{{"name", "none"}},
                     {{"name", "sine"}, {"effects", Sine(0.2)}},
                     {{"name", "file"}, {"file", path}}};
  const absl::StatusOr<Campaign> campaign = Parse(json);
  ASSERT_TRUE(campaign.ok()) << campaign.status();
  ASSERT_EQ(campaign->effects.size(), 3u);
  EXPECT_TRUE(campaign->effects[0].of_models.empty());
  EXPECT_EQ(campaign->effects[1].of_models[0].sines[0].amplitude, 0.2);
  EXPECT_EQ(campaign->effects[2].of_models[0].sines[0].amplitude, 0.3);
  EXPECT_EQ(OptionsOf(*campaign, {.effects = 2}, 2, 2)->effects.sines.size(),
            1u);
  // Channels of plants drawn at random are u1, …, y1, ….
  json["models"].push_back({{"name", "r"}, {"random", Json::object()}});
  EXPECT_THAT(std::string(Parse(json).status().message()),
              HasSubstr("no channel \"top\""));
}

TEST(CampaignTest, EffectsThatAreWrong) {
  const ScratchFolder folder;
  Json wrong = Sine(0.1);
  wrong["outputs"][0]["sines"][0]["period"] = 0;
  const std::string path = folder.Write("effects.json", wrong.dump());
  ExpectRefused({
      {[](Json& j) { j["effects"] = Sine(0.1); }, {"effects"}},
      {[](Json& j) { j["effects"] = Json::array({Sine(0.1)}); },
       {"effects[0]", "name"}},
      {[](Json& j) {
         j["effects"] = {{{"name", "a"}, {"effects", Sine(0.1)}},
                         {{"name", "a"}}};
       },
       {"effects[1]", "'a' is duplicated"}},
      {[](Json& j) {
         j["effects"] = {{{"name", "a"}, {"effects", {{"valves", 1}}}}};
       },
       {"effects[0].effects", "valves"}},
      {[&](Json& j) {
         j["effects"] = {{{"name", "a"}, {"file", path}}};
       },
       {"effects[0].file", path, "outputs[0].sines[0].period"}},
      {[&](Json& j) {
         j["effects"] = {
             {{"name", "a"}, {"file", path}, {"effects", Sine(0.1)}}};
       },
       {"effects[0]", "only one"}},
      {[](Json& j) {
         j["effects"] = {{{"name", "a"}, {"file", "no/such.json"}}};
       },
       {"effects[0].file", "no/such.json"}},
  });
}

TEST(CampaignTest, ControllersWindowsAndMethods) {
  ExpectRefused({
      {[](Json& j) {
         j["controllers"] = {{{"name", "a"}, {"control_horizon", 50}}};
       },
       {"controller 'a'", "control_horizon=50", "prediction_horizon"}},
      {[](Json& j) {
         j["controllers"] = {{{"name", "a"}, {"output_weight", {1, 2, 3}}}};
       },
       {"controller 'a'", "output_weight", "3 values"}},
      {[](Json& j) { j["windows"][0]["window"] = 200; },
       {"windows 'short'", "window=200"}},
      {[](Json& j) { j["windows"][0]["outlier_share"] = 0.6; },
       {"windows[0].outlier_share", "0.6"}},
      {[](Json& j) { j["windows"][0]["longest_outlier"] = 2; },
       {"windows[0].longest_outlier", "at least 3"}},
      {[](Json& j) { j["windows"][0]["robust"] = "tukey"; },
       {"windows[0].robust", "tukey", "cauchy"}},
      {[](Json& j) { j["windows"][0]["spacing"] = 500; },
       {"windows[0].spacing", "changes"}},
      {[](Json& j) {
         j["windows"] = {{{"name", "w"},
                          {"changes", 3},
                          {"window", 100},
                          {"spacing", 150}}};
       },
       {"windows[0].spacing", "≥ 200"}},
      {[](Json& j) {
         j["windows"] = {{{"name", "w"}, {"changes", 1}, {"window", 100}}};
       },
       {"'paper'", "two set-point changes, one to leave out, not 1"}},
      {[](Json& j) {
         j["estimators"] = {"arx", "magic"};
       },
       {"estimators[1]", "magic", "output_error"}},
      {[](Json& j) {
         j["estimators"] = {"arx", "arx"};
       },
       {"estimators[1]", "is duplicated"}},
      {[](Json& j) {
         j["estimators"] = {"output_error", "output_error:calibrated"};
       },
       {"estimators[1]", "is duplicated"}},
      {[](Json& j) {
         j["estimators"] = {"arx:", "output_error"};
       },
       {"estimators[0]", "chi_square"}},
      {[](Json& j) {
         j["ablations"] = {"none", "no_conversion"};
       },
       {"ablations[1]", "no_conversion", "raw_scaling"}},
      {[](Json& j) {
         j["ablations"] = {"raw_scaling", "raw_scaling"};
       },
       {"ablations[1]", "is duplicated"}},
      {[](Json& j) { j["selections"] = {"best"}; },
       {"selections[0]", "best", "blocks"}},
      {[](Json& j) { j["solvers"] = {"simplex"}; },
       {"solvers[0]", "simplex", "homotopy"}},
      {[](Json& j) {
         j["solvers"] = {{{"name", "e"}, {"elastic_net", 0.5}}};
       },
       {"solvers[0]", "λ above 0"}},
      {[](Json& j) {
         j["lambda_grid"] = {{"max", 1}, {"step", 2}};
       },
       {"lambda_grid", "step"}},
      {[](Json& j) {
         j["lambda_grid"] = {{"min", 2}, {"max", 1}, {"count", 3}};
       },
       {"lambda_grid.max", "> 2"}},
  });
}

TEST(CampaignTest, TextThatIsNoJson) {
  const auto resolved = ResolveCampaign("{\"name\": 1,}", "c.json", "");
  ASSERT_FALSE(resolved.ok());
  EXPECT_THAT(std::string(resolved.status().message()),
              HasSubstr("c.json: line 1"));
}

TEST(CampaignTest, AGridTooLargeToCount) {
  Json json = SmallCampaign(1'000'000);
  std::vector<double> sizes;
  for (int i = 1; i <= 3000; ++i) sizes.push_back(i * 1e-3);
  json["mismatches"][0]["sizes"] = sizes;
  const absl::StatusOr<Campaign> campaign = Parse(json);
  ASSERT_FALSE(campaign.ok());
  EXPECT_THAT(std::string(campaign.status().message()),
              HasSubstr("more than 1e9 runs"));
}

TEST(CampaignTest, TheExamplesAreCampaigns) {
  int examples = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(MLE_SOURCE_FOLDER "/configs")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("campaign_")) continue;
    ++examples;
    const auto study = ReadStudy(*ReadFile(entry.path().string()), name,
                                 entry.path().parent_path().string());
    EXPECT_TRUE(study.ok()) << study.status();
  }
  EXPECT_GE(examples, 2);
}

}  // namespace
}  // namespace mle::experiment
