#include "mle/nonlinear/output_error_correction.h"

#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_simulator.h"
#include "tests/mle/nonlinear/output_error_fits.h"
#include "tests/mle/nonlinear/output_error_records.h"

namespace mle {
namespace {

using ::testing::HasSubstr;

TEST(OutputErrorCorrectionTest, RecoversAnExactPlant) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(-0.8, 9.0, 5.13);
  plant.element(0, 1) = TransferFunction::FirstOrder(-5.0, 3.0, 0.27);
  for (const double offset : {0.0, 40.0}) {
    const auto correction =
        Correct(TwoElements(), MakeRecords(plant, 500, 1, {.offset = offset}));
    for (int j = 0; j < 2; ++j) {
      const auto truth = Values(plant.element(0, j));
      const auto found = Parameters(correction.full, j);
      // The plant is simulated to about 1e-9.
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(found[k].value, truth[k], 1e-6) << correction.FullReport();
      }
      EXPECT_TRUE(correction.aged(0, j));
    }
    EXPECT_TRUE(correction.change_proposed);
    EXPECT_TRUE(correction.full.certificates[0].search_confirmed);
  }
}

// A dead sensor says nothing of gains.
TEST(OutputErrorCorrectionTest, AConstantOutputInformsNothing) {
  auto records = MakeRecords(AgedPlant(), 400, 3, {.variance = 0.01});
  for (const double constant : {0.0, 17.5}) {
    for (Record& record : records) record.outputs.row(0).setConstant(constant);
    const auto correction = Correct(TwoElements(), records);
    EXPECT_FALSE(correction.change_proposed);
    for (int j = 0; j < 2; ++j) {
      EXPECT_EQ(correction.full.element(0, j).state,
                ElementState::kNotInformed);
      EXPECT_EQ(Parameters(correction.full, j)[0].value,
                TwoElements().element(0, j).StaticGain());
    }
  }
}

// Begun at a fit to more data, the search ends where it ends from the initial
// values; the change is not tested again.
TEST(OutputErrorCorrectionTest, BeginsAtAFit) {
  const auto records = MakeRecords(AgedPlant(), 400, 3, {.variance = 0.01});
  std::vector<Record> part = records;
  part[0].outputs.row(0).segment(150, 40).setConstant(
      std::numeric_limits<double>::quiet_NaN());
  const auto expected = Correct(TwoElements(), part);
  OutputErrorOptions options;
  options.start = std::make_shared<const OutputErrorCorrection>(
      Correct(TwoElements(), records));
  const auto found = Correct(TwoElements(), part, options);
  EXPECT_TRUE(found.change_proposed);
  EXPECT_EQ(found.aged, expected.aged);
  EXPECT_EQ(found.statistic, 0.0);
  for (int j = 0; j < 2; ++j) {
    for (int k = 0; k < 3; ++k) {
      const ParameterEstimate one = Parameters(found.full, j)[k];
      const ParameterEstimate other = Parameters(expected.full, j)[k];
      // To what the noise shapes, each estimated to 0.02, differ by.
      EXPECT_NEAR(one.value, other.value, 0.02 * other.standard_error);
    }
  }
  EXPECT_EQ(found.full.certificates[0].grid_searches, 0);

  options.start = std::make_shared<const OutputErrorCorrection>();
  const auto wrong = CorrectByOutputError(TwoElements(), part, options);
  EXPECT_EQ(wrong.status().code(), absl::StatusCode::kInvalidArgument);
  auto without = Correct(TwoElements(), records);
  without.aged.resize(0, 0);
  options.start = std::make_shared<const OutputErrorCorrection>(without);
  EXPECT_EQ(CorrectByOutputError(TwoElements(), part, options).status().code(),
            absl::StatusCode::kInvalidArgument);
}

// An element is certain only where the part shows it beyond doubt as well: what
// all records are said to have shown is not taken on trust.
TEST(OutputErrorCorrectionTest, PartsDoNotTakeOnTrust) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(2.02, 4.0, 1.0);
  const auto records = MakeRecords(plant, 400, 4, {.variance = 0.01});
  OutputErrorOptions options;
  const auto after = [&](double p_value) {
    auto claimed = Correct(TwoElements(), records);
    claimed.aged.setConstant(true);
    claimed.element_p_values.setConstant(p_value);
    options.start = std::make_shared<const OutputErrorCorrection>(claimed);
    return Correct(TwoElements(), records, options);
  };
  const auto found = after(0.0);
  EXPECT_TRUE(found.aged(0, 0));
  EXPECT_FALSE(found.aged(0, 1));
  EXPECT_LT(found.element_p_values(0, 0), 1e-3);
  EXPECT_GT(found.element_p_values(0, 0), kBeyondDoubt);
  EXPECT_EQ(found.element_p_values, after(1.0).element_p_values);
}

