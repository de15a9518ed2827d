// mle_simulate as its users call it.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/historian.h"
#include "tests/apps/command_runner.h"

namespace mle {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr char kColumn[] = MLE_SOURCE_FOLDER "/configs/wood_berry.json";
constexpr char kAgedColumn[] =
    MLE_SOURCE_FOLDER "/configs/wood_berry_gain.json";
constexpr char kReactor[] = MLE_SOURCE_FOLDER "/configs/van_de_vusse.json";
constexpr char kTanks[] = MLE_SOURCE_FOLDER "/configs/quadruple_tank.json";
constexpr char kNeutralisation[] =
    MLE_SOURCE_FOLDER "/configs/ph_neutralisation.json";

constexpr char kTank[] = R"({"name": "tank", "time_unit": "min",
  "inputs": [{"name": "steam", "unit": ""},
             {"name": "inflow", "unit": "", "role": "disturbance"}],
  "outputs": [{"name": "level", "unit": ""}],
  "elements": [
    {"output": "level", "input": "steam",
     "gain": 2, "time_constant": 5, "delay": 1},
    {"output": "level", "input": "inflow",
     "gain": -1, "time_constant": 5, "delay": 4}]})";

// Runs the command, which must succeed, and reads its record.
Record Simulate(const ScratchFolder& scratch, const std::string& model,
                std::vector<std::string> arguments) {
  const std::string out = scratch / "run.csv";
  arguments.push_back("--model=" + model);
  arguments.push_back("--out=" + out);
  const report::ProcessResult result = RunTested(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const absl::StatusOr<ProcessModel> channels = ReadProcessModel(model);
  EXPECT_TRUE(channels.ok()) << channels.status();
  const auto import = ImportHistorian({out}, *channels, {.max_gap = 0.0});
  EXPECT_TRUE(import.ok()) << import.status();
  return import.ok() ? import->records.at(0) : Record();
}

double MeanOfLast(const Eigen::MatrixXd& rows, int row, int samples) {
  return rows.row(row).tail(samples).mean();
}

TEST(MleSimulateTest, AnAgedColumnFollowsItsSetPoints) {
  const ScratchFolder scratch;
  const Record record =
      Simulate(scratch, kColumn,
               {"--plant=" + std::string(kAgedColumn), "--duration=600",
                "--setpoints=overhead:100:1,bottoms:300.1:-0.5", "--seed=3"});
  EXPECT_EQ(record.samples(), 3001);
  EXPECT_EQ(record.sample_time, 0.2);
  const std::vector<SetPointChange> changes = FindSetPointChanges(record);
  ASSERT_EQ(changes.size(), 2u);
  EXPECT_EQ(changes[0].sample, 500);
  EXPECT_EQ(changes[1].sample, 1501);  // the first sample not before 300.1
  // The noise of 0.03 averages out to about 0.001.
  EXPECT_NEAR(MeanOfLast(record.outputs, 0, 500), 1.0, 0.02);
  EXPECT_NEAR(MeanOfLast(record.outputs, 1, 500), -0.5, 0.02);
}

TEST(MleSimulateTest, TheSameSeedGivesTheSameFile) {
  const ScratchFolder scratch;
  const std::vector<std::string> arguments = {
      "--model=" + std::string(kColumn), "--duration=20",
      "--drift_variance=1e-4,0", "--lost_probability=0.1"};
  std::vector<std::string> contents;
  for (const char* seed : {"7", "7", "8"}) {
    std::vector<std::string> run = arguments;
    const std::string out = scratch / "run.csv";
    run.push_back("--seed=" + std::string(seed));
    run.push_back("--out=" + out);
    EXPECT_EQ(RunTested(run).exit_code, 0);
    contents.push_back(Content(out));
  }
  EXPECT_EQ(contents[0], contents[1]);
  EXPECT_NE(contents[0], contents[2]);
}

// The gain halves at an event: in the end twice the input is needed.
TEST(MleSimulateTest, PlantsAge) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("tank.json", kTank);
  const std::string ageing =
      scratch.Write("ageing.json",
                    R"({"time_factor": 1000, "elements": [{"output": "level",
          "input": "steam", "gain": [[50.2, 1.0], [50.2, 0.5]]}]})");
  const Record record =
      Simulate(scratch, model,
               {"--ageing=" + ageing, "--age=50000", "--duration=400",
                "--setpoints=level:0:1", "--noise_variance=0"});
  EXPECT_NEAR(record.inputs(0, 999), 0.5, 1e-3);
  EXPECT_NEAR(MeanOfLast(record.inputs, 0, 1), 1.0, 1e-3);
  EXPECT_NEAR(MeanOfLast(record.outputs, 0, 1), 1.0, 1e-3);
}

