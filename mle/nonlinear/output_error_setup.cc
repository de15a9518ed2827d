#include "mle/nonlinear/output_error_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"

namespace mle {
namespace {

// A segment that is shorter tells less than its offset and amplitudes cost.
constexpr int kMinRows = 20;
// The same of an output that is not measured at every sample: of a
// laboratory's, at one sample in three or fewer, each tells as much as many
// neighbours.
constexpr int kMinHalfRows = 10;
constexpr int kMinSparseRows = 3;
constexpr double kHalf = 1.7;
constexpr int kSparse = 3;
// The automatic bounds of dead times take at most this share of the shortest
// record.
constexpr double kMaxSkippedShare = 0.25;
// T in samples: a faster element cannot be told from a jump.
constexpr double kMinTimeScaleSamples = 0.05;
// The least time scale, in samples, of an integrator without lag: its dead time
// is searched by it.
constexpr double kTimeScaleSamples = 10.0;

std::string Name(const ProcessModel& model, int i, int j) {
  return absl::StrCat("output-error correction: element of output \"",
                      model.outputs()[i].name, "\", input \"",
                      model.inputs()[j].name, "\"");
}

absl::Status CheckRecords(const ProcessModel& model,
                          const std::vector<Record>& records) {
  if (records.empty()) {
    return absl::InvalidArgumentError(
        "output-error correction: there is no record, at least 1 is needed");
  }
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Record& record = records[r];
    const absl::Status status = record.Validate();
    if (!status.ok()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "output-error correction: records[", r, "]: ", status.message()));
    }
    if (record.num_outputs() != model.num_outputs() ||
        record.num_inputs() != model.num_inputs()) {
      return absl::InvalidArgumentError(absl::StrCat(
          "output-error correction: records[", r, "] has ",
          record.num_outputs(), " outputs and ", record.num_inputs(),
          " inputs, the model ", model.num_outputs(), " and ",
          model.num_inputs(), "; they must be the same"));
    }
    if (record.sample_time != records[0].sample_time) {
      return absl::InvalidArgumentError(absl::StrCat(
          "output-error correction: records[", r, "] is sampled every ",
          record.sample_time, ", records[0] every ", records[0].sample_time,
          "; the sample times must be the same"));
    }
  }
  return absl::OkStatus();
}

int MeasuredSamples(const Record& record) {
  return record.samples() - record.lead();
}

