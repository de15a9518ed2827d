#include "mle/correction/selection.h"

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/correction/correction.h"
#include "mle/correction/response_risk.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using Rule = SelectionOptions::Rule;

// Two windows of a plant one of whose gains changed.
Correction TwoWindows(const SelectionOptions& selection = {},
                      double lambda_max = 0.4) {
  ArxModel believed = SparseArx();
  believed.R(0, 2) = 0.6;
  CorrectionOptions options;
  options.lambdas = *MakeLambdaGrid(lambda_max, lambda_max / 400.0);
  options.selection = selection;
  auto correction =
      CorrectModel(believed,
                   {SimulateArx(SparseArx(), 200, 0.3, 1, 2.0, 1.0),
                    SimulateArx(SparseArx(), 240, 0.3, 2, 2.0, 1.0)},
                   options);
  EXPECT_TRUE(correction.ok()) << correction.status();
  return *std::move(correction);
}

SelectionSummary Select(Correction correction,
                        const SelectionOptions& options) {
  const absl::Status selected = correction.Select(options);
  EXPECT_TRUE(selected.ok()) << selected;
  return correction.selection();
}

TEST(SelectLambdaTest, TakesTheLeastLoss) {
  const Correction correction = TwoWindows();
  for (const Rule rule : {Rule::kLeaveChangeOut, Rule::kBlocks}) {
    const SelectionSummary grid =
        Select(correction, {.rule = rule, .on_grid = true});
    Eigen::Index best = 0;
    const double least = grid.loss.minCoeff(&best);
    EXPECT_EQ(grid.lambda_star, Eigen::Vector2d::Constant(grid.lambdas(best)));
    EXPECT_GT(grid.lambda_star(0), 0.0);
    EXPECT_LT(least, 0.9 * grid.loss(400));
    grid.penalised_loss.minCoeff(&best);
    EXPECT_EQ(grid.lambda_star_penalised, grid.lambdas(best));
    // Over all λ ≥ 0 the same but for a step of the grid, as the loss has one
    // valley here.
    const SelectionSummary exact = Select(correction, {.rule = rule});
    EXPECT_NEAR(exact.lambda_star(0), grid.lambda_star(0), 1e-3);
    EXPECT_EQ(exact.loss, grid.loss);
  }
}

// The first of no correction, least loss and least Ê whose Ê is within the
// deviations of the least.
TEST(SelectLambdaTest, TheStepResponsesCheckTheProposal) {
  const Correction correction = TwoWindows();
  const auto chosen = [&](double deviations) {
    return Select(correction, {.response_deviations = deviations});
  };
  const SelectionSummary checked = chosen(2.0);
  const double proposed = chosen(0.0).lambda_star(0);
  EXPECT_EQ(chosen(0.0).response_risk.size(), 0);
  ASSERT_GT(checked.response_risk.size(), 5);
  Eigen::Index best = 0;
  const double least = checked.response_risk.minCoeff(&best);
  const double best_lambda = checked.response_lambdas(best);
  ASSERT_LT(best_lambda, proposed);
  const auto risk =
      ResponseRisk::Create(correction.initial(), correction.problem(), {}, 13);
  ASSERT_TRUE(risk.has_value());
  EXPECT_EQ(checked.response_deviation, risk->deviation());
  EXPECT_DOUBLE_EQ((*risk)(correction.fits(), best_lambda), least);
  // The proposal is refused just below the deviations that it needs.
  const double needed =
      ((*risk)(correction.fits(), proposed) - least) / risk->deviation();
  ASSERT_GT(needed, 0.0);
  EXPECT_EQ(chosen(0.999 * needed).lambda_star(0), best_lambda);
  EXPECT_EQ(chosen(1.001 * needed).lambda_star(0), proposed);
  // The gain that has changed is far beyond the noise; anything goes if enough
  // deviations may.
  const double none = correction.fits()[0].path.lambda_begin();
  EXPECT_EQ(chosen(1e9).lambda_star(0), none);
  EXPECT_TRUE(correction.Model(none).R == correction.initial().R);
}

