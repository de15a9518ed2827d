#include "mle/plan/plan_row.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The stationary filter needs a random walk: one that moves by a ten-thousandth
// of the noise's deviation a sample is as good as none.
constexpr double kLeastRatio = 1e-8;
// ln of the factor by which a gain or a time constant changes at most.
constexpr double kLargestChange = 1.5;
// Nothing is known of a parameter: a standard error of ten times its size.
constexpr double kUnknown = 1e-2;

// The first samples of a window are not used while former inputs may act.
Record WithRestBefore(const PlanProblem& problem, const Record& plan) {
  const auto rest = static_cast<Index>(
      std::ceil(SettlingTime(problem.plant) / problem.sample_time));
  const Index samples = plan.outputs.cols();
  Record record;
  record.sample_time = problem.sample_time;
  record.outputs = MatrixXd::Zero(plan.outputs.rows(), rest + samples);
  record.inputs = MatrixXd::Zero(plan.inputs.rows(), rest + samples);
  record.outputs.rightCols(samples) = plan.outputs;
  record.inputs.rightCols(samples) = plan.inputs;
  return record;
}

}  // namespace

absl::StatusOr<PlanRow> PlanRow::Create(const ProcessModel& plant, int output,
                                        double sample_time) {
  PlanRow row;
  row.output_ = output;
  row.sample_time_ = sample_time;
  for (int j = 0; j < plant.num_inputs(); ++j) {
    if (plant.element(output, j).IsZero()) continue;
    absl::StatusOr<ElementResponse> response =
        ElementResponse::Create(plant.element(output, j));
    if (!response.ok()) {
      return InvalidArgument("plan: element of ", PairName(plant, output, j),
                             ": ", response.status().message());
    }
    const ElementValues& values = response->initial_values();
    const double gain = std::abs(values.gain);
    row.elements_.push_back({j,
                             *std::move(response),
                             {gain > 0.0 ? gain : 1.0, values.time_scale,
                              std::max({values.delay, values.time_scale / 5.0,
                                        3.0 * sample_time})}});
  }
  return row;
}

Index PlanRow::PlaceOfGain(int input) const {
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    if (elements_[e].input == input) return static_cast<Index>(3 * e);
  }
  return -1;
}

MatrixXd PlanRow::Sensitivities(const MatrixXd& inputs) const {
  MatrixXd sensitivities(num_parameters(), inputs.cols());
  MatrixXd columns(inputs.cols(), 3);
  Index first = 0;
  for (const Element& element : elements_) {
    const ElementValues& values = element.response.initial_values();
    const VectorXd input = inputs.row(element.input).transpose();
    element.response.Simulate(values.time_scale, sample_time_,
                              SampledDelayOf(values.delay, sample_time_), input,
                              0.0, columns);
    sensitivities.row(first) = element.units(0) * columns.col(0).transpose();
    sensitivities.row(first + 1) = values.gain * columns.col(1).transpose();
    sensitivities.row(first + 2) =
        values.gain * element.units(2) * columns.col(2).transpose();
    first += 3;
  }
  return sensitivities;
}

MatrixXd PlanRow::InformationOf(const MatrixXd& covariance) const {
  std::vector<Index> known;   // of θ
  std::vector<Index> places;  // in `covariance`
  VectorXd units(num_parameters());
  for (std::size_t e = 0; e < elements_.size(); ++e) {
    for (Index k = 0; k < 3; ++k) {
      const auto place = static_cast<Index>(3 * e) + k;
      const Index wide = 3 * elements_[e].input + k;
      units(place) = elements_[e].units(k);
      const double variance = covariance(wide, wide);
      if (!std::isfinite(variance) || !(variance > 0.0)) continue;
      known.push_back(place);
      places.push_back(wide);
    }
  }
  MatrixXd information = MatrixXd::Zero(num_parameters(), num_parameters());
  if (known.empty()) return information;
  const VectorXd scale = units(known).cwiseInverse();
  const MatrixXd part =
      scale.asDiagonal() * covariance(places, places) * scale.asDiagonal();
  const VectorXd size = part.diagonal().cwiseSqrt().cwiseInverse();
  const MatrixXd correlation = size.asDiagonal() * part * size.asDiagonal();
  information(known, known) =
      size.asDiagonal() *
      correlation.ldlt().solve(MatrixXd::Identity(part.rows(), part.rows())) *
      size.asDiagonal();
  return information;
}