// A disturbance whose effect takes longer than the input's can be cancelled.
TEST(MleSimulateTest, FeedForwardRejectsAMeasuredDisturbance) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("tank.json", kTank);
  const auto worst = [&](const std::string& flag) {
    const Record record =
        Simulate(scratch, model,
                 {flag, "--disturbances=inflow:50:1", "--duration=200",
                  "--noise_variance=0", "--move_weight=0.001"});
    EXPECT_EQ(record.inputs(1, 249), 0.0);
    EXPECT_EQ(record.inputs(1, 250), 1.0);
    return record.outputs.row(0).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(worst("--feed_forward"), 0.25 * worst("--nofeed_forward"));
}

TEST(MleSimulateTest, ControllerAndValvesKeepTheirLimits) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("tank.json", kTank);
  const std::vector<std::string> common = {"--setpoints=level:10:1",
                                           "--duration=100"};
  const auto run = [&](std::vector<std::string> flags) {
    flags.insert(flags.end(), common.begin(), common.end());
    return Simulate(scratch, model, std::move(flags));
  };
  EXPECT_GT(run({}).inputs.row(0).maxCoeff(), 0.5);
  EXPECT_LE(run({"--max_input=0.3,none"}).inputs.row(0).maxCoeff(), 0.3);
  EXPECT_EQ(run({"--valve_max=0.2"}).inputs.row(0).maxCoeff(), 0.2);
}

TEST(MleSimulateTest, TheRecordLooksLikeAHistorians) {
  const ScratchFolder scratch;
  const Record record =
      Simulate(scratch, kColumn,
               {"--duration=400", "--quantum=0.01", "--lost_probability=0.05",
                "--lost_input_probability=0.02", "--freeze_rate=0.01",
                "--outlier_probability=0.01", "--outlier_size=1",
                "--coloured_variance=1e-3", "--disturbance_step_rate=0.01",
                "--disturbance_step_deviation=0.1", "--faults_only_in_record"});
  int finite = 0;
  for (const double value : record.outputs.reshaped()) {
    if (std::isnan(value)) continue;
    ++finite;
    ASSERT_NEAR(100.0 * value, std::round(100.0 * value), 1e-9);
  }
  EXPECT_NEAR(finite / (2.0 * 2001.0), 0.95, 0.03);
  EXPECT_GT(record.inputs.array().isNaN().count(), 0);
}

TEST(MleSimulateTest, TheReactorFollowsTheLinearControllerOfItsModel) {
  const ScratchFolder scratch;
  const Record record = Simulate(
      scratch, kReactor,
      {"--plant=van_de_vusse", "--sample_time=0.005", "--control_period=0.02",
       "--duration=4", "--setpoints=product:0.5:0.02,temperature:2:1",
       "--noise_variance=0", "--output_weight=100,1",
       "--move_weight=0.001,0.000001"});
  EXPECT_NEAR(MeanOfLast(record.outputs, 0, 10), 0.02, 1e-3);
  EXPECT_NEAR(MeanOfLast(record.outputs, 1, 10), 1.0, 1e-2);
}

// Spent catalyst makes less product of the same feed: at rest, and once the
// loop asks for the old product, with another feed.
TEST(MleSimulateTest, TheReactorAges) {
  const ScratchFolder scratch;
  const std::string ageing =
      scratch.Write("ageing.json",
                    R"({"time_factor": 100, "activity": [[0, 1.0], [1, 0.7]],
          "heat_transfer": 0.9})");
  const auto feed = [&](const std::string& age) {
    return Simulate(
               scratch, kReactor,
               {"--plant=van_de_vusse", "--ageing=" + ageing, "--age=" + age,
                "--sample_time=0.005", "--control_period=0.02", "--duration=4",
                "--setpoints=product:0.5:0.02", "--noise_variance=0",
                "--output_weight=100,1", "--move_weight=0.001,0.000001"})
        .inputs(0, 750);
  };
  const double before = feed("-10");
  EXPECT_GT(std::abs(before), 0.05);
  EXPECT_GT(std::abs(feed("200") / before - 1.0), 0.05);
}