TEST(SelectLambdaTest, ARightModelIsLeftAlone) {
  int corrected = 0;
  for (int seed = 1; seed <= 20; ++seed) {
    CorrectionOptions options;
    options.lambdas = *MakeLambdaGrid(0.4, 0.001);
    const auto correction = CorrectModel(
        SparseArx(), {SimulateArx(SparseArx(), 300, 0.3, seed)}, options);
    ASSERT_TRUE(correction.ok()) << correction.status();
    corrected += correction->Model().R != SparseArx().R ? 1 : 0;
  }
  EXPECT_LE(corrected, 1);
}

TEST(SelectLambdaTest, OneStandardErrorIsLarger) {
  const Correction correction = TwoWindows();
  const double least = Select(correction, {.on_grid = true}).lambda_star(0);
  const double more =
      Select(correction, {.one_standard_error = true}).lambda_star(0);
  EXPECT_GT(more, least);
  EXPECT_LT(more, 0.4);
}

TEST(SelectLambdaTest, EachOutputMayHaveItsOwn) {
  const Correction correction = TwoWindows();
  for (const Rule rule : {Rule::kLeaveChangeOut, Rule::kBlocks, Rule::kBic}) {
    const SelectionSummary both = Select(correction, {.rule = rule});
    EXPECT_EQ(both.lambda_star(0), both.lambda_star(1));
    const SelectionSummary each =
        Select(correction, {.rule = rule, .per_output = true});
    // Nothing is wrong with the second output: it wants the larger penalty.
    EXPECT_GT(each.lambda_star(1), each.lambda_star(0));
  }
}

// BIC's penalty on a coefficient is log N ≥ 2 times AIC's.
TEST(SelectLambdaTest, BicTakesNoMoreCoefficientsThanAic) {
  const Correction correction = TwoWindows();
  const double aic = Select(correction, {.rule = Rule::kAic}).lambda_star(0);
  const double bic = Select(correction, {.rule = Rule::kBic}).lambda_star(0);
  EXPECT_GE(bic, aic);
  const Eigen::MatrixXd change =
      correction.Model(bic).R - correction.Model(1e3).R;
  EXPECT_NEAR(change(0, 2), 0.4, 0.1);
}

// N log(RSS/N) + 2 df, with log N for 2, and N log of RSS/N / (1 − df/N)², from
// the fits' coefficients.
TEST(SelectLambdaTest, CriteriaAreThoseOfTheBook) {
  const Correction correction = TwoWindows();
  const LassoProblem& problem = correction.problem();
  const double rows = static_cast<double>(problem.rows);
  for (const Rule rule : {Rule::kAic, Rule::kBic, Rule::kGcv}) {
    const SelectionSummary summary = Select(correction, {.rule = rule});
    ASSERT_EQ(summary.loss.size(), summary.lambdas.size());
    for (Eigen::Index i = 0; i < summary.lambdas.size(); i += 7) {
      double expected = 0.0;
      for (int q = 0; q < 2; ++q) {
        const Eigen::VectorXd beta =
            correction.fits()[q].path.Coefficients(summary.lambdas(i));
        const double mean_square = problem.response_square(q) -
                                   2.0 * beta.dot(problem.correlation.col(q)) +
                                   beta.dot(problem.gram * beta);
        const auto df = static_cast<double>((beta.array() != 0.0).count());
        expected += rows * std::log(mean_square);
        if (rule == Rule::kAic) expected += 2.0 * df;
        if (rule == Rule::kBic) expected += std::log(rows) * df;
        if (rule == Rule::kGcv) {
          expected -= 2.0 * rows * std::log(1.0 - df / rows);
        }
      }
      EXPECT_NEAR(summary.loss(i), expected, 1e-6 * std::abs(expected))
          << "λ = " << summary.lambdas(i);
    }
  }
}

// The losses of two phases are those of each, added.
TEST(SelectLambdaTest, PhasesAddUp) {
  const Correction correction = TwoWindows();
  for (const int horizon : {1, 5}) {
    const SelectionOptions one{
        .phases = 1, .horizon = horizon, .on_grid = true};
    const SelectionOptions two{
        .phases = 2, .horizon = horizon, .on_grid = true};
    const Eigen::VectorXd first = Select(correction, one).loss;
    const SelectionSummary both = Select(correction, two);
    const Eigen::VectorXd second = both.loss - first;
    ASSERT_EQ(first.size(), second.size());
    EXPECT_FALSE(second.isApprox(first, 1e-6));
    // The noise is alike.
    EXPECT_TRUE(second.isApprox(first, 0.2));
  }
}

