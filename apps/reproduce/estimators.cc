#include "apps/reproduce/estimators.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"
#include "apps/reproduce/experiment.h"
#include "mle/correction/combined.h"
#include "mle/correction/smoothed_correction.h"
#include "mle/nonlinear/model_adequacy.h"
#include "mle/nonlinear/structured_correction.h"
#include "nlohmann/json.hpp"

namespace mle::reproduce {
namespace {

using report::FormatSignificant;

// One run's estimators; what several of them need is done once.
class Comparison {
 public:
  Comparison(const ProcessModel& initial, const ProcessModel& plant,
             const std::vector<Record>& windows, const Correction& correction,
             double correction_seconds, std::uint64_t seed,
             const ExperimentOptions& options)
      : initial_(initial),
        windows_(windows),
        correction_(correction),
        correction_seconds_(correction_seconds),
        seed_(seed),
        options_(options),
        truth_(plant.ComputeStepResponse(options.sample_time,
                                         options.response_samples())),
        E_initial_(Distance(initial.ComputeStepResponse(
            options.sample_time, options.response_samples()))) {}

  EstimatorResult Run(const std::string& name) {
    EstimatorResult result;
    result.name = name;
    result.E = E_initial_;
    const double start = ThreadSeconds();
    result.status = name == "arx"          ? Arx(result)
                    : name == "ceres"      ? Ceres(result)
                    : name == "structured" ? Structured(result)
                                           : Combined(result);
    result.seconds += ThreadSeconds() - start;
    return result;
  }

 private:
  double Distance(const StepResponse& response) const {
    const double distance = SquaredDistance(truth_, response);
    return std::isfinite(distance) ? distance
                                   : std::numeric_limits<double>::infinity();
  }

  double Distance(const ArxModel& model) const {
    return Distance(model.ComputeStepResponse(truth_.samples()));
  }

  // The test of the initial model, once for arx and ceres.
  absl::Status TestInitial(EstimatorResult& result) {
    const double start = ThreadSeconds();
    if (!adequacy_.has_value()) {
      adequacy_ = TestAdequacy(initial_, windows_, {}, AdequacyOptions());
      adequacy_seconds_ = ThreadSeconds() - start;
    } else {
      result.seconds += adequacy_seconds_;
    }
    if (!adequacy_->ok()) return adequacy_->status();
    result.change_proposed = !(*adequacy_)->adequate;
    result.p_value = (*adequacy_)->p_value;
    result.report = (*adequacy_)->BriefReport();
    return absl::OkStatus();
  }

  absl::Status Arx(EstimatorResult& result) {
    result.seconds = correction_seconds_;
    if (absl::Status status = TestInitial(result); !status.ok()) return status;
    if (result.change_proposed) result.E = Distance(correction_.Model());
    return absl::OkStatus();
  }

  absl::Status Ceres(EstimatorResult& result) {
    if (absl::Status status = TestInitial(result); !status.ok()) return status;
    const auto smoothed =
        CorrectSmoothed(correction_, correction_.selection().lambda_star, {});
    if (!smoothed.ok()) return smoothed.status();
    for (const SmoothedLassoSummary& fit : smoothed->fits) {
      absl::StrAppend(&result.report, "; ", fit.BriefReport());
    }
    if (result.change_proposed) result.E = Distance(smoothed->model);
    return absl::OkStatus();
  }

  absl::Status Structured(EstimatorResult& result) {
    const double start = ThreadSeconds();
    if (!structured_.has_value()) {
      structured_ = CorrectStructure(initial_, windows_, StructuredOptions());
      structured_seconds_ = ThreadSeconds() - start;
    } else {
      result.seconds += structured_seconds_;
    }
    if (!structured_->ok()) return structured_->status();
    const StructuredCorrection& structured = **structured_;
    result.change_proposed = structured.change_proposed;
    result.p_value = structured.p_value;
    result.report = structured.BriefReport();
    result.E = Distance(structured.corrected.model.ComputeStepResponse(
        options_.sample_time, truth_.samples()));
    return absl::OkStatus();
  }

  absl::Status Combined(EstimatorResult& result) {
    if (absl::Status status = Structured(result); !status.ok()) return status;
    CombinedOptions combined_options;
    combined_options.correction = options_.correction;
    const auto combined = CompleteStructured(
        initial_, **structured_, windows_,
        [this](const ProcessModel& model) {
          return ConvertInitialModel(model, seed_, options_);
        },
        combined_options);
    if (!combined.ok()) return combined.status();
    result.change_proposed = combined->change_proposed();
    result.report = combined->BriefReport();
    result.E = Distance(
        combined->ComputeStepResponse(options_.sample_time, truth_.samples()));
    return absl::OkStatus();
  }

