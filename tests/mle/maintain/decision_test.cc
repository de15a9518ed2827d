#include "mle/maintain/decision.h"

#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "mle/base/double_limits.h"

namespace mle {
namespace {

HorizonScore Score(double gain, double error) {
  return {.initial = 80.0, .corrected = 85.0, .gain = gain, .error = error};
}

OutputScores Scores(double one_step, double several, double simulated,
                    double error = 0.1) {
  return {Score(one_step, error), Score(several, error),
          Score(simulated, error)};
}

const OutputScores kGood = Scores(0.3, 0.5, 0.9);
const OutputScores kSame = Scores(0.05, -0.05, 0.1);
const OutputScores kFalls = Scores(0.3, 0.5, -0.3);

// Everything gains, but the simulation stays as bad as a constant, or worse.
OutputScores Simulating(double corrected) {
  OutputScores scores = kGood;
  scores.simulated.initial = corrected - 900.0;
  scores.simulated.corrected = corrected;
  return scores;
}

OutputEvidence Output(std::optional<OutputScores> scores) {
  OutputEvidence output;
  output.name = "T";
  output.proposed = true;
  output.scores = scores;
  return output;
}

Evidence Of(std::vector<OutputEvidence> outputs) {
  Evidence evidence;
  evidence.change_proved = true;
  evidence.outputs = std::move(outputs);
  return evidence;
}

// Whether a reason of this code stands somewhere.
bool Says(const Verdict& verdict, MessageCode code) {
  for (const Message& reason : verdict.reasons) {
    if (reason.code == code) return true;
  }
  return false;
}

// A probability below the least of all doubles is not told as nought.
TEST(DecisionTest, TheProbabilityOfNoChangeIsToldAsFarAsItIsKnown) {
  Evidence evidence = Of({Output(kGood)});
  for (const auto& [p_value, told] :
       {std::pair<double, const char*>{0.0, "(p < 1e-300 for no change)"},
        {1e-310, "(p < 1e-300 for no change)"},
        {2e-300, "(p = 2.0e-300 for no change)"},
        {0.01, "(p = 0.010 for no change)"}}) {
    evidence.p_value = p_value;
    EXPECT_TRUE(Says(Decide(evidence, {}), MessageCode::kChangeProved));
    for (const Message& reason : Decide(evidence, {}).reasons) {
      if (reason.code != MessageCode::kChangeProved) continue;
      EXPECT_NE(reason.text.find(told), std::string::npos) << reason.text;
    }
  }
}

TEST(DecisionTest, EveryRowOfTheTableOfOutputs) {
  struct Row {
    const char* name;
    OutputEvidence output;
    Acceptance acceptance;
    Decision decision;
    MessageCode reason;
  };
  const Row rows[] = {
      {"nothing held out", Output({}), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kNothingHeldOut},
      {"gains everywhere", Output(kGood), Acceptance::kProposal,
       Decision::kCorrected, MessageCode::kPredictsBetter},
      {"gains somewhere", Output(Scores(0.0, 0.0, 0.3)), Acceptance::kProposal,
       Decision::kCorrected, MessageCode::kPredictsBetter},
      {"gains by two standard errors", Output(Scores(0.0, 0.2, 0.0)),
       Acceptance::kProposal, Decision::kCorrected,
       MessageCode::kPredictsBetter},
      {"gains by less", Output(Scores(0.0, 0.19, 0.0)), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kNotBetter},
      {"no better than chance", Output(kSame), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kNotBetter},
      {"gains in one step, by less than simulation loses",
       Output(Scores(0.3, 0.1, -0.4, 0.3)), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kNotBetter},
      {"a fifth more, whatever the others gain",
       Output(Scores(0.9, 0.9, -0.45, 0.3)), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kNotBetter},
      {"falls one step ahead", Output(Scores(-0.3, 0.5, 0.9)),
       Acceptance::kNothing, Decision::kCannotTell,
       MessageCode::kPredictsWorse},
      {"falls several steps ahead", Output(Scores(0.3, -0.3, 0.9)),
       Acceptance::kNothing, Decision::kCannotTell,
       MessageCode::kPredictsWorse},
      {"falls when simulated", Output(kFalls), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kPredictsWorse},
      {"not a number", Output(Scores(0.3, kNaN, 0.9)), Acceptance::kNothing,
       Decision::kCannotTell, MessageCode::kPredictsWorse},
      {"simulates worse than a constant", Output(Simulating(0.0)),
       Acceptance::kNothing, Decision::kCannotTell,
       MessageCode::kStructureDoubtful},
      {"simulates a little better than a constant", Output(Simulating(0.1)),
       Acceptance::kProposal, Decision::kCorrected,
       MessageCode::kPredictsBetter},
  };
  for (const Row& row : rows) {
    const Verdict verdict = Decide(Of({row.output}), {});
    EXPECT_EQ(verdict.decision, row.decision) << row.name;
    ASSERT_EQ(verdict.outputs.size(), 1) << row.name;
    EXPECT_EQ(verdict.outputs[0], row.acceptance) << row.name;
    EXPECT_EQ(verdict.reasons.front().code, MessageCode::kChangeProved)
        << row.name;
    EXPECT_EQ(verdict.reasons.back().code, row.reason) << row.name;
  }
}

TEST(DecisionTest, AWindowThatIsPredictedWorseIsDoubt) {
  OutputEvidence output = Output(kGood);
  output.windows = {kGood, kGood, kGood};
  EXPECT_EQ(Decide(Of({output}), {}).decision, Decision::kCorrected);
  output.windows[1] = Scores(0.3, 0.5, -0.3);
  const Verdict verdict = Decide(Of({output}), {});
  EXPECT_EQ(verdict.decision, Decision::kCannotTell);
  EXPECT_EQ(verdict.reasons.back().code, MessageCode::kWindowsDisagree);
  EXPECT_NE(verdict.reasons.back().text.find("window 2"), std::string::npos);
}

TEST(DecisionTest, OutputsThatAreDoubtedAreNotDecided) {
  Evidence evidence = Of({Output(kGood), OutputEvidence()});
  evidence.outputs[0].undecidable = true;
  evidence.outputs[1].name = "F";
  evidence.doubts = {{MessageCode::kStuckOutput, "F", "F is dead …", {}}};
  const Verdict verdict = Decide(evidence, {});
  EXPECT_EQ(verdict.decision, Decision::kCannotTell);
  EXPECT_EQ(verdict.outputs[0], Acceptance::kNothing);
  EXPECT_EQ(verdict.reasons.front().code, MessageCode::kStuckOutput);
  EXPECT_FALSE(Says(verdict, MessageCode::kPredictsBetter));
  // Others are, and the doubt is still said first.
  evidence.outputs[1] = Output(kGood);
  const Verdict other = Decide(evidence, {});
  EXPECT_EQ(other.decision, Decision::kCorrected);
  EXPECT_EQ(other.outputs[0], Acceptance::kNothing);
  EXPECT_EQ(other.outputs[1], Acceptance::kProposal);
  EXPECT_EQ(other.reasons.front().code, MessageCode::kStuckOutput);
}

TEST(DecisionTest, EveryRowOfTheTableOfJudgedOutputs) {
  struct Row {
    const char* name;
    InstrumentEvidence instruments;
    Acceptance acceptance;
    Decision decision;
    MessageCode reason;
  };
  const InstrumentEvidence better = {.ageing = true, .predicts_better = true};
  InstrumentEvidence tie = better;
  tie.tie = "Two explanations …";
  InstrumentEvidence allows = better;
  allows.allows_proposal = true;
  allows.simulated = 0.5;  // the proposal: 0.32
  InstrumentEvidence as_good = allows;
  as_good.simulated = 0.4;
  InstrumentEvidence beside = better;
  beside.other = "The valve …";
  const Row rows[] = {
      {"confirmed",
       {.confirms_proposal = true},
       Acceptance::kProposal,
       Decision::kCorrected,
       MessageCode::kPredictsBetter},
      {"ageing wins", better, Acceptance::kExplained, Decision::kCorrected,
       MessageCode::kPredictsBetter},
      {"a proposal that simulates better", allows, Acceptance::kProposal,
       Decision::kCorrected, MessageCode::kPredictsBetter},
      {"a proposal that simulates as well", as_good, Acceptance::kExplained,
       Decision::kCorrected, MessageCode::kPredictsBetter},
      {"ageing beside something else", beside, Acceptance::kExplained,
       Decision::kCorrected, MessageCode::kPredictsBetter},
      {"it predicts no better",
       {.ageing = true, .errors = "its error …"},
       Acceptance::kNothing,
       Decision::kCannotTell,
       MessageCode::kNotBetter},
      {"nothing could be held out",
       {.ageing = true},
       Acceptance::kNothing,
       Decision::kCannotTell,
       MessageCode::kNothingHeldOut},
      {"two explanations", tie, Acceptance::kNothing, Decision::kCannotTell,
       MessageCode::kExplained},
      {"something else",
       {.other = "A clock …", .code = MessageCode::kClock},
       Acceptance::kNothing,
       Decision::kCannotTell,
       MessageCode::kClock},
      {"much is left",
       {.left = 3.5},
       Acceptance::kNothing,
       Decision::kCannotTell,
       MessageCode::kMissingExplanation},
      {"not confirmed",
       {.left = 1.0},
       Acceptance::kNothing,
       Decision::kCannotTell,
       MessageCode::kNotConfirmed},
      {"not confirmed, and the inputs answer",
       {.by_set_points = false, .feedback_p_value = 1e-4, .left = 1.0},
       Acceptance::kNothing,
       Decision::kCannotTell,
       MessageCode::kNotConfirmed},
      {"refuted",
       {.refutes_proposal = true},
       Acceptance::kNothing,
       Decision::kNoChange,
       MessageCode::kSetPointsAgree}};
  for (const Row& row : rows) {
    OutputEvidence output = Output(kGood);
    output.instruments = row.instruments;
    const Verdict verdict = Decide(Of({output}), {});
    EXPECT_EQ(verdict.decision, row.decision) << row.name;
    EXPECT_EQ(verdict.outputs[0], row.acceptance) << row.name;
    EXPECT_EQ(verdict.reasons.back().code, row.reason) << row.name;
  }
}

TEST(DecisionTest, HorizonsFallTogether) {
  EXPECT_TRUE(FallTogether({0.9, 1.02}, 1.05));
  EXPECT_FALSE(FallTogether({0.99, 1.04}, 1.05));  // not in the mean
  EXPECT_FALSE(FallTogether({0.5, 1.06}, 1.05));   // one is worse
  EXPECT_FALSE(FallTogether({0.5, kNaN}, 1.05));
}

// Where set points do not judge no horizon may grow by more than a twentieth.
TEST(DecisionTest, WhatIsHeldOutIsMoreStrictAsTheOnlyJudge) {
  for (const bool by_set_points : {true, false}) {
    OutputEvidence output = Output(Scores(0.3, 0.5, -0.2, 0.15));
    output.instruments = {.by_set_points = by_set_points,
                          .confirms_proposal = true};
    EXPECT_EQ(Decide(Of({output}), {}).outputs[0],
              by_set_points ? Acceptance::kProposal : Acceptance::kNothing);
  }
}

TEST(DecisionTest, OneOfManyWindowsMayFallALittle) {
  // 2.2 standard errors: beyond two, but one of twelve windows falls so far by
  // chance in one of six records.
  OutputEvidence output = Output(kGood);
  output.windows.assign(12, kGood);
  output.windows[5] = Scores(0.3, 0.5, -0.22);
  EXPECT_EQ(Decide(Of({output}), {}).decision, Decision::kCorrected);
}

TEST(DecisionTest, AnOutputThatIsSureIsDeliveredBesideOneThatIsNot) {
  const Verdict verdict = Decide(Of({Output(kFalls), Output(kGood)}), {});
  EXPECT_EQ(verdict.decision, Decision::kCorrected);
  EXPECT_EQ(verdict.outputs, (std::vector<Acceptance>{Acceptance::kNothing,
                                                      Acceptance::kProposal}));
  EXPECT_TRUE(Says(verdict, MessageCode::kPredictsWorse));
  EXPECT_TRUE(Says(verdict, MessageCode::kPredictsBetter));
}

TEST(DecisionTest, EveryRowOfTheTableOfPlants) {
  OutputEvidence quiet;
  quiet.name = "T";
  Evidence evidence;
  evidence.outputs = {quiet};
  evidence.detectable = "A change by 3 % would have been seen.";
  Verdict verdict = Decide(evidence, {});
  EXPECT_EQ(verdict.decision, Decision::kNoChange);
  EXPECT_EQ(verdict.reasons.front().code, MessageCode::kNoChangeFound);
  EXPECT_NE(verdict.reasons.front().text.find(evidence.detectable),
            std::string::npos);

  // What differs and no change explains is said to differ.
  quiet.instruments = InstrumentEvidence{.left = 1.0};
  evidence.outputs = {quiet};
  evidence.p_value = 1e-9;
  EXPECT_EQ(Decide(evidence, {}).reasons.front().code,
            MessageCode::kSetPointsAgree);
  evidence.p_value = 0.3;
  EXPECT_EQ(Decide(evidence, {}).reasons.front().code,
            MessageCode::kNoChangeFound);

  evidence.uninformed = "The inputs do not move.";
  verdict = Decide(evidence, {});
  EXPECT_EQ(verdict.decision, Decision::kCannotTell);
  EXPECT_EQ(verdict.reasons.front().code, MessageCode::kNotExcited);

  evidence.change_proved = true;  // and taken back: too small
  verdict = Decide(evidence, {});
  EXPECT_EQ(verdict.decision, Decision::kNoChange);
  EXPECT_EQ(verdict.reasons.front().code, MessageCode::kChangeTooSmall);

  evidence.outputs = {Output(kGood)};
  evidence.obstacles = {{MessageCode::kChannel, "T", "T is dead.", {}}};
  verdict = Decide(evidence, {});
  EXPECT_EQ(verdict.decision, Decision::kCannotTell);
  EXPECT_EQ(verdict.reasons.front().code, MessageCode::kChannel);
  EXPECT_EQ(verdict.outputs[0], Acceptance::kNothing);
}

TEST(DecisionTest, WithoutHoldOutOnlyWhereItIsNotRequired) {
  const Verdict verdict = Decide(Of({Output({})}), {.require_hold_out = false});
  EXPECT_EQ(verdict.decision, Decision::kCorrected);
  EXPECT_EQ(verdict.outputs[0], Acceptance::kProposal);
}

TEST(DecisionTest, DeviationsMoveTheLimit) {
  const Evidence evidence = Of({Output(Scores(0.0, 0.0, 0.25))});
  EXPECT_EQ(Decide(evidence, {.deviations = 2.4}).decision,
            Decision::kCorrected);
  EXPECT_EQ(Decide(evidence, {.deviations = 2.6}).decision,
            Decision::kCannotTell);
}

TEST(DecisionTest, OptionsNameTheFieldThatIsWrong) {
  const auto expect = [](const DecisionOptions& options, const char* field) {
    const absl::Status status = options.Validate();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << field;
    EXPECT_NE(status.message().find(field), std::string::npos) << field;
  };
  for (const double wrong : {-1.0, 0.0, kNaN}) {
    expect({.deviations = wrong}, "deviations");
  }
  for (const double wrong : {-0.1, 1.0, kNaN}) {
    expect({.least_change = wrong}, "least_change");
  }
  EXPECT_TRUE(DecisionOptions().Validate().ok());
}

TEST(DecisionTest, NamesAreThoseOfTheFile) {
  EXPECT_EQ(NameOf(Decision::kNoChange), "no_change");
  EXPECT_EQ(NameOf(Decision::kCorrected), "corrected");
  EXPECT_EQ(NameOf(Decision::kCannotTell), "cannot_tell");
}

}  // namespace
}  // namespace mle