void PlanRow::Change(const VectorXd& change, ProcessModel& plant) const {
  Index first = 0;
  for (const Element& element : elements_) {
    ElementValues values = element.response.initial_values();
    const auto factor = [&](Index k) {
      return std::exp(
          std::clamp(change(first + k), -kLargestChange, kLargestChange));
    };
    values.gain *= factor(0);
    values.time_scale *= factor(1);
    values.delay =
        std::max(values.delay + element.units(2) * change(first + 2), 0.0);
    plant.element(output_, element.input) =
        element.response.ToTransferFunction(values);
    first += 3;
  }
}

absl::StatusOr<std::vector<PlanRow>> RowsOf(const ProcessModel& plant,
                                            double sample_time) {
  std::vector<PlanRow> rows;
  for (int i = 0; i < plant.num_outputs(); ++i) {
    MLE_ASSIGN_OR_RETURN(PlanRow row, PlanRow::Create(plant, i, sample_time));
    rows.push_back(std::move(row));
  }
  return rows;
}

void WhitenRows(const NoiseEstimate& noise, MatrixXd& series) {
  NoiseEstimate shape = noise;
  shape.ratio = std::max(noise.ratio, kLeastRatio);
  const DisturbanceSystem system = SystemOf(shape, 1);
  const StationaryFilter filter = SolveStationaryFilter(system);
  const double deviation = std::sqrt(filter.innovation_variance);
  MatrixXd states = MatrixXd::Zero(system.order(), series.rows());
  VectorXd innovations(series.rows());
  for (Index k = 0; k < series.cols(); ++k) {
    innovations = series.col(k) - (system.C * states).transpose();
    states = (system.A * states + filter.gain * innovations.transpose()).eval();
    series.col(k) = innovations / deviation;
  }
}

absl::StatusOr<std::vector<MatrixXd>> InformationOfWindows(
    const PlanProblem& problem, const std::vector<Record>& windows,
    const std::vector<PlanRow>& rows, int threads) {
  std::vector<MatrixXd> informations;
  if (windows.empty()) {
    for (const PlanRow& row : rows) {
      informations.push_back(
          MatrixXd::Zero(row.num_parameters(), row.num_parameters()));
    }
    return informations;
  }
  MLE_ASSIGN_OR_RETURN(
      const OutputErrorFit limit,
      ComputeOutputErrorLimit(problem.plant, windows, problem.noise,
                              {.threads = threads}));
  for (const PlanRow& row : rows) {
    informations.push_back(row.InformationOf(limit.covariances[row.output()]));
  }
  return informations;
}

double ErrorBy(const MatrixXd& information, Index place) {
  const Index n = information.rows();
  const MatrixXd known = information + kUnknown * MatrixXd::Identity(n, n);
  const double variance = known.ldlt().solve(VectorXd::Unit(n, place))(place);
  constexpr double kShareLeft = 0.5;
  return variance < kShareLeft / kUnknown ? std::sqrt(variance) : kInfinity;
}

absl::StatusOr<std::vector<double>> ErrorsAfter(
    const PlanProblem& problem, const ProcessModel& plant, const Record& plan,
    const std::vector<MatrixXd>& known, int threads) {
  PlanProblem with_plant = problem;
  with_plant.plant = plant;
  MLE_ASSIGN_OR_RETURN(const std::vector<PlanRow> rows,
                       RowsOf(plant, problem.sample_time));
  MLE_ASSIGN_OR_RETURN(
      const std::vector<MatrixXd> by_plan,
      InformationOfWindows(with_plant, {WithRestBefore(problem, plan)}, rows,
                           threads));
  std::vector<double> errors;
  for (const PlanQuestion& question : problem.questions) {
    const auto i = static_cast<std::size_t>(question.output);
    MatrixXd information = by_plan[i];
    // Windows are independent of each other.
    if (!question.alone) information += known[i];
    errors.push_back(ErrorBy(information, rows[i].PlaceOfGain(question.input)));
  }
  return errors;
}

}  // namespace mle