// It is asked after each fit, and a no is the last.
TEST(OutputErrorCorrectionTest, StopsWhereItIsTold) {
  const auto records = MakeRecords(AgedPlant(), 300, 4, {.variance = 0.01});
  OutputErrorOptions options;
  int calls = 0;
  options.after_fit = [&] {
    ++calls;
    return true;
  };
  EXPECT_TRUE(CorrectByOutputError(TwoElements(), records, options).ok());
  EXPECT_EQ(calls, 2);
  calls = 0;
  options.after_fit = [&] {
    ++calls;
    return false;
  };
  const auto stopped = CorrectByOutputError(TwoElements(), records, options);
  EXPECT_EQ(stopped.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(calls, 1);
}

// Noise hides what the time constant is; the full fit moves it all the same,
// what is proposed hardly does.
TEST(OutputErrorCorrectionTest, ParametersThatHaveNotChangedStayNearby) {
  ProcessModel plant = TwoElements();
  plant.element(0, 0) = TransferFunction::FirstOrder(1.0, 4.0, 1.0);
  double full = 0.0;
  double corrected = 0.0;
  int changed = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const auto correction = Correct(
        TwoElements(), MakeRecords(plant, 300, seed, {.variance = 0.2}));
    if (!correction.aged(0, 0)) continue;
    ++changed;
    const ElementEstimate& free = correction.full.element(0, 0);
    const ElementEstimate& proposed = correction.corrected.element(0, 0);
    full += std::pow(free.time_scale.value - 4.0, 2);
    corrected += std::pow(proposed.time_scale.value - 4.0, 2);
    EXPECT_LT(proposed.time_scale.standard_error,
              free.time_scale.standard_error);
    EXPECT_LE(proposed.time_scale.lower, 4.0);
    EXPECT_GE(proposed.time_scale.upper, 4.0);
  }
  EXPECT_GE(changed, 6);
  EXPECT_LT(corrected, 0.5 * full);
}

TEST(OutputErrorCorrectionTest, FitsOtherShapesByGainScaleAndDelay) {
  ProcessModel model = MakeModel(1, 1);
  model.element(0, 0) = TransferFunction({2.0}, {12.0, 8.0, 1.0}, 1.0);
  ProcessModel plant = model;
  plant.element(0, 0) = TransferFunction({3.0}, {27.0, 12.0, 1.0}, 3.2);
  const auto correction = Correct(model, MakeRecords(plant, 500, 2, {}));
  const ElementEstimate& e = correction.full.element(0, 0);
  EXPECT_NEAR(e.gain.value, 3.0, 1e-6);
  EXPECT_NEAR(e.time_scale.value / e.time_scale.initial, 1.5, 1e-6);
  EXPECT_NEAR(e.delay.value, 3.2, 1e-6);
  const auto truth = plant.ComputeStepResponse(0.5, 100);
  EXPECT_LT(
      SquaredDistance(truth,
                      correction.corrected.model.ComputeStepResponse(0.5, 100)),
      1e-9);
}

TEST(OutputErrorCorrectionTest, OutputsAreSeparate) {
  ProcessModel model = MakeModel(2, 2);
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      if (i == 1 && j == 0) continue;  // Stays zero.
      model.element(i, j) = TransferFunction::FirstOrder(
          1.0 + i + j, 3.0 + 2.0 * j, 1.1 * (i + 1));
    }
  }
  ProcessModel plant = model;
  plant.element(1, 1) = TransferFunction::FirstOrder(1.5, 5.0, 2.2);
  const auto records = MakeRecords(plant, 400, 3, {.variance = 1e-3});
  const auto correction = Correct(model, records);
  EXPECT_TRUE(correction.aged(1, 1));
  EXPECT_EQ(correction.aged.count(), 1);
  EXPECT_EQ(correction.full.element(1, 0).state, ElementState::kAbsent);
  EXPECT_TRUE(correction.corrected.model.element(1, 0).IsZero());
  EXPECT_EQ(correction.corrected.element(0, 0).state, ElementState::kHeld);
  EXPECT_THAT(correction.FullReport(), HasSubstr("output y1"));
  // Threads change nothing.
  const auto again = Correct(model, records, {.threads = 2});
  EXPECT_EQ(again.full.element(1, 1).delay.value,
            correction.full.element(1, 1).delay.value);
  // The other output may not change: nothing is different for this one ...
  const auto one = Correct(model, records, {.outputs = {false, true}});
  EXPECT_EQ(one.full.element(0, 0).state, ElementState::kHeld);
  EXPECT_GT(one.full.noise[0].variance, 0.0);
  // ... but the weight of offsets, to which all outputs contribute.
  const ParameterEstimate& delay = correction.full.element(1, 1).delay;
  EXPECT_NEAR(one.full.element(1, 1).delay.value, delay.value,
              0.01 * delay.standard_error);
  EXPECT_EQ(one.aged, correction.aged);
}

