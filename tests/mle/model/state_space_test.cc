#include "mle/model/state_space.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/model/process_model.h"
#include "mle/model/state_space_json.h"

namespace mle {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// Three states, two inputs, one output; D and dead times of both kinds.
DiscreteStateSpace ExampleSystem() {
  DiscreteStateSpace system;
  system.sample_time = 0.5;
  system.A =
      Eigen::Matrix3d{{0.9, 0.1, 0.0}, {-0.2, 0.7, 0.3}, {0.0, 0.0, 0.4}};
  system.B = Eigen::MatrixXd{{1.0, 0.0}, {0.0, -2.0}, {0.5, 1.0}};
  system.C = Eigen::MatrixXd{{1.0, -1.0, 2.0}};
  system.D = Eigen::MatrixXd{{0.0, 3.0}};
  system.input_delays = {2, 0};
  system.output_delays = {1};
  return system;
}

TEST(StateSpaceTest, SimulationIsTheConvolutionWithMarkovParameters) {
  const DiscreteStateSpace system = ExampleSystem();
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd inputs(2, 40);
  for (double& value : inputs.reshaped()) value = normal(random);
  const Eigen::MatrixXd outputs = system.Simulate(inputs);
  for (int k = 0; k < 40; ++k) {
    double expected = 0.0;
    for (int j = 0; j < 2; ++j) {
      Eigen::VectorXd state = system.B.col(j);
      const int dead = system.input_delays[j] + 1;  // and that of the output
      for (int lag = 0; lag + dead <= k; ++lag) {
        double weight = system.D(0, j);
        if (lag > 0) {
          weight = (system.C * state)(0);
          state = (system.A * state).eval();
        }
        expected += weight * inputs(j, k - dead - lag);
      }
    }
    EXPECT_NEAR(outputs(0, k), expected, 1e-12) << k;
  }
}

TEST(StateSpaceTest, StepResponseIsASimulationAndSettlesAtTheStaticGain) {
  const DiscreteStateSpace system = ExampleSystem();
  const StepResponse response = system.ComputeStepResponse(400);
  EXPECT_EQ(response.sample_time, 0.5);
  for (int j = 0; j < 2; ++j) {
    Eigen::MatrixXd step = Eigen::MatrixXd::Zero(2, 400);
    step.row(j).setOnes();
    const Eigen::MatrixXd outputs = system.Simulate(step);
    EXPECT_LT((outputs.row(0).transpose() - response.element(0, j))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-12);
    EXPECT_NEAR(response.element(0, j)(399), system.StaticGains()(0, j), 1e-12);
  }
  EXPECT_EQ(response.element(0, 0)(3), 0.0);  // dead times 2 and 1
  EXPECT_NE(response.element(0, 0)(4), 0.0);
  EXPECT_EQ(response.element(0, 1)(1), 3.0);  // feedthrough after 1
}

// The third state integrates both inputs; the output is a lag of it, and of the
// second input another.
TEST(StateSpaceTest, StepResponsesOfLevelsEndInTheirSlopes) {
  DiscreteStateSpace system = ExampleSystem();
  EXPECT_FALSE(system.IsIntegrating());
  EXPECT_EQ(system.Slopes(), Eigen::MatrixXd::Zero(1, 2));
  system.A(2, 2) = 1.0;
  ASSERT_TRUE(system.Validate().ok()) << system.Validate();
  EXPECT_TRUE(system.IsIntegrating());
  StepResponse response = system.ComputeStepResponse(400);
  const Eigen::MatrixXd slopes = system.Slopes();
  for (int j = 0; j < 2; ++j) {
    const Eigen::VectorXd& h = response.element(0, j);
    EXPECT_NEAR((h(399) - h(397)) / 1.0, slopes(0, j), 1e-10);
    EXPECT_EQ(system.StaticGains()(0, j), slopes(0, j));
  }
  // An input that the integrator does not see settles.
  system.B(2, 1) = 0.0;
  response = system.ComputeStepResponse(400);
  EXPECT_NE(system.Slopes()(0, 0), 0.0);
  EXPECT_EQ(system.Slopes()(0, 1), 0.0);
  EXPECT_NEAR(system.StaticGains()(0, 1), response.element(0, 1)(399), 1e-10);
}

std::string SystemRefusal(DiscreteStateSpace system) {
  return std::string(system.Validate().message());
}

TEST(StateSpaceTest, ValidateNamesWhatIsWrong) {
  EXPECT_TRUE(ExampleSystem().Validate().ok()) << ExampleSystem().Validate();
  DiscreteStateSpace system = ExampleSystem();
  system.sample_time = 0.0;
  EXPECT_THAT(SystemRefusal(system), HasSubstr("sample_time is 0"));
  system = ExampleSystem();
  system.B.conservativeResize(2, 2);
  EXPECT_THAT(SystemRefusal(system), HasSubstr("B is 2 × 2, must be 3 × 2"));
  system = ExampleSystem();
  system.D(0, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(SystemRefusal(system), HasSubstr("D holds an entry"));
  system = ExampleSystem();
  system.input_delays = {1};
  EXPECT_THAT(SystemRefusal(system),
              HasSubstr("input_delays has 1 entries, must have 2"));
  system = ExampleSystem();
  system.output_delays = {-1};
  EXPECT_THAT(SystemRefusal(system), HasSubstr("output_delays holds -1"));
  system = ExampleSystem();
  system.A(2, 2) = 1.001;
  EXPECT_THAT(SystemRefusal(system), HasSubstr("unstable"));
  system.A(2, 2) = -1.0;
  EXPECT_THAT(SystemRefusal(system), HasSubstr("unstable"));
  system.A(2, 2) = 1.0;
  EXPECT_EQ(SystemRefusal(system), "");
  // The third state integrates, and the first integrates it.
  system.A = Eigen::Matrix3d{{1.0, 0.0, 0.5}, {0.0, 0.7, 0.0}, {0.0, 0.0, 1.0}};
  EXPECT_THAT(SystemRefusal(system), HasSubstr("integrates twice"));
}

constexpr char kValidSystem[] = R"({
  "version": 1, "name": "tank", "time_unit": "min",
  "sample_time": 0.5, "order": 2,
  "outputs": ["level"], "inputs": ["inflow", "heat"],
  "accuracy": {"error_bounds": [0.004], "largest_differences": [0.001]},
  "input_delays": [3, 0], "output_delays": [1],
  "A": [[0.9, 0.125], [0.0, 0.25]],
  "B": [[1, 2], [3, 4]],
  "C": [[0.0625, 7]],
  "D": [[0, 0]]
})";

