#include "mle/maintain/decision.h"

#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace mle {
namespace {

struct Row {
  const char* name;
  bool change_proposed;
  std::optional<double> gain;
  double least_gain;
  bool require_hold_out;
  Decision decision;
  MessageCode last_reason;
};

// Every row of the table in decision.h.
const Row kTable[] = {
    {"nothing proposed", false, std::nullopt, 0.0, true, Decision::kNoChange,
     MessageCode::kNoChangeFound},
    {"nothing proposed, whatever was held out", false, 100.0, 0.0, true,
     Decision::kNoChange, MessageCode::kNoChangeFound},
    {"nothing held out", true, std::nullopt, 0.0, true, Decision::kRefused,
     MessageCode::kNothingHeldOut},
    {"nothing held out, nothing asked for", true, std::nullopt, 0.0, false,
     Decision::kCorrected, MessageCode::kNothingHeldOut},
    {"predicts worse", true, -1e-9, 0.0, true, Decision::kRefused,
     MessageCode::kPredictsWorse},
    {"predicts as well", true, 0.0, 0.0, true, Decision::kRefused,
     MessageCode::kPredictsWorse},
    {"predicts worse, though holding out was not asked for", true, -1.0, 0.0,
     false, Decision::kRefused, MessageCode::kPredictsWorse},
    {"predicts better", true, 1e-9, 0.0, true, Decision::kCorrected,
     MessageCode::kPredictsBetter},
    {"predicts better by less than asked for", true, 3.0, 3.0, true,
     Decision::kRefused, MessageCode::kPredictsWorse},
    {"predicts better by more than asked for", true, 3.1, 3.0, true,
     Decision::kCorrected, MessageCode::kPredictsBetter},
    {"a gain that is not a number", true,
     std::numeric_limits<double>::quiet_NaN(), 0.0, true, Decision::kRefused,
     MessageCode::kPredictsWorse},
};

TEST(DecisionTest, EveryRowOfTheTable) {
  for (const Row& row : kTable) {
    const Verdict verdict = Decide({.change_proposed = row.change_proposed,
                                    .p_value = 0.5,
                                    .held_out_gain = row.gain},
                                   {.least_gain = row.least_gain,
                                    .require_hold_out = row.require_hold_out});
    EXPECT_EQ(verdict.decision, row.decision) << row.name;
    ASSERT_FALSE(verdict.reasons.empty()) << row.name;
    EXPECT_EQ(verdict.reasons.back().code, row.last_reason) << row.name;
  }
}

TEST(DecisionTest, AChangeIsTheFirstReason) {
  const Verdict verdict = Decide(
      {.change_proposed = true, .p_value = 1.0, .held_out_gain = {}}, {});
  ASSERT_EQ(verdict.reasons.size(), 2);
  EXPECT_EQ(verdict.reasons.front().code, MessageCode::kChangeProved);
}

TEST(DecisionTest, OptionsNameTheFieldThatIsWrong) {
  for (const double wrong : {-1.0, std::numeric_limits<double>::infinity(),
                             std::numeric_limits<double>::quiet_NaN()}) {
    const absl::Status status = DecisionOptions{.least_gain = wrong}.Validate();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    EXPECT_NE(status.message().find("least_gain"), std::string::npos);
  }
  EXPECT_TRUE(DecisionOptions().Validate().ok());
}

TEST(DecisionTest, NamesAreThoseOfTheFile) {
  EXPECT_EQ(NameOf(Decision::kNoChange), "no_change");
  EXPECT_EQ(NameOf(Decision::kCorrected), "corrected");
  EXPECT_EQ(NameOf(Decision::kRefused), "refused");
}

}  // namespace
}  // namespace mle
