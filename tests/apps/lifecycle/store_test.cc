#include <cmath>
#include <string>

#include "apps/lifecycle/campaign.h"
#include "gtest/gtest.h"
#include "tests/apps/lifecycle/small_scenario.h"

namespace mle::lifecycle {
namespace {

using testing::Fouling;
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
  const std::string start = Key().LineStart(SomeSettings());
  const std::string line = FormatLife(start, life);
  EXPECT_TRUE(line.starts_with(start + "{"));
  EXPECT_EQ(line.find('\n'), std::string::npos);
  const absl::StatusOr<Life> again = ParseLife(line);
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_EQ(again->rows.size(), life.rows.size());
  for (std::size_t k = 0; k < life.rows.size(); ++k) {
    EXPECT_EQ(again->rows[k].Total().squared_error,
              life.rows[k].Total().squared_error);
    EXPECT_EQ(again->rows[k].outcome, life.rows[k].outcome);
    EXPECT_EQ(std::isnan(again->rows[k].index), std::isnan(life.rows[k].index));
  }
  EXPECT_EQ(FormatLife(start, *again), line);
}

TEST(StoreTest, LinesOfOtherLivesBeginOtherwise) {
  const std::string start = Key().LineStart(SomeSettings());
  Settings other = SomeSettings();
  other["years"] = "6";
  EXPECT_NE(Key().LineStart(other), start);
  LifeKey key = Key();
  key.seed = 8;
  EXPECT_NE(key.LineStart(SomeSettings()), start);
  key = Key();
  key.policy = "on_demand:0.8";
  EXPECT_NE(key.LineStart(SomeSettings()), start);
  key = Key();
  key.ageing_rate = std::nextafter(0.1, 1.0);
  EXPECT_NE(key.LineStart(SomeSettings()), start);
}

TEST(StoreTest, WhatIsNotALifeIsDamaged) {
  const std::string line = FormatLife("", SomeLife());
  for (const std::string& wrong :
       {std::string(), std::string("{"), std::string("a,b"), std::string("{}"),
        line.substr(0, line.size() / 2),
        std::string("{\"ended\": \"\", \"rows\": [{}]}")}) {
    EXPECT_TRUE(absl::IsDataLoss(ParseLife(wrong).status())) << wrong;
  }
}

}  // namespace
}  // namespace mle::lifecycle