absl::StatusOr<double> MaxDelay(const ProcessModel& model, int i, int j,
                                const ElementValues& initial,
                                const std::vector<Record>& records,
                                const OutputErrorOptions& options) {
  double shortest = std::numeric_limits<double>::infinity();
  double longest = 0.0;
  for (const Record& record : records) {
    const double length = MeasuredSamples(record) * record.sample_time;
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
  if (std::isfinite(options.max_delay)) {
    if (options.max_delay >= longest) {
      return OptionError("max_delay",
                         absl::StrCat("output-error correction: max_delay = ",
                                      options.max_delay,
                                      ", must be less than the longest stretch "
                                      "of the records, ",
                                      longest));
    }
    if (options.max_delay < initial.delay) {
      return OptionError(
          "max_delay",
          absl::StrCat(Name(model, i, j), ": its dead time ", initial.delay,
                       " exceeds max_delay = ", options.max_delay,
                       "; the bounds must hold the start"));
    }
    return options.max_delay;
  }
  const double share = kMaxSkippedShare * shortest;
  if (share < initial.delay) {
    return absl::InvalidArgumentError(
        absl::StrCat(Name(model, i, j), ": its dead time ", initial.delay,
                     " is more than a quarter of the shortest record, ",
                     shortest, "; use longer records"));
  }
  return std::min(2.0 * initial.delay + initial.time_scale, share);
}

// Fitted values are squared and summed, and compared as variances: sizes beyond
// these, of values or of gains, leave double precision there.
constexpr double kLargest = 1e60;
constexpr double kSmallest = 1e-60;

// The largest size of a channel's values; records have none beyond kLargest.
absl::StatusOr<double> LargestSize(const char* kind, const std::string& name,
                                   const std::vector<Record>& records,
                                   Eigen::MatrixXd Record::*values, int row) {
  double largest = 0.0;
  for (const Record& record : records) {
    const auto size = (record.*values).row(row).array().abs();
    largest = std::max(largest, size.isFinite().select(size, 0.0).maxCoeff());
  }
  if (largest == 0.0 || largest >= kSmallest) return largest;
  return absl::InvalidArgumentError(
      absl::StrCat(kind, " \"", name, "\" has values up to ", largest,
                   "; where they are not 0 they may not stay below ", kSmallest,
                   ": check units and columns"));
}

// The largest gain at any frequency, up to a factor of the size of 1: of the
// ratios of coefficients of one power of s.
double LargestGain(const TransferFunction& element) {
  const std::vector<double>& numerator = element.numerator();
  const std::vector<double>& denominator = element.denominator();
  double largest = 0.0;
  for (std::size_t k = 1; k <= numerator.size(); ++k) {
    const double below = denominator[denominator.size() - k];
    if (below == 0.0) continue;  // of an integrator
    largest =
        std::max(largest, std::abs(numerator[numerator.size() - k] / below));
  }
  return largest;
}

// Checks the channels of records; returns the inputs' sizes.
absl::StatusOr<std::vector<double>> CheckValues(
    const ProcessModel& model, const std::vector<Record>& records) {
  for (int i = 0; i < model.num_outputs(); ++i) {
    MLE_RETURN_IF_ERROR(LargestSize("output", model.outputs()[i].name, records,
                                    &Record::outputs, i)
                            .status());
  }
  std::vector<double> sizes(model.num_inputs());
  for (int j = 0; j < model.num_inputs(); ++j) {
    MLE_ASSIGN_OR_RETURN(sizes[j], LargestSize("input", model.inputs()[j].name,
                                               records, &Record::inputs, j));
  }
  return sizes;
}

absl::Status CheckGains(const ProcessModel& model, int i,
                        const std::vector<double>& input_sizes,
                        const std::vector<ElementValues>& initial) {
  for (int j = 0; j < model.num_inputs(); ++j) {
    const double largest = input_sizes[j];
    const double gain =
        std::max(std::abs(initial[j].gain), LargestGain(model.element(i, j)));
    if (!(gain * largest <= kLargest)) {
      return absl::InvalidArgumentError(absl::StrCat(
          Name(model, i, j), ": a gain of ", gain, " makes responses up to ",
          gain * largest, "; they may not exceed ", kLargest,
          ": check gain and units"));
    }
    if (gain > 0.0 && gain < kSmallest) {
      return absl::InvalidArgumentError(
          absl::StrCat(Name(model, i, j), ": a gain of ", initial[j].gain,
                       " is too small to be fitted, less than ", kSmallest,
                       ": check gain and units, or leave the element out"));
    }
  }
  return absl::OkStatus();
}

// Samples that a segment of the output must have.
int LeastRows(const std::vector<Record>& records, int output) {
  Eigen::Index measured = 0;
  Eigen::Index samples = 0;
  for (const Record& record : records) {
    measured += record.outputs.row(output).array().isFinite().count();
    samples += MeasuredSamples(record);
  }
  if (kSparse * measured <= samples) return kMinSparseRows;
  const bool is_half =
      kHalf * static_cast<double>(measured) <= static_cast<double>(samples);
  return is_half ? kMinHalfRows : kMinRows;
}

// Whether the output is measured to move: a constant says that a sensor is
// dead, not that gains are zero.
bool Moves(const std::vector<Record>& records, int output) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const Record& record : records) {
    for (const double value : record.outputs.row(output)) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return low < high;
}

absl::StatusOr<OutputSetup> SetUpOutput(const ProcessModel& model, int i,
                                        const std::vector<Record>& records,
                                        const std::vector<double>& input_sizes,
                                        const OutputErrorOptions& options) {
  const int m = model.num_inputs();
  const double sample_time = records[0].sample_time;
  OutputErrorProblem::Elements elements(m);
  OutputSetup setup;
  setup.start.values.resize(m);
  setup.bounds.min_time_scales.resize(m);
  setup.bounds.max_time_scales.resize(m);
  setup.bounds.max_delays.resize(m);
  int num_parameters = 0;
  double longest = 0.0;
  for (int j = 0; j < m; ++j) {
    if (model.element(i, j).IsZero()) continue;
    absl::StatusOr<ElementResponse> element =
        ElementResponse::Create(model.element(i, j));
    if (!element.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat(Name(model, i, j), ": ", element.status().message()));
    }
    ElementValues initial = element->initial_values();
    if (!element->has_time_scale()) {
      initial.time_scale =
          std::max(initial.time_scale, kTimeScaleSamples * sample_time);
    }
    setup.start.values[j] = initial;
    MLE_ASSIGN_OR_RETURN(setup.bounds.max_delays[j],
                         MaxDelay(model, i, j, initial, records, options));
    setup.bounds.min_time_scales[j] =
        std::min(initial.time_scale,
                 std::max(initial.time_scale / options.max_time_scale_factor,
                          kMinTimeScaleSamples * sample_time));
    setup.bounds.max_time_scales[j] =
        initial.time_scale * options.max_time_scale_factor;
    longest = std::max(longest, setup.bounds.max_delays[j]);
    num_parameters += element->has_time_scale() ? 3 : 2;
    elements[j] = *std::move(element);
  }
  MLE_RETURN_IF_ERROR(CheckGains(model, i, input_sizes, setup.start.values));
  setup.start.SetCells(sample_time);
  const int skip = static_cast<int>(std::ceil(longest / sample_time)) + 1;
  const int least = LeastRows(records, i);
  setup.problem =
      std::make_unique<OutputErrorProblem>(elements, records, i, skip, least);
  if (options.at_rest != nullptr) {
    auto at_rest = std::make_unique<OutputErrorProblem>(
        std::move(elements), *options.at_rest, i, skip, least);
    if (at_rest->num_segments() > 0) {
      setup.problem->SetAtRest(std::move(at_rest));
    }
  }
  const int innovations = setup.problem->num_innovations(NoiseShape());
  const int needed = 2 * num_parameters + least;
  if (num_parameters > 0 && innovations < needed) {
    setup.samples = absl::InvalidArgumentError(absl::StrCat(
        "output-error correction: output \"", model.outputs()[i].name,
        "\" has ", innovations, " usable samples after the first ", skip,
        " of each record (the longest dead time allowed), too few for ",
        num_parameters, " parameters; at least ", needed, " are needed"));
  }
  setup.informed.resize(m);
  const bool moves = Moves(records, i);
  for (int j = 0; j < m; ++j) {
    setup.informed[j] = setup.samples.ok() && moves &&
                        setup.problem->elements()[j].has_value() &&
                        setup.problem->IsExcited(j);
  }
  return setup;
}