TEST(MleSimulateTest, TheTanksFollowTheLinearControllerOfTheirModel) {
  const ScratchFolder scratch;
  const Record record =
      Simulate(scratch, kTanks,
               {"--plant=quadruple_tank", "--sample_time=2",
                "--control_period=4", "--prediction_horizon=40",
                "--duration=1200", "--noise_variance=0", "--output_weight=1",
                "--move_weight=1", "--setpoints=level1:100:3,level2:600:-3"});
  EXPECT_NEAR(MeanOfLast(record.outputs, 0, 10), 3.0, 1e-2);
  EXPECT_NEAR(MeanOfLast(record.outputs, 1, 10), -3.0, 1e-2);
}

TEST(MleSimulateTest, TheNeutralisationFollowsTheLinearControllerOfItsModel) {
  const ScratchFolder scratch;
  const Record record =
      Simulate(scratch, kNeutralisation,
               {"--plant=ph_neutralisation", "--sample_time=3",
                "--control_period=6", "--prediction_horizon=40",
                "--duration=2400", "--noise_variance=0", "--output_weight=1,10",
                "--move_weight=1", "--setpoints=level:100:1.5,pH:900:-0.7"});
  EXPECT_NEAR(MeanOfLast(record.outputs, 0, 10), 1.5, 1e-2);
  EXPECT_NEAR(MeanOfLast(record.outputs, 1, 10), -0.7, 1e-2);
}

// A pump that lifts 0.8 of what it did needs 1 / 0.8 of the voltage: at rest
// there, the loop moves as if new, by 1 / 0.8 as much.
TEST(MleSimulateTest, TheTanksAge) {
  const ScratchFolder scratch;
  const std::string ageing =
      scratch.Write("ageing.json", R"({"pump1": [[0, 1.0], [10, 0.8]]})");
  const auto voltage = [&](const std::string& age, const std::string& inputs) {
    return Simulate(
               scratch, kTanks,
               {"--plant=quadruple_tank", "--ageing=" + ageing, "--age=" + age,
                "--operating_inputs=" + inputs, "--sample_time=2",
                "--control_period=4", "--prediction_horizon=40",
                "--duration=1000", "--noise_variance=0", "--output_weight=1",
                "--move_weight=1", "--setpoints=level1:100:2"})
        .inputs(0, 490);
  };
  const double fresh = voltage("-5000", "3,3");
  EXPECT_GT(fresh, 0.3);
  EXPECT_NEAR(voltage("200", "3.75,3") / fresh, 1.25, 1e-3);
}

// Effects of one channel by name; the same seed gives the same bytes.
TEST(MleSimulateTest, EffectsComeFromAFile) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("tank.json", kTank);
  const std::string effects = scratch.Write("effects.json", R"({
    "outputs": [{"name": "level", "arma": {"poles": [0.9], "variance": 0.01},
                 "set_point": {"optimiser": {"interval": 20, "deviation": 1}},
                 "archive": {"compression": 0.05}}],
    "inputs": [{"name": "steam", "load": {"variance": 0.01},
                "actuator": {"stiction": 0.05}}]})");
  std::vector<std::string> contents;
  for (const char* seed : {"7", "7", "8"}) {
    const std::string out = scratch / "run.csv";
    EXPECT_EQ(
        RunTested({"--model=" + model, "--effects=" + effects, "--duration=200",
                   "--seed=" + std::string(seed), "--out=" + out})
            .exit_code,
        0);
    contents.push_back(Content(out));
  }
  EXPECT_EQ(contents[0], contents[1]);
  EXPECT_NE(contents[0], contents[2]);
  const Record record =
      Simulate(scratch, model, {"--effects=" + effects, "--duration=200"});
  EXPECT_EQ(FindSetPointChanges(record).size(), 9u);  // at 20, 40, … 180
}

