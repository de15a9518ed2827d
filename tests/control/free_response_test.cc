#include "control/free_response.h"

#include <algorithm>
#include <vector>

#include "gtest/gtest.h"
#include "tests/sim/test_models.h"

namespace mle::control {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Of the models that are mixed, one pair ends in a ramp.
PredictionModel PredictedModel(bool ramp) {
  ProcessModel model = testing::MixedModel();
  if (ramp) model.element(1, 0) = TransferFunction({0.2}, {1.0, 0.0}, 1.3);
  return *PredictFromProcess(model, 0.7);
}

// S_k, carried on beyond n.
MatrixXd StepAt(const PredictionModel& model, int k) {
  const int p = model.num_outputs;
  const int n = model.periods();
  MatrixXd step = model.responses.middleRows(p * std::min(k, n), p);
  if (model.slopes.size() > 0) step += std::max(k - n, 0) * model.slopes;
  return step;
}

// f_{l+k} = Σ S_{k+age} v_age over all moves so far, for so many instants that
// what is carried has been moved to its beginning more than once.
TEST(FreeResponseTest, IsTheSumOfTheResponsesToAllMoves) {
  for (const bool ramp : {false, true}) {
    const PredictionModel model = PredictedModel(ramp);
    const int n = model.periods();
    FreeResponse response(model);
    std::vector<VectorXd> moves;
    for (int l = 0; l < 2 * n + 50; ++l) {
      if (l > 0) response.Advance();
      VectorXd move = VectorXd::Random(model.num_inputs());
      if (l % 3 == 1) move.setZero();
      for (int j = 0; j < model.num_inputs(); ++j) response.Move(j, move(j));
      moves.push_back(move);
      if (l % 40 != 0 && l < 2 * n + 45) continue;
      for (const int k : {0, 1, 7, n}) {
        VectorXd expected = VectorXd::Zero(model.num_outputs);
        for (int age = 0; age <= l; ++age) {
          expected += StepAt(model, k + age) * moves[l - age];
        }
        EXPECT_LT((response.At(k) - expected).norm(),
                  1e-9 * (1.0 + expected.norm()))
            << l << " " << k;
      }
    }
  }
}

TEST(FreeResponseTest, SettlesAsAfterAMoveOfLongAgo) {
  for (const bool ramp : {false, true}) {
    const PredictionModel model = PredictedModel(ramp);
    const int n = model.periods();
    const VectorXd inputs = VectorXd::Random(model.num_inputs());
    FreeResponse moved(model);
    for (int j = 0; j < model.num_inputs(); ++j) moved.Move(j, inputs(j));
    for (int l = 0; l < n; ++l) moved.Advance();
    FreeResponse settled(model);
    settled.Move(0, 3.0);
    settled.Advance();
    settled.Settle(inputs);
    for (const int k : {0, 1, n}) {
      EXPECT_LT((settled.At(k) - moved.At(k)).norm(), 1e-9) << k;
    }
    EXPECT_LT((settled.ramp() - moved.ramp()).norm(), 1e-12);
    EXPECT_EQ(settled.ramp().isZero(), !ramp);
  }
}

}  // namespace
}  // namespace mle::control
