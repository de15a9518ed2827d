#include "mle/model/process_simulator.h"

#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/base/random.h"
#include "tests/sim/test_models.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using testing::EmptyModel;
using ::testing::HasSubstr;
using testing::MixedModel;
using testing::SingleLoop;

MatrixXd SimulateModel(const ProcessModel& model, const MatrixXd& inputs) {
  absl::StatusOr<ProcessSimulator> plant = ProcessSimulator::Create(model, 0.2);
  EXPECT_TRUE(plant.ok()) << plant.status();
  MatrixXd outputs(plant->num_outputs(), inputs.cols() + 1);
  outputs.col(0) = plant->outputs();
  for (Eigen::Index k = 0; k < inputs.cols(); ++k) {
    plant->Advance(inputs.col(k));
    outputs.col(k + 1) = plant->outputs();
  }
  return outputs;
}

MatrixXd RandomSignals(int seed, int m, int steps) {
  return GaussianNoise(seed, 0).DrawMatrix(m, steps, 1.0);
}

TEST(ProcessSimulatorTest, HasTheModelsSizeAndStartsAtRest) {
  const absl::StatusOr<ProcessSimulator> plant =
      ProcessSimulator::Create(MixedModel(), 0.2);
  ASSERT_TRUE(plant.ok());
  EXPECT_EQ(plant->num_inputs(), 3);
  EXPECT_EQ(plant->num_outputs(), 2);
  EXPECT_EQ(plant->outputs(), VectorXd::Zero(2));
}

TEST(ProcessSimulatorTest, StaysAtRestWithoutInput) {
  EXPECT_EQ(SimulateModel(MixedModel(), MatrixXd::Zero(3, 50)).norm(), 0.0);
}

TEST(ProcessSimulatorTest, AnAbsentPairHasNoEffect) {
  MatrixXd inputs = MatrixXd::Zero(3, 50);
  inputs.row(2).setOnes();
  const MatrixXd y = SimulateModel(MixedModel(), inputs);
  EXPECT_EQ(y.row(1).norm(), 0.0);
  EXPECT_GT(y.row(0).norm(), 0.0);
}

