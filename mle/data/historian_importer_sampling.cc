// How often records are sampled: by their rows, and by what is declared of
// channels.

#include <algorithm>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/historian_importer.h"
#include "mle/data/sampling.h"

namespace mle {
namespace {

constexpr double kDefaultGapSteps = 5.0;
// A Δt finer than this share of the files' step invents its samples.
constexpr double kMaxRefinement = 50.0;
// Rows have a usual spacing if this share of them are multiples of it apart.
constexpr double kMostlyEven = 0.9;
// Means are over what lies between rows if they are over no less than a step
// divided by this; the middle of them is a sample if it is whole to within a
// share.
constexpr double kMeanOfStep = 1.3;
constexpr double kWhole = 0.01;

}  // namespace

absl::Status HistorianImporter::ChooseSampleTime(
    const std::vector<double>& steps) {
  HistorianReport& report = import_.report;
  if (steps.empty()) {
    return InvalidArgument(
        probes_[0].source.name, ": ",
        CsvLineName(2, probes_[0].source.is_table),
        ", column 1: no row is later than the one before it; a record needs at "
        "least 2 rows at different times");
  }
  report.step = UsualStep(steps);
  report.sample_time = options_.sample_time;
  if (!(options_.sample_time > 0.0)) {
    report.sample_time = report.step;
    // The middle of what was averaged is a sample then.
    for (const OutputChannel& output : channels_.outputs()) {
      const Sampling sampling = SamplingOf(output, options_.columns.tags);
      const double late = sampling.OutputLate() / report.step;
      if (IsMeanOfStep(sampling) &&
          std::abs(late - std::round(late)) > kWhole) {
        report.sample_time = 0.5 * report.step;
      }
    }
  }
  MLE_RETURN_IF_ERROR(ChooseStepOfExceptions(steps));
  if (!(report.step <= kMaxRefinement * report.sample_time)) {
    return InvalidArgument(
        probes_[0].source.name, ": sample_time is ", report.sample_time,
        ", but rows are ", report.step, " apart; it must be at least ",
        report.step / kMaxRefinement, ", better not below ", report.step);
  }
  max_gap_ = options_.max_gap >= 0.0
                 ? options_.max_gap
                 : kDefaultGapSteps * std::max(report.step, report.sample_time);
  return absl::OkStatus();
}

bool HistorianImporter::IsMeanOfStep(const Sampling& sampling) const {
  return kMeanOfStep * sampling.average > import_.report.step;
}

bool HistorianImporter::IsPoint(int output) const {
  const Sampling sampling =
      SamplingOf(channels_.outputs()[output], options_.columns.tags);
  return sampling.period > 0.0 ||
         (IsMeanOfStep(sampling) &&
          import_.report.sample_time < import_.report.step);
}

void HistorianImporter::Declare(ResamplerOptions& resampler) const {
  const int p = channels_.num_outputs();
  resampler.late.assign(num_values(), 0.0);
  resampler.is_point.assign(num_values(), false);
  for (int i = 0; i < p; ++i) {
    const Sampling sampling =
        SamplingOf(channels_.outputs()[i], options_.columns.tags);
    resampler.late[i] = sampling.OutputLate();
    resampler.is_point[i] = IsPoint(i);
  }
  for (int j = 0; j < channels_.num_inputs(); ++j) {
    resampler.late[2 * p + j] =
        SamplingOf(channels_.inputs()[j], options_.columns.tags).InputLate();
  }
}

// Rows that come when something changes have no usual spacing: nothing has
// changed between them, so that any step will do, but it must be said.
absl::Status HistorianImporter::ChooseStepOfExceptions(
    const std::vector<double>& steps) {
  HistorianReport& report = import_.report;
  const bool is_unchanged = std::any_of(
      probes_.begin(), probes_.end(),
      [](const HistorianProbe& probe) { return probe.is_unchanged; });
  if (!is_unchanged) return absl::OkStatus();
  const auto even = std::count_if(steps.begin(), steps.end(), [&](double step) {
    const double multiple = std::round(step / report.step);
    return multiple >= 1.0 &&
           std::abs(step - multiple * report.step) <= 0.01 * report.step;
  });
  if (static_cast<double>(even) >=
      kMostlyEven * static_cast<double>(steps.size())) {
    return absl::OkStatus();
  }
  if (!(options_.sample_time > 0.0)) {
    return OptionError(
        "sample_time",
        absl::StrCat(probes_[0].source.name,
                     ": rows come when something changes, from ",
                     *std::min_element(steps.begin(), steps.end()), " to ",
                     *std::max_element(steps.begin(), steps.end()),
                     " apart; declare the sample time of the records, such as "
                     "sample_time = ",
                     report.step));
  }
  report.step = options_.sample_time;
  return absl::OkStatus();
}

// What is declared of channels is said with what it does.
void HistorianImporter::NoteDeclared() {
  const std::string& unit = channels_.time_unit();
  const auto note = [&](const std::string& name, const Sampling& sampling,
                        double late) {
    if (sampling == Sampling()) return;
    std::string what;
    if (sampling.period > 0.0) {
      absl::StrAppend(&what, " measured every ", sampling.period, " ", unit,
                      sampling.held ? ", and held until the next," : ",");
    }
    if (sampling.average > 0.0) {
      absl::StrAppend(&what, " means over ", sampling.average, " ", unit,
                      ", stamped at the ",
                      sampling.stamped_at_end ? "end," : "start,");
    }
    import_.report.notes.push_back(
        {absl::StrCat(name, ":", what, " as declared",
                      late == 0.0
                          ? ""
                          : absl::StrCat(", taken ", std::abs(late), " ", unit,
                                         late > 0.0 ? " earlier" : " later",
                                         " than its stamps"),
                      "."),
         ""});
  };
  for (const OutputChannel& output : channels_.outputs()) {
    const Sampling sampling = SamplingOf(output, options_.columns.tags);
    note(output.name, sampling, sampling.OutputLate());
  }
  for (const InputChannel& input : channels_.inputs()) {
    const Sampling sampling = SamplingOf(input, options_.columns.tags);
    note(input.name, sampling, sampling.InputLate());
  }
}

}  // namespace mle