std::string SystemMessageWith(const std::string& from, const std::string& to) {
  const std::string text = absl::StrReplaceAll(kValidSystem, {{from, to}});
  EXPECT_NE(text, kValidSystem) << from;
  const auto named = ParseStateSpace(text, "s.json");
  EXPECT_FALSE(named.ok()) << text;
  return std::string(named.status().message());
}

TEST(StateSpaceJsonTest, ReadsEveryKey) {
  const auto named = ParseStateSpace(kValidSystem, "s.json");
  ASSERT_TRUE(named.ok()) << named.status();
  EXPECT_EQ(named->name, "tank");
  EXPECT_EQ(named->time_unit, "min");
  EXPECT_EQ(named->outputs, std::vector<std::string>{"level"});
  EXPECT_EQ(named->inputs, (std::vector<std::string>{"inflow", "heat"}));
  const DiscreteStateSpace& system = named->system;
  EXPECT_EQ(system.sample_time, 0.5);
  EXPECT_EQ(system.A, (Eigen::Matrix2d{{0.9, 0.125}, {0.0, 0.25}}));
  EXPECT_EQ(system.B, (Eigen::Matrix2d{{1.0, 2.0}, {3.0, 4.0}}));
  EXPECT_EQ(system.C, (Eigen::RowVector2d{0.0625, 7.0}));
  EXPECT_EQ(system.D, Eigen::RowVector2d::Zero());
  EXPECT_EQ(system.input_delays, (std::vector<int>{3, 0}));
  EXPECT_EQ(system.output_delays, std::vector<int>{1});
  ASSERT_TRUE(named->accuracy.has_value());
  EXPECT_EQ(named->accuracy->error_bounds, std::vector<double>{0.004});
  EXPECT_EQ(named->accuracy->largest_differences, std::vector<double>{0.001});
}