// Six inputs that move in two directions, but for a little of their own: with
// all elements free none is determined, though the records rule out the model.
TEST(OutputErrorCorrectionTest, NamesWhatHasChangedWhereInputsMoveTogether) {
  ProcessModel model = MakeModel(1, 6);
  for (int j = 0; j < 6; ++j) {
    model.element(0, j) = TransferFunction::FirstOrder(
        j % 2 == 0 ? 1.2 - 0.1 * j : -0.3, 4.0 + j, 1.0 + 0.4 * j);
  }
  for (const int aged : {0, 2}) {
    ProcessModel plant = model;
    const TransferFunction& g = model.element(0, aged);
    plant.element(0, aged) = TransferFunction::FirstOrder(
        0.7 * g.StaticGain(), g.TimeConstant(), g.delay());
    std::vector<Record> records =
        MakeRecords(plant, 600, 7, {.variance = 0.01});
    std::mt19937_64 source(2);
    std::normal_distribution<double> normal;
    for (Record& record : records) {
      for (int j = 2; j < 6; ++j) {
        record.inputs.row(j) =
            (j % 3 == 0 ? 1.0 : -0.7) * record.inputs.row(0) +
            (j % 3 == 1 ? 0.8 : 0.4) * record.inputs.row(1) +
            0.02 * record.inputs.row(j);
      }
      record.outputs =
          *SimulateResponse(plant, record.sample_time, record.inputs);
      for (double& y : record.outputs.reshaped()) y += 0.1 * normal(source);
    }
    const OutputErrorCorrection correction = Correct(model, records);
    ASSERT_TRUE(correction.change_proposed);
    for (int j = 0; j < 6; ++j) {
      EXPECT_EQ(correction.aged(0, j), j == aged) << j;
    }
    EXPECT_LT(correction.element_p_values(0, aged), 1e-10);
    EXPECT_NEAR(correction.corrected.element(0, aged).gain.value,
                0.7 * g.StaticGain(), 0.02);
  }
}

TEST(OutputErrorCorrectionTest, AnInputAtRestInformsAboutNothing) {
  ProcessModel model = TwoElements();
  auto records = MakeRecords(AgedPlant(), 400, 4, {.variance = 1e-3});
  // The second input of another plant rests; its element is the offset's.
  ProcessModel one = AgedPlant();
  one.element(0, 1) = TransferFunction();
  records = MakeRecords(one, 400, 4, {.variance = 1e-3});
  for (Record& record : records) record.inputs.row(1).setConstant(0.4);
  const auto correction = Correct(model, records);
  EXPECT_EQ(correction.full.element(0, 1).state, ElementState::kNotInformed);
  EXPECT_EQ(correction.full.element(0, 1).gain.value, -3.0);
  EXPECT_TRUE(correction.aged(0, 0));
  EXPECT_FALSE(correction.aged(0, 1));
  EXPECT_NEAR(correction.corrected.element(0, 0).delay.value, 4.21, 0.1);
  EXPECT_THAT(correction.FullReport(), HasSubstr("does not move"));
}

