#include "apps/lifecycle/store.h"

#include <cmath>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/apps/lifecycle/small_scenario.h"

namespace mle::lifecycle {
namespace {

using testing::Fouling;
using ::testing::HasSubstr;
using testing::NoisyTank;
using testing::TankLife;
using testing::TankScenario;

const LifeKey& Key() {
  static const LifeKey* const key = new LifeKey{"on_demand:0.9", 0.1, 7};
  return *key;
}

const Settings& SomeSettings() {
  static const Settings* const settings =
      new Settings{{"years", "5"}, {"file", "{\"a\": \"µ\"}\n"}};
  return *settings;
}

Life SomeLife() {
  absl::StatusOr<Life> life =
      LiveThrough(TankScenario(8, Fouling(0.5, 16000.0)),
                  ParsePolicies("on_demand:0.9")->front(),
                  TankLife(NoisyTank()), [] { return false; });
  EXPECT_TRUE(life.ok()) << life.status();
  return *std::move(life);
}

TEST(StoreTest, NothingIsLostOnTheWay) {
  const Life life = SomeLife();
  const std::string text = FormatLife(Key(), SomeSettings(), life);
  const auto read = ParseLife(text, "life.json", Key(), SomeSettings());
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_TRUE(read->has_value());
  const Life& again = **read;
  ASSERT_EQ(again.rows.size(), life.rows.size());
  for (std::size_t k = 0; k < life.rows.size(); ++k) {
    EXPECT_EQ(again.rows[k].Total().squared_error,
              life.rows[k].Total().squared_error);
    EXPECT_EQ(again.rows[k].outcome, life.rows[k].outcome);
    EXPECT_EQ(std::isnan(again.rows[k].index), std::isnan(life.rows[k].index));
  }
  EXPECT_EQ(FormatLife(Key(), SomeSettings(), again), text);
}

TEST(StoreTest, OtherSettingsAreNotTakenForTheSame) {
  const std::string text = FormatLife(Key(), SomeSettings(), SomeLife());
  Settings other = SomeSettings();
  other["years"] = "6";
  EXPECT_FALSE(ParseLife(text, "life.json", Key(), other)->has_value());
  LifeKey key = Key();
  key.seed = 8;
  EXPECT_FALSE(ParseLife(text, "life.json", key, SomeSettings())->has_value());
  key = Key();
  key.ageing_rate = std::nextafter(0.1, 1.0);
  EXPECT_FALSE(ParseLife(text, "life.json", key, SomeSettings())->has_value());
}

TEST(StoreTest, ADamagedLifeIsNamed) {
  const std::string text = FormatLife(Key(), SomeSettings(), SomeLife());
  std::vector<std::string> damaged = {"{", "[]", "null", "{\"version\": 2}",
                                      text.substr(0, text.size() / 2)};
  // Every digit is guarded, those of the version and of the settings too.
  damaged.push_back(
      absl::StrReplaceAll(text, {{"\"version\": 2", "\"version\": 3"}}));
  for (std::size_t at = text.find("\"seed\"");
       (at = text.find_first_of("0123456789", at + 97)) != std::string::npos;) {
    damaged.push_back(text);
    damaged.back()[at] = text[at] == '3' ? '4' : '3';
  }
  ASSERT_GT(damaged.size(), 50u);
  for (const std::string& wrong : damaged) {
    const auto read = ParseLife(wrong, "life.json", Key(), SomeSettings());
    ASSERT_TRUE(absl::IsDataLoss(read.status())) << read.status();
    EXPECT_THAT(std::string(read.status().message()), HasSubstr("life.json"));
  }
}

TEST(StoreTest, ALifeWithoutAChecksumIsMadeAnew) {
  std::string text = FormatLife(Key(), SomeSettings(), SomeLife());
  text.erase(text.rfind(",\n \"sha256\""));
  text += "\n}\n";
  EXPECT_TRUE(absl::IsDataLoss(
      ParseLife(text, "life.json", Key(), SomeSettings()).status()));
  const std::size_t version = text.find("\"version\": 2");
  ASSERT_NE(version, std::string::npos);
  text[version + 11] = '1';
  const auto read = ParseLife(text, "life.json", Key(), SomeSettings());
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_FALSE(read->has_value());
}

TEST(StoreTest, FilesOfDifferentLivesHaveDifferentNames) {
  EXPECT_EQ(Key().FileName(), "on_demand-0.9_rate0.1_seed7.json");
  EXPECT_FALSE(LoadLife("/nonexistent", Key(), SomeSettings())->has_value());
}

}  // namespace
}  // namespace mle::lifecycle