// A correction of a model of this size.
bool IsOf(const ProcessModel& model, const OutputErrorCorrection& correction) {
  const Eigen::Index p = model.num_outputs();
  const Eigen::Index m = model.num_inputs();
  return std::ssize(correction.full.elements) == p * m &&
         std::ssize(correction.full.noise) == p &&
         correction.aged.rows() == p && correction.aged.cols() == m &&
         correction.element_p_values.rows() == p &&
         correction.element_p_values.cols() == m;
}

}  // namespace

absl::Status OutputErrorOptions::Validate() const {
  const auto fault = [](const char* field, auto value, const char* constraint) {
    return absl::InvalidArgumentError(
        absl::StrCat("output-error correction: ", field, " is ", value,
                     ", must be ", constraint));
  };
  if (!(max_time_scale_factor > 1.0) || !std::isfinite(max_time_scale_factor)) {
    return fault("max_time_scale_factor", max_time_scale_factor,
                 "finite and above 1");
  }
  if (!(max_delay >= 0.0)) {
    return fault("max_delay", max_delay, "not negative");
  }
  if (!(false_alarm_probability > 0.0 && false_alarm_probability < 1.0)) {
    return fault("false_alarm_probability", false_alarm_probability,
                 "between 0 and 1");
  }
  if (!(confidence > 0.0 && confidence < 1.0)) {
    return fault("confidence", confidence, "between 0 and 1");
  }
  if (max_iterations < 1) {
    return fault("max_iterations", max_iterations, "at least 1");
  }
  if (threads < 0) return fault("threads", threads, "not negative");
  return absl::OkStatus();
}

absl::StatusOr<std::vector<OutputSetup>> SetUpOutputs(
    const ProcessModel& model, const std::vector<Record>& records,
    const OutputErrorOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(model.Validate());
  MLE_RETURN_IF_ERROR(CheckRecords(model, records));
  if (options.at_rest != nullptr && !options.at_rest->empty()) {
    std::vector<Record> all = {records.front()};
    all.insert(all.end(), options.at_rest->begin(), options.at_rest->end());
    MLE_RETURN_IF_ERROR(CheckRecords(model, all));
  }
  if (options.start != nullptr && !IsOf(model, *options.start)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "output-error correction: start has ",
        options.start->full.elements.size(), " elements, and ",
        options.start->aged.size(), " that may have aged, the model has ",
        model.num_outputs(), " × ", model.num_inputs()));
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<double> input_sizes,
                       CheckValues(model, records));
  std::vector<OutputSetup> setups;
  for (int i = 0; i < model.num_outputs(); ++i) {
    MLE_ASSIGN_OR_RETURN(OutputSetup setup,
                         SetUpOutput(model, i, records, input_sizes, options));
    setups.push_back(std::move(setup));
  }
  // An output that lacks samples does not keep the others from an answer.
  absl::Status lacking;
  for (const OutputSetup& setup : setups) {
    if (setup.problem->num_elements_present() == 0) continue;
    if (setup.samples.ok()) return setups;
    if (lacking.ok()) lacking = setup.samples;
  }
  MLE_RETURN_IF_ERROR(lacking);
  return setups;
}

int LongestLag(const std::vector<OutputSetup>& setups,
               const std::vector<Record>& records, double time_scales,
               double share) {
  double longest = 0.0;
  for (const OutputSetup& setup : setups) {
    for (const ElementValues& element : setup.start.values) {
      longest =
          std::max(longest, element.delay + time_scales * element.time_scale);
    }
  }
  double lags = longest / records[0].sample_time;
  for (const Record& record : records) {
    lags = std::min(lags, share * MeasuredSamples(record));
  }
  return std::max(static_cast<int>(std::ceil(lags)) - 1, 1);
}

}  // namespace mle