// What a person has: matrices and names.
TEST(StateSpaceJsonTest, ReadsTheShortestFile) {
  const auto named = ParseStateSpace(
      R"({"name": "tank", "time_unit": "min", "sample_time": 0.5,
          "outputs": ["level"], "inputs": ["inflow", "heat"],
          "input_units": ["t/h", "kW"], "output_units": ["m"],
          "disturbances": ["heat"],
          "A": [[0.5]], "B": [[1, 2]], "C": [[1]]})",
      "s.json");
  ASSERT_TRUE(named.ok()) << named.status();
  EXPECT_EQ(named->system.D, Eigen::MatrixXd::Zero(1, 2));
  EXPECT_EQ(named->system.input_delays, std::vector<int>({0, 0}));
  EXPECT_EQ(named->system.output_delays, std::vector<int>({0}));
  const ProcessModel channels = named->Channels();
  EXPECT_EQ(channels.inputs()[0].unit, "t/h");
  EXPECT_EQ(channels.inputs()[1].role, InputRole::kDisturbance);
  EXPECT_EQ(channels.outputs()[0].unit, "m");
  NamedStateSpace copy = *named;
  copy.SetChannels(channels);
  EXPECT_EQ(FormatStateSpace(copy), FormatStateSpace(*named));
  EXPECT_THAT(
      SystemMessageWith("\"accuracy\"",
                        "\"disturbances\": [\"wind\"], \"accuracy\""),
      HasSubstr("\"wind\" is not an input; the inputs are inflow, heat"));
  EXPECT_THAT(SystemMessageWith("\"accuracy\"",
                                "\"input_units\": [\"kW\"], \"accuracy\""),
              HasSubstr("input_units has 1 units, must have 2"));
}

TEST(StateSpaceJsonTest, ReadsBackWhatItWritesBitByBit) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  NamedStateSpace named;
  named.name = "a \"b\"\n";
  named.time_unit = "µs";
  named.outputs = {"y1", "y2"};
  named.inputs = {"u"};
  const auto fill = [&](int rows, int cols) {
    Eigen::MatrixXd matrix(rows, cols);
    for (double& value : matrix.reshaped()) {
      value =
          std::ldexp(normal(random), static_cast<int>(random() % 600) - 300);
    }
    return matrix;
  };
  DiscreteStateSpace& system = named.system;
  system.sample_time = 0.1;
  // Triangular, so that its eigenvalues are its diagonal.
  system.A = fill(5, 5).triangularView<Eigen::StrictlyUpper>();
  system.A.diagonal() << 0.1, -0.9, 1.0 / 3.0, 0.0, -0.0;
  system.B = fill(5, 1);
  system.C = fill(2, 5);
  system.D = fill(2, 1);
  system.D(0, 0) = std::numeric_limits<double>::denorm_min();
  system.input_delays = {7};
  system.output_delays = {0, 12};
  named.accuracy = StateSpaceAccuracy{{0.1, 1e-300}, {0.0, 0.3}};
  const auto again = ParseStateSpace(FormatStateSpace(named), "b");
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->system.A, system.A);
  EXPECT_TRUE(std::signbit(again->system.A(4, 4)));
  EXPECT_EQ(again->system.B, system.B);
  EXPECT_EQ(again->system.C, system.C);
  EXPECT_EQ(again->system.D, system.D);
  EXPECT_EQ(again->system.sample_time, system.sample_time);
  EXPECT_EQ(again->system.input_delays, system.input_delays);
  EXPECT_EQ(again->system.output_delays, system.output_delays);
  EXPECT_EQ(again->name, named.name);
  EXPECT_EQ(again->outputs, named.outputs);
  EXPECT_EQ(again->inputs, named.inputs);
  EXPECT_EQ(again->accuracy->error_bounds, named.accuracy->error_bounds);
  EXPECT_EQ(again->accuracy->largest_differences,
            named.accuracy->largest_differences);
}

// A walk and a lag behind it, of the first of two outputs.
DisturbanceForm ExampleDisturbance() {
  return {.A = Eigen::Matrix2d{{1.0, 0.0}, {0.0, 1.0 / 3.0}},
          .C = Eigen::Matrix2d{{1.0, 1.0}, {0.0, 0.0}},
          .K = Eigen::Matrix2d{{0.3, 0.0}, {0.1, 0.0}},
          .Q = Eigen::Matrix2d{{1e-7, 0.0}, {0.0, 1e-300}},
          .R = Eigen::Vector2d(0.1, 0.0)};
}