  const ProcessModel& initial_;
  const std::vector<Record>& windows_;
  const Correction& correction_;
  const double correction_seconds_;
  const std::uint64_t seed_;
  const ExperimentOptions& options_;
  const StepResponse truth_;
  const double E_initial_;
  std::optional<absl::StatusOr<ModelAdequacy>> adequacy_;
  double adequacy_seconds_ = 0.0;
  std::optional<absl::StatusOr<StructuredCorrection>> structured_;
  double structured_seconds_ = 0.0;
};

// The Cramér–Rao limit of E at the plant under the noise that was simulated; 0
// where there is no noise, or the plant cannot be fitted.
double Limit(const ProcessModel& plant, const std::vector<Record>& windows,
             const ExperimentOptions& options) {
  if (!(options.noise_variance > 0.0)) return 0.0;
  const Eigen::VectorXd& drift =
      options.conditions.output_disturbance.drift_variance;
  std::vector<NoiseEstimate> noise(plant.num_outputs());
  for (int i = 0; i < plant.num_outputs(); ++i) {
    noise[i].variance = options.noise_variance;
    noise[i].ratio = drift.size() > 0 ? drift(i) / options.noise_variance : 0.0;
    noise[i].offset = noise[i].ratio > 0.0;
  }
  const auto limit =
      ComputeStructuredLimit(plant, windows, noise, StructuredOptions());
  if (!limit.ok()) return 0.0;
  const double E = limit->ExpectedSquaredDistance(options.sample_time,
                                                  options.response_samples());
  return std::isfinite(E) ? E : 0.0;
}

struct Row {
  std::vector<double> E;
  int proposed = 0;
  double seconds = 0.0;
  std::string failure;
};

}  // namespace

const std::vector<std::string>& EstimatorNames() {
  static const std::vector<std::string>* const kNames =
      new std::vector<std::string>{"arx", "ceres", "structured", "combined"};
  return *kNames;
}

double ThreadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) +
         1e-9 * static_cast<double>(time.tv_nsec);
}

EstimatorComparison CompareEstimators(const ProcessModel& initial,
                                      const ProcessModel& plant,
                                      const std::vector<Record>& windows,
                                      const Correction& correction,
                                      double correction_seconds,
                                      std::uint64_t seed, bool in_full,
                                      const ExperimentOptions& options) {
  EstimatorComparison comparison;
  Comparison run(initial, plant, windows, correction, correction_seconds, seed,
                 options);
  for (const std::string& name : options.estimators) {
    if (name == "ceres" && !in_full) continue;
    comparison.estimators.push_back(run.Run(name));
  }
  if (!options.estimators.empty()) {
    comparison.E_limit = Limit(plant, windows, options);
  }
  return comparison;
}

report::Table EstimatorTable(
    const std::string& case_name,
    const std::vector<const EstimatorComparison*>& comparisons) {
  report::Table table;
  table.caption = absl::StrCat("Case ", case_name, ": estimators side by side");
  table.columns = {{"estimator", report::Align::kLeft},
                   {"runs"},
                   {"E mean"},
                   {"E worst"},
                   {"change proposed"},
                   {"s a run"}};
  for (const std::string& name : EstimatorNames()) {
    Row row;
    for (const EstimatorComparison* comparison : comparisons) {
      for (const EstimatorResult& result : comparison->estimators) {
        if (result.name != name) continue;
        if (!result.status.ok()) {
          row.failure = std::string(result.status.message());
          continue;
        }
        row.E.push_back(result.E);
        row.proposed += result.change_proposed ? 1 : 0;
        row.seconds += result.seconds;
      }
    }
    if (row.E.empty()) {
      if (!row.failure.empty()) table.AddRow({name, "0", row.failure});
      continue;
    }
    const double count = static_cast<double>(row.E.size());
    double mean = 0.0;
    for (const double E : row.E) mean += E / count;
    table.AddRow(
        {name, absl::StrCat(row.E.size()), FormatSignificant(mean),
         FormatSignificant(*std::max_element(row.E.begin(), row.E.end())),
         absl::StrCat(row.proposed, " of ", row.E.size()),
         FormatSignificant(row.seconds / count, 2)});
  }
  double limit = 0.0;
  int limits = 0;
  for (const EstimatorComparison* comparison : comparisons) {
    if (!(comparison->E_limit > 0.0)) continue;
    limit += comparison->E_limit;
    ++limits;
  }
  if (limits > 0) {
    table.AddRow({"Cramér–Rao limit, all elements free", absl::StrCat(limits),
                  FormatSignificant(limit / limits)});
  }
  return table;
}

nlohmann::ordered_json EstimatorsJson(const EstimatorComparison& comparison) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const EstimatorResult& result : comparison.estimators) {
    if (!result.status.ok()) {
      json[result.name] = {{"failure", std::string(result.status.message())}};
      continue;
    }
    json[result.name] = {{"E", result.E},
                         {"change_proposed", result.change_proposed},
                         {"p_value", result.p_value}};
  }
  return json;
}

}  // namespace mle::reproduce