TEST(ProcessSimulatorTest, Superposition) {
  const MatrixXd u = RandomSignals(1, 3, 200);
  const MatrixXd v = RandomSignals(2, 3, 200);
  const MatrixXd combined = 2.0 * SimulateModel(MixedModel(), u) -
                            0.5 * SimulateModel(MixedModel(), v);
  // Values of order 1 to 10: rounding.
  EXPECT_LE((SimulateModel(MixedModel(), 2.0 * u - 0.5 * v) - combined)
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

TEST(ProcessSimulatorTest, LongerDeadTimeByWholeSamplesShiftsTheResponse) {
  const int shift = 17;
  ProcessModel delayed = MixedModel();
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 3; ++j) {
      delayed.element(i, j).set_delay(delayed.element(i, j).delay() +
                                      shift * 0.2);
    }
  }
  const MatrixXd u = RandomSignals(1, 3, 200);
  const MatrixXd y = SimulateModel(MixedModel(), u);
  const MatrixXd late = SimulateModel(delayed, u);
  EXPECT_EQ(late.leftCols(shift + 1).norm(), 0.0);
  // The part of a sample differs by rounding of the sum of the dead times.
  EXPECT_LE((late.rightCols(201 - shift) - y.leftCols(201 - shift))
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
}

TEST(ProcessSimulatorTest, LaterInputShiftsTheResponse) {
  const MatrixXd u = RandomSignals(1, 3, 100);
  MatrixXd late_input = MatrixXd::Zero(3, 130);
  late_input.rightCols(100) = u;
  const MatrixXd late = SimulateModel(MixedModel(), late_input);
  EXPECT_EQ(late.leftCols(31).norm(), 0.0);
  EXPECT_EQ(late.rightCols(101), SimulateModel(MixedModel(), u));
}

// The present input cannot show before time has passed, and an output never
// depends on inputs to come.
TEST(ProcessSimulatorTest, IsCausal) {
  const MatrixXd u = RandomSignals(1, 3, 100);
  MatrixXd changed = u;
  changed.rightCols(40) = RandomSignals(2, 3, 40);
  const MatrixXd y = SimulateModel(MixedModel(), u);
  const MatrixXd z = SimulateModel(MixedModel(), changed);
  EXPECT_EQ(y.leftCols(61), z.leftCols(61));
  EXPECT_NE(y.col(61), z.col(61));
}

// Within 1e-9 of a whole sample the dead time is whole, also from below.
TEST(ProcessSimulatorTest, DeadTimeWithinRoundingOfASampleIsWhole) {
  const MatrixXd u = RandomSignals(1, 1, 60);
  const auto response = [&u](double delay) {
    return SimulateModel(SingleLoop(TransferFunction({1.0}, {1.0}, delay)), u);
  };
  const MatrixXd whole = response(3 * 0.2);
  EXPECT_EQ(whole.rightCols(57), u.leftCols(57));
  EXPECT_EQ(response(0.6), whole);
  EXPECT_EQ(response(0.6 - 1e-10), whole);
  EXPECT_EQ(response(0.6 + 1e-10), whole);
  // A sample earlier as soon as the dead time is truly shorter.
  EXPECT_EQ(response(0.6 - 1e-6).rightCols(58), u.leftCols(58));
  EXPECT_EQ(response(0.6 + 1e-6), whole);
}

TEST(ProcessSimulatorTest, CopiesGoTheirOwnWays) {
  absl::StatusOr<ProcessSimulator> plant =
      ProcessSimulator::Create(MixedModel(), 0.2);
  ASSERT_TRUE(plant.ok());
  plant->Advance(VectorXd::Ones(3));
  ProcessSimulator copy = *plant;
  for (int k = 0; k < 10; ++k) copy.Advance(VectorXd::Zero(3));
  for (int k = 0; k < 10; ++k) plant->Advance(VectorXd::Zero(3));
  EXPECT_EQ(copy.outputs(), plant->outputs());
}

TEST(ProcessSimulatorTest, ABadSampleTimeIsNamed) {
  for (const double bad : {0.0, -0.2, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    for (const ProcessModel& model : {MixedModel(), EmptyModel(1, 1)}) {
      const absl::Status status = ProcessSimulator::Create(model, bad).status();
      EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
      EXPECT_THAT(std::string(status.message()), HasSubstr("sample_time is "));
    }
  }
}

TEST(ProcessSimulatorTest, RefusesWhatCannotBeSimulatedAndNamesTheElement) {
  ProcessModel model = EmptyModel(2, 2);
  model.element(1, 0) = TransferFunction::FirstOrder(1.0, -3.0, 0.0);
  EXPECT_EQ(ProcessSimulator::Create(model, 0.2).status().code(),
            absl::StatusCode::kInvalidArgument);

  model.element(1, 0) = TransferFunction::FirstOrder(1.0, 3.0, 1e9);
  absl::Status status = ProcessSimulator::Create(model, 0.2).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("element (y2, u1)"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("delay of 1e+09"));
}

TEST(SimulateResponseTest, StartsSettledAtTheFirstInputs) {
  MatrixXd inputs = MatrixXd::Zero(3, 80);
  inputs.colwise() = Eigen::Vector3d(0.5, -2.0, 1.0);
  const absl::StatusOr<MatrixXd> y =
      SimulateResponse(MixedModel(), 0.2, inputs);
  ASSERT_TRUE(y.ok()) << y.status();
  const VectorXd settled = StaticGains(MixedModel()) * inputs.col(0);
  for (int k = 0; k < 80; ++k) EXPECT_EQ(y->col(k), settled);
}

// Where the past is long enough, it does not matter that it was settled.
// A level stands still at the inputs that it begins with, whatever these are.
TEST(SimulateResponseTest, TheFirstInputsBalanceALevel) {
  const ProcessModel model =
      SingleLoop(TransferFunction::Integrator(0.5, 2.0, 0.7));
  MatrixXd inputs = RandomSignals(3, 1, 60);
  inputs(0) = 0.0;
  const auto around_zero = SimulateResponse(model, 0.2, inputs);
  const auto around_nine =
      SimulateResponse(model, 0.2, (inputs.array() + 9.0).matrix());
  ASSERT_TRUE(around_zero.ok() && around_nine.ok());
  // 9 plus an input of size 1 keeps its digits to 9e-16.
  EXPECT_LE((*around_zero - *around_nine).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_EQ((*around_zero)(0), 0.0);
  EXPECT_TRUE(SimulateResponse(model, 0.2, MatrixXd::Constant(1, 50, 9.0))
                  ->isZero(0.0));
}

TEST(SimulateResponseTest, GoesOnFromTheSettledState) {
  MatrixXd inputs = RandomSignals(3, 3, 400);
  inputs.leftCols(300).colwise() = Eigen::Vector3d(0.5, -2.0, 1.0);
  const MatrixXd from_rest = SimulateModel(MixedModel(), inputs).leftCols(400);
  const absl::StatusOr<MatrixXd> y =
      SimulateResponse(MixedModel(), 0.2, inputs.rightCols(101));
  ASSERT_TRUE(y.ok());
  // The slowest mode, of 5 min, has left e^{−12} after 60 min.
  EXPECT_LE((*y - from_rest.rightCols(101)).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(SimulateResponseTest, ScalesWithTheUnitsOfInputsAndOutputs) {
  const MatrixXd inputs = RandomSignals(4, 1, 50);
  const TransferFunction element({0.9}, {1.0, 0.4, 1.0}, 1.07);
  const TransferFunction scaled({0.9 * 8.0 / 0.25}, {1.0, 0.4, 1.0}, 1.07);
  const absl::StatusOr<MatrixXd> y =
      SimulateResponse(SingleLoop(element), 0.2, inputs);
  const absl::StatusOr<MatrixXd> z =
      SimulateResponse(SingleLoop(scaled), 0.2, 0.25 * inputs);
  ASSERT_TRUE(y.ok() && z.ok());
  EXPECT_LE((8.0 * *y - *z).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(SimulateResponseTest, ChecksTheInputs) {
  const absl::Status status =
      SimulateResponse(MixedModel(), 0.2, MatrixXd::Zero(2, 5)).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("2 rows"));
  const absl::StatusOr<MatrixXd> none =
      SimulateResponse(MixedModel(), 0.2, MatrixXd::Zero(3, 0));
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(none->cols(), 0);
}

}  // namespace
}  // namespace mle