TEST(StateSpaceJsonTest, ReadsBackADisturbanceModelBitByBit) {
  NamedStateSpace named;
  named.name = "tank";
  named.time_unit = "min";
  named.outputs = {"level", "heat"};
  named.inputs = {"inflow"};
  named.system.sample_time = 1.0;
  named.system.A = Eigen::MatrixXd{{0.5}};
  named.system.B = Eigen::MatrixXd{{1.0}};
  named.system.C = Eigen::MatrixXd{{1.0}, {2.0}};
  named.system.D = Eigen::MatrixXd::Zero(2, 1);
  named.system.input_delays = {0};
  named.system.output_delays = {0, 3};
  ASSERT_EQ(FormatStateSpace(named).find("disturbance_model"),
            std::string::npos);
  named.disturbance_model = ExampleDisturbance();
  const auto again = ParseStateSpace(FormatStateSpace(named), "b");
  ASSERT_TRUE(again.ok()) << again.status();
  ASSERT_TRUE(again->disturbance_model.has_value());
  const DisturbanceForm& form = *again->disturbance_model;
  EXPECT_EQ(form.A, named.disturbance_model->A);
  EXPECT_EQ(form.C, named.disturbance_model->C);
  EXPECT_EQ(form.K, named.disturbance_model->K);
  EXPECT_EQ(form.Q, named.disturbance_model->Q);
  EXPECT_EQ(form.R, named.disturbance_model->R);
  EXPECT_EQ(FormatStateSpace(*again), FormatStateSpace(named));
}

TEST(StateSpaceJsonTest, FaultsOfADisturbanceModelNameTheKey) {
  const std::string valid =
      R"({"A": [[1, 0], [0, 0.5]], "C": [[1, 1]], "K": [[0.3], [0.1]],
          "Q": [[1, 0], [0, 1]], "R": [2]})";
  const auto message = [&](const std::string& from, const std::string& to) {
    const std::string text = absl::StrReplaceAll(valid, {{from, to}});
    EXPECT_NE(text, valid) << from;
    return SystemMessageWith(
        "\"A\": [[0.9", "\"disturbance_model\": " + text + ", \"A\": [[0.9");
  };
  EXPECT_TRUE(ParseStateSpace(absl::StrReplaceAll(
                                  kValidSystem,
                                  {{"\"A\"", "\"disturbance_model\": " + valid +
                                                 ", \"A\""}}),
                              "s.json")
                  .ok());
  EXPECT_THAT(message("[[1, 1]]", "[[1, 1, 1]]"),
              HasSubstr("disturbance_model.C[0]: must be a list of 2 numbers, "
                        "one for each state"));
  EXPECT_THAT(message("[[0.3], [0.1]]", "[[0.3]]"),
              HasSubstr("disturbance_model.K: must be a list of 2 rows, one "
                        "for each state"));
  EXPECT_THAT(message("[[1, 0], [0, 1]]", "[[1, 0]]"),
              HasSubstr("disturbance_model.Q: must be a list of 2 rows"));
  EXPECT_THAT(message("[2]", "[2, 2]"),
              HasSubstr("disturbance_model.R: must be a list of 1 numbers, one "
                        "for each output, is one of 2"));
  EXPECT_THAT(message("[2]", "[-2]"),
              AllOf(HasSubstr("disturbance_model: "),
                    HasSubstr("those of R not negative")));
  EXPECT_THAT(message("[[0.3], [0.1]]", "[[0], [0.1]]"),
              AllOf(HasSubstr("disturbance_model: A − K C"),
                    HasSubstr("an eigenvalue of magnitude 1")));
  EXPECT_THAT(message(R"("R": [2])", R"("r": [2])"),
              HasSubstr("disturbance_model: unknown key \"r\""));
  EXPECT_THAT(message(R"("K": [[0.3], [0.1]],)", ""),
              AllOf(HasSubstr("disturbance_model"), HasSubstr("\"K\"")));
}

TEST(DisturbanceFormTest, ShapesAndSizesAreChecked) {
  ASSERT_TRUE(ExampleDisturbance().Validate(2).ok());
  EXPECT_FALSE(ExampleDisturbance().Validate(1).ok());
  DisturbanceForm form = ExampleDisturbance();
  form.Q(0, 1) = std::numeric_limits<double>::infinity();
  EXPECT_THAT(std::string(form.Validate(2).message()),
              HasSubstr("must be finite"));
  form = ExampleDisturbance();
  form.K(0, 0) = 2.5;
  EXPECT_THAT(std::string(form.Validate(2).message()),
              HasSubstr("errors of the filter would grow"));
  EXPECT_FALSE(DisturbanceForm().Validate(2).ok());
}