TEST(MleSimulateTest, AnUnstableLoopIsReported) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("tank.json", kTank);
  std::string slow = kTank;
  slow.replace(slow.find("\"gain\": 2"), 9, "\"gain\": -2");
  const std::string plant = scratch.Write("plant.json", slow);
  const std::string out = scratch / "run.csv";
  const report::ProcessResult result =
      RunTested({"--model=" + model, "--plant=" + plant, "--out=" + out,
                 "--duration=100000"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("the closed loop diverges"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(MleSimulateTest, BadInputIsRefusedInOneLine) {
  const ScratchFolder scratch;
  const std::string model = scratch.Write("tank.json", kTank);
  const std::string ageing =
      scratch.Write("ageing.json", R"({"elements": [{"output": "level",
          "input": "steam", "gian": 2}]})");
  const struct {
    std::string flag;
    std::string named;
  } cases[] = {
      {"--setpoints=levle:1:1",
       "--setpoints: 'levle:1:1': there is no 'levle'"},
      {"--setpoints=level:1", "not of the form NAME:TIME:VALUE"},
      {"--setpoints=level:x:1", "TIME and VALUE must be numbers"},
      {"--setpoints=level:2000:1", "--duration=1000"},
      {"--plant=" + scratch / "none.json", "none.json"},
      {"--plant=" + std::string(kColumn), "inputs[0] is \"steam\""},
      {"--plant=van_de_vusse", "van_de_vusse"},
      {"--ageing=" + ageing, "elements[0]: unknown key \"gian\""},
      {"--effects=" + ageing, "ageing.json: unknown key \"elements\""},
      {"--disturbances=steam:1:1", "'steam' is moved by the controller"},
      {"--max_input=1,2,3", "--max_input=1,2,3: 3 values"},
      {"--max_input=a", "--max_input=a: 'a' is not a number, or none"},
      {"--valve_min=1", "valves"},
      {"--quantum=-1", "--quantum=-1: '-1' must be ≥ 0"},
      {"--lost_probability=2",
       "--lost_probability=2: it must be a finite number in [0, 1]"},
      {"--noise_variance=-1",
       "--noise_variance=-1: it must be a finite number ≥ 0"},
      {"--control_period=0.3", "whole multiple of sample_time = 0.2"},
      {"--control_horizon=40", "horizon"},
      {"--move_weight=-1", "move"},
      {"--no_such_flag=1", "no_such_flag"},
      {"--out=" + scratch / "no_folder/run.csv", "no_folder"},
  };
  for (const auto& bad : cases) {
    SCOPED_TRACE(bad.flag);
    std::vector<std::string> arguments = {"--model=" + model,
                                          "--out=" + scratch / "run.csv"};
    if (bad.flag == "--valve_min=1") arguments.push_back("--valve_max=0");
    arguments.push_back(bad.flag);
    const report::ProcessResult result = RunTested(arguments);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, StartsWith("error: "));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1)
        << result.err;
    EXPECT_THAT(result.err, HasSubstr(bad.named));
    EXPECT_FALSE(std::filesystem::exists(scratch / "run.csv"));
  }
}

TEST(MleSimulateTest, ANonLinearPlantNamesWhatItCannotDo) {
  const ScratchFolder scratch;
  const std::string split =
      scratch.Write("split.json", R"({"split1": [[0, 1], [9, 1.5]]})");
  const std::string reactor =
      scratch.Write("reactor.json", R"({"activity": 0.9})");
  for (const auto& [flag, named] :
       {std::pair<std::string, std::string>(
            "--operating_inputs=3",
            "--operating_inputs=3: pump1 (V) and pump2 (V) are needed"),
        {"--operating_inputs=3,-1", "--plant: voltage2 = -1"},
        {"--ageing=" + split, "--plant: split1 = 0.7 becomes 1.05"},
        {"--ageing=" + reactor, "unknown key \"activity\""}}) {
    const report::ProcessResult result =
        RunTested({"--model=" + std::string(kTanks), "--plant=quadruple_tank",
                   "--out=" + scratch / "run.csv", flag});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(named));
  }
}

TEST(MleSimulateTest, ModelAndOutMustBeGiven) {
  const report::ProcessResult result = RunTested({});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("--model=FILE.json and --out=FILE.csv"));
}

}  // namespace
}  // namespace mle
