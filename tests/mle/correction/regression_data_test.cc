#include "mle/correction/regression_data.h"

#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "tests/mle/correction/arx_data.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Its rows point into it.
static_assert(!std::is_copy_constructible_v<RegressionData>);
static_assert(!std::is_copy_assignable_v<RegressionData>);
static_assert(std::is_move_constructible_v<RegressionData>);

std::string Message(const std::vector<Record>& windows, const ArxModel& model) {
  const auto data =
      RegressionData::Create(windows, model, Scaling::kStandardise);
  EXPECT_EQ(data.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(data.status().message());
}

TEST(RegressionDataTest, SaysWhatIsWrong) {
  const ArxModel model = SparseArx();
  const Record good = SimulateArx(model, 20, 0.1, 1);
  EXPECT_THAT(Message({}, model), HasSubstr("no window"));

  Record bad = good;
  bad.inputs.resize(1, 20);
  bad.inputs.setZero();
  EXPECT_THAT(Message({good, bad}, model),
              AllOf(HasSubstr("window 2"), HasSubstr("2 outputs and 1 inputs"),
                    HasSubstr("2 and 2")));
  bad = good;
  bad.sample_time = 0.2;
  EXPECT_THAT(Message({bad}, model),
              AllOf(HasSubstr("window 1"), HasSubstr("every 0.2"),
                    HasSubstr("every 0.5")));
  bad = good;
  bad.outputs.resize(2, 19);
  EXPECT_NE(Message({bad}, model), "");
  ArxModel no_order = model;
  no_order.order = 0;
  EXPECT_NE(Message({good}, no_order), "");

  // Four lags and the sample itself.
  EXPECT_TRUE(RegressionData::Create({SimulateArx(model, 5, 0.1, 1)}, model,
                                     Scaling::kRaw)
                  .ok());
  EXPECT_THAT(Message({good, SimulateArx(model, 4, 0.1, 1)}, model),
              AllOf(HasSubstr("window 2 has 4 samples"), HasSubstr("needs 5"),
                    HasSubstr("order 4")));
  // Long enough, but never good for long enough.
  bad = good;
  for (int k = 0; k < 20; k += 4) {
    bad.inputs(0, k) = std::numeric_limits<double>::quiet_NaN();
  }
  EXPECT_THAT(Message({bad}, model), HasSubstr("window 1 has 20 samples"));
}

// y_k − R x_k for each usable sample; where the problem is centred, up to a
// constant.
TEST(RegressionDataTest, ResponsesAreWhatTheModelLeaves) {
  const ArxModel truth = SparseArx();
  ArxModel model = truth;
  model.R(1, 3) = 0.4;
  std::vector<Record> windows = {SimulateArx(truth, 60, 0.1, 1, 5.0, -3.0),
                                 SimulateArx(truth, 40, 0.1, 2, 5.0, -3.0)};
  windows[1].outputs(1, 20) = std::numeric_limits<double>::quiet_NaN();
  for (const Scaling scaling : {Scaling::kRaw, Scaling::kStandardise}) {
    const auto data = RegressionData::Create(windows, model, scaling);
    ASSERT_TRUE(data.ok()) << data.status();
    ASSERT_EQ(data->num_windows(), 2);
    ASSERT_EQ(data->window(0).size(), 1U);
    ASSERT_EQ(data->window(1).size(), 2U);
    EXPECT_EQ(data->window(0)[0].rows.rows(), 56);
    EXPECT_EQ(data->window(1)[0].rows.last, 19);
    EXPECT_EQ(data->window(1)[1].rows.first, 25);
    // The difference is the same for all rows: R about the offset.
    Eigen::Vector2d constant = Eigen::Vector2d::Zero();
    for (int w = 0; w < 2; ++w) {
      for (const RegressionRows& rows : data->window(w)) {
        for (int k = rows.rows.first; k <= rows.rows.last; ++k) {
          Eigen::VectorXd x(16);
          for (int lag = 1; lag <= 4; ++lag) {
            x.segment(4 * lag - 4, 4) << windows[w].outputs.col(k - lag),
                windows[w].inputs.col(k - lag);
          }
          const Eigen::Vector2d direct =
              windows[w].outputs.col(k) - model.R * x;
          const Eigen::Vector2d difference =
              rows.responses.col(rows.rows.last - k) - direct;
          if (w == 0 && k == 4) constant = difference;
          // Sums of 17 numbers up to 10.
          EXPECT_LE((difference - constant).norm(), 1e-13);
        }
      }
    }
    EXPECT_EQ(constant.norm() > 1e-13, scaling == Scaling::kStandardise);
  }
}

}  // namespace
}  // namespace mle
