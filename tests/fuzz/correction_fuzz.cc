// A whole correction of a small plant, model and record made of the bytes:
// ageing, noise, bad samples, values at the ends of the range of numbers. It
// ends with an error in words, or with a result without NaN in what is used.

#include <cmath>
#include <vector>

#include "mle/base/double_limits.h"
#include "mle/maintain/correct.h"
#include "tests/fuzz/fuzz.h"

namespace mle {
namespace {

// Mostly ordinary, sometimes at the ends of the range.
double Extreme(fuzz::Bytes& bytes, double ordinary) {
  const int kind = bytes.Next();
  if (kind < 208) return ordinary * (1.0 + (kind % 8) / 4.0);
  constexpr double kValues[] = {0.0,     -1.0,   1e-300, 1e-12, 1e-3,  1e3,
                                1e12,    1e77,   1e150,  1e154, 1e155, 1e300,
                                1.7e308, 1e-155, 30.0,   -1e100};
  return kValues[kind % 16];
}

TransferFunction ElementFrom(fuzz::Bytes& bytes) {
  const double gain = bytes.Between(-8, 8) / 2.0;
  const double delay = std::abs(Extreme(bytes, 1.0));
  const int order = bytes.Next() % 16;
  if (order < 10) {
    return TransferFunction::FirstOrder(Extreme(bytes, gain),
                                        std::abs(Extreme(bytes, 4.0)), delay);
  }
  // Σ_i b_i s^i / Π (T_i s + 1).
  const int degree = order < 15 ? order % 4 + 1 : 12;
  std::vector<double> denominator = {1.0};
  for (int i = 0; i < degree; ++i) {
    const double time = std::abs(Extreme(bytes, 1.0 + i));
    std::vector<double> product(denominator.size() + 1, 0.0);
    for (std::size_t k = 0; k < denominator.size(); ++k) {
      product[k] += time * denominator[k];
      product[k + 1] += denominator[k];
    }
    denominator = product;
  }
  std::vector<double> numerator = {gain};
  if (bytes.Flag()) numerator.insert(numerator.begin(), Extreme(bytes, 1.0));
  return {std::move(numerator), std::move(denominator), delay};
}

// A curve that mostly holds what records have.
Transform TransformFrom(fuzz::Bytes& bytes) {
  Transform transform;
  transform.kind = static_cast<TransformKind>(
      bytes.Between(1, static_cast<int>(TransformKind::kPiecewiseLinear)));
  transform.at = Extreme(bytes, 1.0);
  transform.curvature = Extreme(bytes, bytes.Flag() ? 0.05 : -0.05);
  transform.rangeability = Extreme(bytes, 20.0);
  transform.low = transform.zero = Extreme(bytes, -20.0);
  transform.high = Extreme(bytes, 20.0);
  transform.exponent = Extreme(bytes, 0.5);
  transform.points = {
      {transform.low, -9.0}, {-1.0, -2.0}, {2.0, 3.0}, {transform.high, 9.0}};
  return transform;
}

ProcessModel ModelFrom(fuzz::Bytes& bytes) {
  const int shape = bytes.Next();
  std::vector<InputChannel> inputs = {{"steam", ""}};
  std::vector<OutputChannel> outputs = {{"level", ""}};
  if ((shape & 1) != 0) inputs.push_back({"inflow", ""});
  if ((shape & 2) != 0) outputs.push_back({"heat", ""});
  ProcessModel model("tank", "min", inputs, outputs);
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (i == j || (shape & 4) == 0) model.element(i, j) = ElementFrom(bytes);
    }
  }
  if ((shape & 8) != 0) model.set_input_transform(0, TransformFrom(bytes));
  if ((shape & 16) != 0) model.set_output_transform(0, TransformFrom(bytes));
  return model;
}

// Inputs hold levels of the bytes; outputs are an aged tank's, or anything.
Record RecordFrom(fuzz::Bytes& bytes, const ProcessModel& model) {
  const int samples = bytes.Between(2, 120);
  Record record;
  record.sample_time = 1.0;
  record.inputs.resize(model.num_inputs(), samples);
  record.outputs.resize(model.num_outputs(), samples);
  record.set_points.resize(model.num_outputs(), samples);
  const int kind = bytes.Next();
  const double input_size = Extreme(bytes, 1.0);
  const double output_size = Extreme(bytes, 1.0);
  const int step = bytes.Between(1, 120);
  const int hold = bytes.Between(1, 40);
  Eigen::VectorXd levels = Eigen::VectorXd::Zero(model.num_inputs());
  Eigen::VectorXd state = Eigen::VectorXd::Zero(model.num_outputs());
  std::uint32_t noise = bytes.Next();
  for (int k = 0; k < samples; ++k) {
    if (k % hold == 0) {
      for (double& level : levels) level = bytes.Number();
    }
    record.inputs.col(k) = input_size * levels;
    for (int i = 0; i < model.num_outputs(); ++i) {
      noise = noise * 1664525u + 1013904223u;
      const double unit = noise / 4294967296.0 - 0.5;
      state(i) += 0.2 * ((i + 1) * levels.sum() - state(i));
      double value = state(i) + ((kind & 1) != 0 ? 0.05 * unit : 0.0);
      if ((kind & 2) != 0) value = bytes.Number();
      if ((kind & 4) != 0) value = 1.0;
      if ((kind & 8) != 0 && noise % 29 == 0) value = kNaN;
      record.outputs(i, k) = output_size * value;
      record.set_points(i, k) = k % (2 * step) < step ? 0.0 : output_size;
    }
  }
  return record;
}

CorrectOptions OptionsFrom(fuzz::Bytes& bytes) {
  CorrectOptions options;
  const int flags = bytes.Next();
  options.estimation.estimator =
      flags % 4 == 3 ? Estimator::kArx : Estimator::kOutputError;
  options.estimation.change_test =
      (flags & 4) != 0 ? ChangeTest::kChiSquare : ChangeTest::kCalibrated;
  options.make_arx = (flags & 8) != 0;
  options.examine = (flags & 16) != 0;
  options.records.windows.before = 10.0;
  options.records.windows.after = 40.0;
  options.threads = 1;
  return options;
}

void CheckResult(const CorrectionResult& result) {
  FUZZ_EXPECT(!result.reasons.empty() || !result.failures.empty() ||
              result.decision != Decision::kCannotTell);
  if (!result.usable()) return;
  FUZZ_EXPECT(result.model.Validate().ok(), result.model.Validate().ToString());
  FUZZ_EXPECT(result.corrected.response.values.allFinite());
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  if (size > 1024) return 0;
  mle::fuzz::Bytes bytes(data, size);
  const mle::CorrectOptions options = mle::OptionsFrom(bytes);
  const mle::ProcessModel model = mle::ModelFrom(bytes);
  const mle::Record record = mle::RecordFrom(bytes, model);
  if (!model.Validate().ok()) return 0;
  const auto result = mle::CorrectFromRecords(model, {record}, options);
  if (!result.ok()) {
    const std::string message(result.status().message());
    FUZZ_EXPECT(!message.empty());
    FUZZ_EXPECT(message.find("[nan") == std::string::npos, message);
    return 0;
  }
  mle::CheckResult(*result);
  return 0;
}
