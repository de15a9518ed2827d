// The paper's two cases with the paper's settings, one seed, whole: the
// correction must reach what the method can do.

#include <cmath>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/apps/command_runner.h"

namespace mle {
namespace {

constexpr double kSampleTime = 0.2;
constexpr int kSamples = 501;  // 100 min

struct Fopdt {
  double gain;
  double time_constant;
  double delay;
};

double StepResponse(const Fopdt& element, double time) {
  if (time <= element.delay) return 0.0;
  return element.gain *
         (1.0 - std::exp(-(time - element.delay) / element.time_constant));
}

// E between two elements, from the closed form of their step responses.
double SquaredDistance(const Fopdt& a, const Fopdt& b) {
  double sum = 0.0;
  for (int k = 0; k < kSamples; ++k) {
    sum += std::pow(
        StepResponse(a, k * kSampleTime) - StepResponse(b, k * kSampleTime), 2);
  }
  return sum;
}

// The column of Wood and Berry (Chem. Eng. Sci. 28, 1973) and its two ageings.
constexpr Fopdt kPaperColumn[2][2] = {{{12.8, 16.7, 1.0}, {-18.9, 21.0, 3.0}},
                                      {{6.6, 10.9, 7.0}, {-19.4, 14.4, 3.0}}};
constexpr Fopdt kLessGain[2][2] = {{{6.4, 16.7, 1.0}, {-18.9, 21.0, 3.0}},
                                   {{3.3, 10.9, 7.0}, {-19.4, 14.4, 3.0}}};
constexpr Fopdt kMoreDelay[2][2] = {{{12.8, 16.7, 1.0}, {-18.9, 21.0, 7.0}},
                                    {{6.6, 10.9, 7.0}, {-19.4, 14.4, 7.0}}};

double InitialDistance(const Fopdt (&plant)[2][2]) {
  double sum = 0.0;
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j)
      sum += SquaredDistance(kPaperColumn[i][j], plant[i][j]);
  }
  return sum;
}

report::ProcessResult RunPaper(const std::string& folder,
                               const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {
      "--flagfile=" MLE_SOURCE_FOLDER "/configs/paper.flags", "--out=" + folder,
      "--figures=false", "--estimators="};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return RunTested(arguments);
}

// The bounds on E are about twice the worst of twenty seeds of an independent
// program (20.6 and 23.4). E of the models before correction is known in closed
// form, up to the rounding of exp.
void ExpectCorrected(const nlohmann::json& result, const Fopdt (&plant)[2][2],
                     double largest_E) {
  const double E_initial = InitialDistance(plant);
  EXPECT_NEAR(result["E_initial"].get<double>(), E_initial, 1e-9 * E_initial);
  const nlohmann::json& run = result["runs"][0];
  EXPECT_LT(run["E_star"].get<double>(), largest_E);
  EXPECT_LE(run["E_oracle"].get<double>(), run["E_star"].get<double>());
  EXPECT_LE(run["max_relative_duality_gap"].get<double>(), 1e-9);
}

TEST(MleReproducePaper, CorrectsBothCases) {
  const ScratchFolder scratch;
  const report::ProcessResult result = RunPaper(scratch / "out", {});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json results = ParsedJson(scratch / "out/results.json");
  ASSERT_EQ(results["cases"].size(), 2u);
  ASSERT_EQ(results["cases"][0]["name"], "gain");
  ASSERT_EQ(results["cases"][1]["name"], "delay");
  {
    SCOPED_TRACE("gain");
    EXPECT_NEAR(InitialDistance(kLessGain), 19363.0, 0.5);
    ExpectCorrected(results["cases"][0], kLessGain, 40.0);
  }
  {
    SCOPED_TRACE("delay");
    EXPECT_NEAR(InitialDistance(kMoreDelay), 1594.0, 0.5);
    ExpectCorrected(results["cases"][1], kMoreDelay, 45.0);
  }

  // The pairs that aged, by the step response and by a fit to it. The gains
  // were halved, by 6.4 and 3.3; the dead times grew by 4 min.
  const nlohmann::json& gain = results["cases"][0]["runs"][0];
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(gain["static_gain_error"][i][0].get<double>(), 0.0, 0.1);
    EXPECT_NEAR(gain["fopdt"][i][0]["gain"].get<double>(), kLessGain[i][0].gain,
                0.1);
  }
  const nlohmann::json& delay = results["cases"][1]["runs"][0];
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(delay["fopdt"][i][1]["delay"].get<double>(), 7.0, 0.4);
  }
}

// Converted without the plant's noise, the model predicts one step ahead so
// well by its own past that the paper's rule for λ sees little of the change:
// E stays a hundred times larger than with noise (698 to 781 for three seeds).
// The Gram matrix is nearly singular, and the certificate near its limit.
TEST(MleReproducePaper, WithoutNoiseInTheConversionMuchLessIsCorrected) {
  const ScratchFolder scratch;
  const report::ProcessResult result = RunPaper(
      scratch / "out", {"--cases=gain", "--conversion_noise_variance=0"});
  ASSERT_LE(result.exit_code, 1) << result.err;
  const nlohmann::json results = ParsedJson(scratch / "out/results.json");
  EXPECT_GT(results["cases"][0]["runs"][0]["E_star"].get<double>(), 400.0);
}

}  // namespace
}  // namespace mle