TEST(StateSpaceJsonTest, FaultsNameTheKeyAndWhatWouldBeRight) {
  EXPECT_THAT(SystemMessageWith("\"order\": 2", "\"order\": 3"),
              AllOf(StartsWith("s.json: A: must be a list of 3 rows, one for "
                               "each state"),
                    HasSubstr("is one of 2")));
  EXPECT_THAT(SystemMessageWith("\"order\": 2", "\"order\": 0"),
              HasSubstr("order: must be a whole number from 1"));
  EXPECT_THAT(SystemMessageWith("\"version\": 1", "\"version\": 2"),
              HasSubstr("version: must be a whole number from 1 to 1"));
  EXPECT_THAT(SystemMessageWith("\"order\": 2", "\"Order\": 2"),
              HasSubstr("unknown key \"Order\"; allowed are name"));
  EXPECT_THAT(SystemMessageWith("\"D\": [[0, 0]]", "\"D\": [[0]]"),
              HasSubstr("D[0]: must be a list of 2 numbers, one for each "
                        "input, is one of 1"));
  EXPECT_THAT(SystemMessageWith("[[1, 2],", "[[1, null],"),
              HasSubstr("B[0][1]: must be a number"));
  EXPECT_THAT(SystemMessageWith("[3, 0]", "[3]"),
              HasSubstr("input_delays: must be a list of 2 whole numbers"));
  EXPECT_THAT(SystemMessageWith("[3, 0]", "[3, 0.5]"),
              HasSubstr("input_delays[1]: must be a whole number from 0"));
  EXPECT_THAT(
      SystemMessageWith("\"output_delays\": [1]", "\"output_delays\": [-1]"),
      HasSubstr("output_delays[0]: must be a whole number from 0"));
  EXPECT_THAT(SystemMessageWith("[0.004]", "[0.004, 1]"),
              HasSubstr("error_bounds must hold 1 finite numbers"));
  EXPECT_THAT(SystemMessageWith("[0.001]", "[-0.001]"),
              HasSubstr("largest_differences must hold"));
  EXPECT_THAT(SystemMessageWith("[0.9,", "[1.5,"), HasSubstr("unstable"));
  EXPECT_THAT(SystemMessageWith("\"heat\"", "\"level\""),
              HasSubstr("the name \"level\" is duplicated"));
  EXPECT_THAT(SystemMessageWith("0.5", "-0.5"), HasSubstr("must be positive"));
}

// A ramp and a mode that grows, which no input reaches: in coordinates of their
// own, and in turned ones.
TEST(StateSpaceJsonTest, LeavesOutStatesThatNoInputReaches) {
  constexpr char kHead[] =
      R"({"name": "n", "time_unit": "min", "sample_time": 1,
          "outputs": ["y"], "inputs": ["u"], )";
  for (const std::string matrices :
       {R"("A": [[0.9, 0, 0], [0, 1, 1], [0, 0, 1]], "B": [[0.2], [0], [0]],
           "C": [[1, 1, 0]]})",
        R"("A": [[0.9, 0], [0, 1.02]], "B": [[0.2], [0]], "C": [[1, 5]]})",
        R"("A": [[0.96, -0.06], [-0.06, 0.96]], "B": [[0.1], [0.1]],
           "C": [[1, 1]]})"}) {
    const absl::StatusOr<NamedStateSpace> named =
        ParseStateSpace(kHead + matrices, "a.json");
    ASSERT_TRUE(named.ok()) << named.status();
    ASSERT_EQ(named->system.order(), 1);
    EXPECT_GT(named->unreached_states, 0);
    EXPECT_NEAR(named->system.A(0, 0), 0.9, 1e-12);
    EXPECT_NEAR((named->system.C * named->system.B)(0, 0), 0.2, 1e-12);
  }
  // One that an input reaches is as wrong as ever.
  EXPECT_THAT(
      std::string(ParseStateSpace(
                      std::string(kHead) +
                          R"("A": [[0.9, 0], [0, 1.02]], "B": [[0.2], [0.1]],
                     "C": [[1, 0]]})",
                      "a.json")
                      .status()
                      .message()),
      HasSubstr("eigenvalue of magnitude 1.02"));
}

TEST(StateSpaceJsonTest, NamesAFileThatIsNotThere) {
  EXPECT_THAT(std::string(ReadStateSpace("/no/s.json").status().message()),
              HasSubstr("/no/s.json"));
}

TEST(StateSpaceTest, WithoutStatesTheGainsAreTheFeedthrough) {
  DiscreteStateSpace system;
  system.sample_time = 1.0;
  system.A.resize(0, 0);
  system.B.resize(0, 1);
  system.C.resize(2, 0);
  system.D = Eigen::MatrixXd{{1.5}, {-2.0}};
  EXPECT_EQ(system.StaticGains(), system.D);
  EXPECT_EQ(system.Slopes(), Eigen::MatrixXd::Zero(2, 1));
}

}  // namespace
}  // namespace mle
