// Small loops for the tests of their analysis.

#ifndef TESTS_CONTROL_ANALYSED_LOOPS_H_
#define TESTS_CONTROL_ANALYSED_LOOPS_H_

#include <limits>
#include <utility>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "control/loop_analysis.h"
#include "control/mpc.h"
#include "control/prediction_model.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "tests/sim/test_models.h"

namespace mle::control::analysed_loops {

inline MpcOptions Options(int p, int m, double move_weight) {
  MpcOptions options;
  options.prediction_horizon = 12;
  options.control_horizon = 3;
  options.output_weight = Eigen::MatrixXd::Identity(p, p);
  options.move_weight = Eigen::MatrixXd::Identity(m, m) * move_weight;
  return options;
}

inline PredictionModel Predict(const ProcessModel& model) {
  absl::StatusOr<PredictionModel> prediction = PredictFromProcess(model, 1.0);
  EXPECT_TRUE(prediction.ok()) << prediction.status();
  return *std::move(prediction);
}

inline Mpc MakeAnalysedMpc(const PredictionModel& model,
                           const MpcOptions& options) {
  absl::StatusOr<Mpc> mpc = Mpc::Create(model, options);
  EXPECT_TRUE(mpc.ok()) << mpc.status();
  return *std::move(mpc);
}

// With and without the search for the fastest mode, which agree.
inline LoopAnalysis Analyse(const Mpc& mpc, const PredictionModel& plant) {
  const absl::StatusOr<LoopAnalysis> analysis = AnalyseLoop(mpc, plant);
  EXPECT_TRUE(analysis.ok()) << analysis.status();
  const absl::StatusOr<LoopAnalysis> brief =
      AnalyseLoop(mpc, plant, /*find_fastest=*/false);
  EXPECT_TRUE(brief.ok()) << brief.status();
  EXPECT_EQ(brief->growing_modes, analysis->growing_modes);
  EXPECT_EQ(brief->spectral_radius,
            analysis->stable ? analysis->spectral_radius
                             : std::numeric_limits<double>::infinity());
  return *analysis;
}

// Short time constants, for short responses and small matrices.
inline ProcessModel FastTwoByTwo() {
  ProcessModel model = testing::EmptyModel(2, 2);
  model.element(0, 0) = TransferFunction::FirstOrder(2.0, 1.2, 0.5);
  model.element(0, 1) = testing::SecondOrder(-0.5, 0.0, 0.8, 0.5, 0.4);
  model.element(1, 0) = TransferFunction::FirstOrder(0.4, 0.9, 1.3);
  model.element(1, 1) = TransferFunction::FirstOrder(1.5, 1.0, 0.0);
  return model;
}

}  // namespace mle::control::analysed_loops

#endif  // TESTS_CONTROL_ANALYSED_LOOPS_H_
