#include "benchmarks/problems.h"

#include <random>
#include <utility>

#include "control/mpc.h"
#include "glog/logging.h"
#include "mle/correction/conversion.h"
#include "mle/correction/excitation.h"
#include "mle/model/process_model.h"
#include "sim/closed_loop.h"

namespace mle::benchmarks {
namespace {

constexpr double kSampleTime = 0.2;  // min
constexpr double kNoiseVariance = 1e-3;

template <typename T>
T ValueOrDie(absl::StatusOr<T> value) {
  CHECK(value.ok()) << value.status();
  return *std::move(value);
}

ProcessModel WoodBerry(const std::string& ageing) {
  return ValueOrDie(ReadProcessModel(std::string(MLE_CONFIG_DIR "/wood_berry") +
                                     (ageing.empty() ? "" : "_" + ageing) +
                                     ".json"));
}

// A record with its rows; the responses are the outputs.
void AddRecord(const Record& record, int order, Problem& problem) {
  const LaggedSeries& series =
      problem.series.emplace_back(record, order, ChannelMeans({record}));
  for (const RowRange range : series.UsableRows()) {
    problem.rows.push_back({&series, range, series.Outputs(range)});
  }
}

Record Excite(const ProcessModel& model, std::uint64_t seed, int samples) {
  ExcitationOptions options;
  options.sample_time = kSampleTime;
  options.duration = kSampleTime * (samples - 1);
  options.noise_variance = kNoiseVariance;
  options.seed = seed;
  return ValueOrDie(SimulateExcitation(model, options));
}

// ±200 min around the set-point step of output `stepped`.
Record ClosedLoopWindow(const ProcessModel& initial, const ProcessModel& aged,
                        int stepped, std::uint64_t seed) {
  control::MpcOptions mpc_options;
  mpc_options.output_weight = 0.2 * Eigen::MatrixXd::Identity(2, 2);
  mpc_options.move_weight = 0.1 * Eigen::MatrixXd::Identity(2, 2);
  control::Mpc mpc = ValueOrDie(control::Mpc::Create(initial, mpc_options));
  sim::SetPointProfile set_points;
  for (int before = 0; before < stepped; ++before) {
    set_points.steps.push_back({before, 0.0, 1.0});
  }
  set_points.steps.push_back({stepped, 500.0, 1.0});
  sim::ClosedLoopOptions loop;
  loop.sample_time = kSampleTime;
  loop.noise_variance = kNoiseVariance;
  loop.seed = seed;
  loop.stream = static_cast<std::uint64_t>(stepped);
  const Record record = ValueOrDie(sim::SimulateClosedLoop(
      aged,
      [&mpc](const auto& measured, const auto& wanted, auto next) {
        mpc.Step(measured, wanted, next);
      },
      set_points, loop));
  return ValueOrDie(CutWindow(record, 2500, 200.0, 200.0));
}

}  // namespace

std::int64_t Problem::num_rows() const {
  std::int64_t sum = 0;
  for (const RegressionRows& part : rows) sum += part.rows.rows();
  return sum;
}

Problem WoodBerryCorrection(const std::string& ageing, std::uint64_t seed,
                            int order) {
  const ProcessModel initial = WoodBerry("");
  const ProcessModel aged = WoodBerry(ageing);
  ConversionOptions conversion;
  conversion.order = order;
  const ArxModel model =
      ValueOrDie(ConvertToArx(Excite(initial, seed, 50001), conversion)).model;
  Problem problem;
  for (int stepped = 0; stepped < 2; ++stepped) {
    AddRecord(ClosedLoopWindow(initial, aged, stepped, seed), order, problem);
  }
  for (RegressionRows& rows : problem.rows) {
    rows.responses.noalias() -= model.R * rows.series->Regressors(rows.rows);
  }
  return problem;
}

Problem WoodBerryConversion(std::uint64_t seed, int rows, int order) {
  Problem problem;
  AddRecord(Excite(WoodBerry(""), seed, rows + order), order, problem);
  return problem;
}

Problem SyntheticPlant(int num_outputs, int num_inputs, int rows, int order,
                       std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const auto name = [](const char* kind, int i) {
    return kind + std::to_string(i + 1);
  };
  std::vector<InputChannel> inputs;
  for (int j = 0; j < num_inputs; ++j) inputs.push_back({name("u", j), ""});
  std::vector<OutputChannel> outputs;
  for (int i = 0; i < num_outputs; ++i) outputs.push_back({name("y", i), ""});
  ProcessModel plant("synthetic", "min", inputs, outputs);
  for (int i = 0; i < num_outputs; ++i) {
    for (int j = 0; j < num_inputs; ++j) {
      const bool present = i % num_inputs == j || uniform(engine) < 0.5;
      const double gain = 4.0 * uniform(engine) - 2.0;
      const double time_constant = 2.0 + 15.0 * uniform(engine);
      const double delay = 8.0 * uniform(engine);
      if (!present) continue;
      plant.element(i, j) =
          TransferFunction::FirstOrder(gain, time_constant, delay);
    }
  }
  // A controller that heeds nothing: each input holds a level for a while.
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> hold(1, 20);
  std::vector<int> left(num_inputs, 0);
  Eigen::VectorXd level = Eigen::VectorXd::Zero(num_inputs);
  sim::ClosedLoopOptions loop;
  loop.sample_time = kSampleTime;
  loop.duration = kSampleTime * (rows + order - 1);
  loop.noise_variance = kNoiseVariance;
  loop.seed = seed;
  const Record record = ValueOrDie(sim::SimulateClosedLoop(
      plant,
      [&](const auto&, const auto&, auto next) {
        for (int j = 0; j < num_inputs; ++j) {
          if (left[j]-- > 0) continue;
          left[j] = hold(engine) - 1;
          level(j) = normal(engine);
        }
        next = level;
      },
      // Only tells the loop what size its outputs may have.
      {.steps = {{.output = 0, .time = 0.0, .value = 1.0}}}, loop));
  Problem problem;
  AddRecord(record, order, problem);
  return problem;
}

Problem WhiteSeries(int num_outputs, int num_inputs, int rows, int order) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(engine); };
  Record record;
  record.sample_time = kSampleTime;
  record.outputs =
      Eigen::MatrixXd::NullaryExpr(num_outputs, rows + order, draw);
  record.inputs = Eigen::MatrixXd::NullaryExpr(num_inputs, rows + order, draw);
  Problem problem;
  AddRecord(record, order, problem);
  return problem;
}

}  // namespace mle::benchmarks