// Blocks of eight samples are cut in eight ways.
TEST(SelectLambdaTest, NoPhaseIsTakenTwice) {
  const Correction correction = TwoWindows();
  const auto losses = [&](int phases) {
    return Select(correction, {.block_length = 8, .phases = phases}).loss;
  };
  EXPECT_EQ(losses(8), losses(2'147'483'647));
}

TEST(SelectLambdaTest, PredictsFurtherAhead) {
  const Correction correction = TwoWindows();
  for (const int horizon : {0, 2, 30}) {
    const SelectionSummary summary = Select(correction, {.horizon = horizon});
    EXPECT_TRUE(summary.loss.allFinite());
    EXPECT_EQ(summary.lambdas(summary.lambdas.size() - 1), 0.4);
    EXPECT_LT(summary.lambdas.size(), 100);
    const Eigen::MatrixXd change =
        correction.Model(summary.lambda_star).R - correction.Model(1e3).R;
    EXPECT_NEAR(change(0, 2), 0.4, 0.1) << "horizon " << horizon;
  }
}

// Above every λ_max the loss is flat, and the largest λ stands for "nothing".
TEST(SelectLambdaTest, OfEqualLossesTakesTheLargestLambda) {
  ArxModel believed = SparseArx();
  CorrectionOptions options;
  options.lambdas = Eigen::VectorXd::LinSpaced(5, 100.0, 104.0);
  options.selection.on_grid = true;
  const auto correction = CorrectModel(believed,
                                       {SimulateArx(SparseArx(), 200, 0.3, 1),
                                        SimulateArx(SparseArx(), 200, 0.3, 2)},
                                       options);
  ASSERT_TRUE(correction.ok()) << correction.status();
  EXPECT_EQ(correction->selection().lambda_star,
            Eigen::Vector2d::Constant(104.0));
}

// An unstable fit that is simulated to infinity is no choice, and no NaN.
TEST(SelectLambdaTest, AnUnstableFitIsNotChosen) {
  ArxModel unstable = SparseArx();
  unstable.R(0, 0) = 1.9;
  CorrectionOptions options;
  // The grid's end corrects nothing: it leaves 1.9 as it is.
  options.lambdas = *MakeLambdaGrid(100.0, 0.02);
  options.selection.horizon = 0;
  const auto correction = CorrectModel(unstable,
                                       {SimulateArx(SparseArx(), 1600, 0.3, 1),
                                        SimulateArx(SparseArx(), 1600, 0.3, 2)},
                                       options);
  ASSERT_TRUE(correction.ok()) << correction.status();
  const SelectionSummary& selection = correction->selection();
  for (const double loss : selection.loss) EXPECT_FALSE(std::isnan(loss));
  EXPECT_LT(selection.lambda_star(0), 1.0);
  EXPECT_NEAR(correction->Model().R(0, 0), 0.7, 0.1);
}

TEST(SelectionOptionsTest, ValidateSaysWhatIsWrong) {
  const auto message = [](const SelectionOptions& options) {
    return std::string(options.Validate().message());
  };
  EXPECT_EQ(message({}), "");
  EXPECT_THAT(message({.folds = 1}), HasSubstr("folds is 1"));
  EXPECT_THAT(message({.block_length = -1}), HasSubstr("block_length is -1"));
  EXPECT_THAT(message({.phases = 0}), HasSubstr("phases is 0"));
  EXPECT_THAT(message({.horizon = -2}), HasSubstr("horizon is -2"));
}

TEST(SelectLambdaTest, OneFoldIsAnError) {
  const auto message = [](const SelectionOptions& selection) {
    CorrectionOptions options;
    options.lambdas = *MakeLambdaGrid(0.1, 0.01);
    options.selection = selection;
    const auto correction = CorrectModel(
        SparseArx(), {SimulateArx(SparseArx(), 60, 0.3, 1)}, options);
    EXPECT_EQ(correction.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(correction.status().message());
  };
  EXPECT_THAT(message({.rule = Rule::kLeaveChangeOut}),
              HasSubstr("1 set-point change"));
  EXPECT_THAT(message({.rule = Rule::kBlocks, .block_length = 40}),
              HasSubstr("single block"));
}

}  // namespace
}  // namespace mle