TEST(OutputErrorFitTest, BandsAreTheDeltaMethods) {
  const ProcessModel plant = TwoElements();
  const auto records = MakeRecords(plant, 400, 5, {.variance = 0.01});
  const auto limit = ComputeOutputErrorLimit(
      plant, records, {{.variance = 0.01}}, OutputErrorOptions());
  ASSERT_TRUE(limit.ok());
  const StepResponse errors = limit->StepResponseErrors(0.5, 80);
  const auto values = Values(plant.element(0, 1));
  const double h = 1e-5;
  Eigen::MatrixXd derivatives(80, 3);
  for (int k = 0; k < 3; ++k) {
    auto up = values;
    auto down = values;
    up[k] += h;
    down[k] -= h;
    derivatives.col(k) =
        (TransferFunction::FirstOrder(up[0], up[1], up[2])
             .StepResponse(0.5, 80) -
         TransferFunction::FirstOrder(down[0], down[1], down[2])
             .StepResponse(0.5, 80)) /
        (2.0 * h);
  }
  const Eigen::MatrixXd covariance = limit->covariances[0].block(3, 3, 3, 3);
  const Eigen::VectorXd expected =
      (derivatives * covariance * derivatives.transpose())
          .diagonal()
          .cwiseSqrt();
  // Central differences err by h².
  EXPECT_LT((errors.element(0, 1) - expected).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_NEAR(limit->ExpectedSquaredDistance(0.5, 80),
              errors.values.squaredNorm(), 1e-15);
}

// Free responses of elements with one time constant are one and the same: they
// must not blow up against each other.
TEST(OutputErrorCorrectionTest, EqualTimeConstantsAreDetermined) {
  ProcessModel model = MakeModel(1, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(-2.2, 7.0, 1.0);
  model.element(0, 1) = TransferFunction::FirstOrder(1.3, 7.0, 0.3);
  ProcessModel plant = model;
  plant.element(0, 1) = TransferFunction::FirstOrder(1.3, 7.0, 2.3);
  const auto records = MakeRecords(plant, 500, 9, {.variance = 1e-3});
  for (const bool offset : {false, true}) {
    const auto limit = ComputeOutputErrorLimit(
        plant, records, {{.variance = 1e-3, .ratio = 0.0, .offset = offset}},
        {});
    ASSERT_TRUE(limit.ok()) << limit.status();
    EXPECT_TRUE(std::isfinite(limit->ExpectedSquaredDistance(0.5, 100)));
    const auto correction = Correct(model, records);
    for (int j = 0; j < 2; ++j) {
      const auto bound = Parameters(*limit, j);
      const auto found = Parameters(correction.full, j);
      const auto truth = Values(plant.element(0, j));
      for (int k = 0; k < 3; ++k) {
        EXPECT_LT(bound[k].standard_error, 0.1 * std::abs(truth[k]) + 0.1);
        EXPECT_LT(std::abs(found[k].value - truth[k]),
                  6.0 * bound[k].standard_error);
      }
    }
    EXPECT_TRUE(correction.aged(0, 1));
    EXPECT_FALSE(correction.aged(0, 0));
  }
}

// A solve that Ceres does not end at an optimum says so in Ceres' own words.
TEST(OutputErrorCorrectionTest, CeresWordsArePassedOn) {
  const auto correction = Correct(
      TwoElements(), MakeRecords(AgedPlant(), 300, 6, {.variance = 1e-12}),
      {.max_iterations = 1});
  const FitCertificate& certificate = correction.full.certificates[0];
  EXPECT_EQ(certificate.termination, FitTermination::kIterationLimit);
  EXPECT_THAT(certificate.message, HasSubstr("Maximum number of iterations"));
  EXPECT_THAT(correction.FullReport(),
              HasSubstr("Maximum number of iterations"));
}

TEST(OutputErrorCorrectionTest, SaysWhatIsWrong) {
  const ProcessModel model = TwoElements();
  const auto records = MakeRecords(model, 300, 6, {.variance = 0.01});
  const auto message = [](const ProcessModel& m, const std::vector<Record>& r,
                          const OutputErrorOptions& o = {}) {
    return std::string(CorrectByOutputError(m, r, o).status().message());
  };
  EXPECT_THAT(message(model, {}), HasSubstr("no record"));
  EXPECT_THAT(message(model, records, {.outputs = {true, true}}),
              HasSubstr("outputs has 2 entries, the model has 1"));
  EXPECT_THAT(message(MakeModel(2, 2), records),
              HasSubstr("records[0] has 1 outputs and 2 inputs"));
  auto other = records;
  other[1].sample_time = 0.25;
  EXPECT_THAT(message(model, other), HasSubstr("records[1] is sampled every"));
  EXPECT_THAT(message(model, records, {.max_delay = 2.0}),
              HasSubstr("element of output \"y0\", input \"u1\": its dead time "
                        "2.3 exceeds max_delay"));
  EXPECT_THAT(message(model, records, {.max_delay = 1e12}),
              HasSubstr("max_delay = 1e+12, must be less than the longest "
                        "stretch of the records"));
  EXPECT_THAT(message(model, {MakeRecord(model, 40, 1, {})}),
              HasSubstr("\"y0\" has"));
  EXPECT_THAT(message(model, {MakeRecord(model, 12, 1, {})}),
              HasSubstr("longer records"));
  ProcessModel direct = model;
  direct.element(0, 0) = TransferFunction({1.0, 1.0}, {2.0, 1.0}, 0.0);
  EXPECT_THAT(message(direct, records), HasSubstr("feedthrough"));
  // Squares of these overflow.
  ProcessModel large = model;
  large.element(0, 1) = TransferFunction::FirstOrder(1e155, 5.0, 1.0);
  EXPECT_THAT(
      message(large, records),
      HasSubstr("input \"u1\": a gain of 1e+155 makes responses up to"));
  large.element(0, 1) = TransferFunction({1e155, 2.0}, {5.0, 6.0, 1.0}, 1.0);
  EXPECT_THAT(message(large, records),
              HasSubstr("input \"u1\": a gain of 1.66667e+154 makes"));
  // Those of these underflow.
  ProcessModel small = model;
  small.element(0, 1) = TransferFunction::FirstOrder(5e-324, 5.0, 1.0);
  EXPECT_THAT(message(small, records),
              HasSubstr("input \"u1\": a gain of 4.94066e-324 is too small"));
  other = records;
  for (Record& record : other) record.outputs *= 1e-300;
  EXPECT_THAT(message(model, other),
              HasSubstr("they may not stay below 1e-60"));
  other = records;
  other[0].inputs(1, 7) = 1.7e308;
  EXPECT_THAT(message(model, other),
              HasSubstr("input 2 is 1.7e+308 in sample 8"));
  other = records;
  other[1].outputs(0, 7) = -1e300;
  EXPECT_THAT(message(model, other),
              HasSubstr("output 1 is -1e+300 in sample 8"));
  EXPECT_THAT(
      std::string(
          ComputeOutputErrorLimit(model, records, {}, {}).status().message()),
      HasSubstr("noise is given for 0 outputs"));
}

TEST(OutputErrorCorrectionTest, AnOutputWithFewSamplesDoesNotStopTheOthers) {
  ProcessModel model = MakeModel(2, 2);
  for (int j = 0; j < 2; ++j) {
    model.element(0, j) = TwoElements().element(0, j);
    model.element(1, j) = TwoElements().element(0, j);
  }
  ProcessModel plant = model;
  plant.element(0, 0) = AgedPlant().element(0, 0);
  plant.element(1, 0) = AgedPlant().element(0, 0);
  auto records = MakeRecords(plant, 300, 6, {.variance = 0.01});
  for (Record& record : records) {
    record.outputs.row(1).tail(270).setConstant(
        std::numeric_limits<double>::quiet_NaN());
  }
  const auto correction = Correct(model, records, {});
  EXPECT_NEAR(correction.full.element(0, 0).gain.value,
              plant.element(0, 0).StaticGain(), 0.05);
  EXPECT_EQ(correction.full.element(1, 0).state, ElementState::kNotInformed);
  for (Record& record : records) {
    record.outputs.row(0).tail(270).setConstant(
        std::numeric_limits<double>::quiet_NaN());
  }
  EXPECT_THAT(CorrectByOutputError(model, records, {}).status().message(),
              HasSubstr("output \"y0\" has "));
}

TEST(OutputErrorOptionsTest, ValidateNamesTheField) {
  const auto message = [](auto change) {
    OutputErrorOptions options;
    EXPECT_TRUE(options.Validate().ok());
    change(options);
    return std::string(options.Validate().message());
  };
  using O = OutputErrorOptions;
  EXPECT_THAT(message([](O& o) { o.max_time_scale_factor = 1.0; }),
              HasSubstr("max_time_scale_factor is 1"));
  EXPECT_THAT(message([](O& o) { o.max_delay = -1.0; }),
              HasSubstr("max_delay is -1"));
  EXPECT_THAT(message([](O& o) { o.false_alarm_probability = 0.0; }),
              HasSubstr("false_alarm_probability is 0"));
  EXPECT_THAT(message([](O& o) { o.confidence = 1.0; }),
              HasSubstr("confidence is 1"));
  EXPECT_THAT(message([](O& o) { o.max_iterations = 0; }),
              HasSubstr("max_iterations is 0"));
  EXPECT_THAT(message([](O& o) { o.threads = -1; }),
              HasSubstr("threads is -1"));
}

}  // namespace
}  // namespace mle
