#include <algorithm>

#include "absl/strings/str_cat.h"
#include "apps/reproduce/report.h"

namespace mle::reproduce {
namespace {

using report::Figure;
using report::HorizontalLine;
using report::MakeSeries;
using report::NamedFigure;
using report::Panel;
using report::Role;

constexpr double kColumnWidthCm = 8.5;
constexpr int kMaxPoints = 2000;

std::vector<double> ToVector(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

// E over λ of the first run.
void FillDistancePanel(const CaseResult& result, const Eigen::VectorXd& lambdas,
                       Panel& panel) {
  const RunResult& run = result.runs.front();
  panel.x = {.label = "penalty λ", .log = true};
  panel.y = {.label = "squared distance E", .log = true};
  panel.lines.push_back(
      HorizontalLine(Role::kInitial, "before correction", result.E_initial));
  panel.series.push_back(MakeSeries(Role::kCorrected, "corrected",
                                    ToVector(lambdas),
                                    ToVector(run.squared_distance)));
  panel.series.back().max_points = kMaxPoints;
  panel.markers.push_back(MakeMarker(Role::kBest, "best λ in hindsight",
                                     run.lambda_oracle, run.E_oracle));
  panel.markers.push_back(MakeMarker(Role::kChosen,
                                     "λ* chosen from the records",
                                     run.lambda_star, run.E_star));
}

NamedFigure DistanceFigure(const std::vector<CaseResult>& cases,
                           const Eigen::VectorXd& lambdas) {
  NamedFigure named{
      .name = "distance_over_lambda",
      .caption =
          "Squared distance E of the step responses over the penalty λ, first "
          "seed. The line is the model before correction."};
  Figure& figure = named.figure;
  figure.columns = std::min(static_cast<int>(cases.size()), 2);
  const int rows =
      (static_cast<int>(cases.size()) + figure.columns - 1) / figure.columns;
  figure.width_cm = figure.columns == 1 ? 12.0 : 2.0 * kColumnWidthCm;
  figure.height_cm = 1.5 + 6.5 * rows;
  for (const CaseResult& result : cases) {
    FillDistancePanel(result, lambdas,
                      figure.AddPanel(absl::StrCat("case ", result.name)));
  }
  return named;
}

struct Curves {
  Role role;
  std::string label;
  Eigen::MatrixXd values;  // samples × pm
};

std::vector<double> Times(const StepResponse& response) {
  std::vector<double> times;
  for (int k = 0; k < response.samples(); ++k) {
    times.push_back(k * response.sample_time);
  }
  return times;
}

// The step response that has changed most in each case, and E over λ beside it.
NamedFigure OverviewFigure(const std::vector<CaseResult>& cases,
                           const Eigen::VectorXd& lambdas) {
  NamedFigure named{
      .name = "overview",
      .caption =
          "Left: the step response that has changed most, of the plant, of the "
          "model before correction and corrected from closed-loop records. "
          "Right: squared distance E of all step responses over the penalty "
          "λ."};
  Figure& figure = named.figure;
  figure.columns = 2;
  figure.width_cm = 2.0 * kColumnWidthCm;
  figure.height_cm = 1.5 + 5.0 * static_cast<double>(cases.size());
  for (const CaseResult& result : cases) {
    const ProcessModel& plant = result.plant;
    Eigen::Index pair = 0;
    (result.truth.values - result.initial.values)
        .colwise()
        .squaredNorm()
        .maxCoeff(&pair);
    const int m = plant.num_inputs();
    Panel& panel = figure.AddPanel(
        absl::StrCat("case ", result.name, ": ", plant.outputs()[pair / m].name,
                     " ← ", plant.inputs()[pair % m].name));
    panel.x.label = absl::StrCat("time (", plant.time_unit(), ")");
    panel.y.label = "step response";
    const auto add = [&](Role role, const char* label,
                         const StepResponse& response) {
      panel.series.push_back(MakeSeries(role, label, Times(response),
                                        ToVector(response.values.col(pair))));
    };
    add(Role::kTrue, "true plant", result.truth);
    add(Role::kInitial, "before correction", result.initial);
    add(Role::kCorrected, "corrected", result.runs.front().corrected);
    FillDistancePanel(result, lambdas,
                      figure.AddPanel(absl::StrCat("case ", result.name)));
  }
  return named;
}

// A panel for each input–output pair, outputs by rows.
Figure PairGrid(const CaseResult& result, const std::string& quantity,
                const std::vector<Curves>& curves) {
  const ProcessModel& plant = result.plant;
  const std::vector<double> time = Times(result.truth);
  Figure figure;
  figure.columns = plant.num_inputs();
  figure.width_cm = std::max(kColumnWidthCm * plant.num_inputs(), 12.0);
  figure.height_cm = 1.5 + 5.0 * plant.num_outputs();
  for (const auto& [i, j] : Pairs(plant)) {
    Panel& panel = figure.AddPanel(
        absl::StrCat(plant.outputs()[i].name, " ← ", plant.inputs()[j].name));
    if (i + 1 == plant.num_outputs()) {
      panel.x.label = absl::StrCat("time (", plant.time_unit(), ")");
    }
    if (j == 0) panel.y.label = quantity;
    for (const Curves& curve : curves) {
      const Eigen::VectorXd values =
          curve.values.col(i * plant.num_inputs() + j);
      panel.series.push_back(
          MakeSeries(curve.role, curve.label, time, ToVector(values)));
      panel.series.back().max_points = kMaxPoints;
    }
  }
  return figure;
}

NamedFigure StepFigure(const CaseResult& result) {
  const RunResult& run = result.runs.front();
  NamedFigure named{.name = absl::StrCat("step_responses_", result.name),
                    .caption = absl::StrCat(
                        "Case ", result.name,
                        ": step responses of the plant, of the model before "
                        "correction, corrected with λ*, and corrected without "
                        "penalty, first seed.")};
  named.figure = PairGrid(
      result, "step response",
      {{Role::kTrue, "true plant", result.truth.values},
       {Role::kUnregularised, "without penalty", run.unregularised.values},
       {Role::kInitial, "before correction", result.initial.values},
       {Role::kCorrected, "corrected, λ*", run.corrected.values}});
  return named;
}

NamedFigure ImpulseFigure(const CaseResult& result) {
  const RunResult& run = result.runs.front();
  NamedFigure named{.name = absl::StrCat("impulse_responses_", result.name),
                    .caption = absl::StrCat(
                        "Case ", result.name,
                        ": impulse responses of the plant, of the model before "
                        "correction and corrected with λ*, first seed.")};
  named.figure = PairGrid(
      result, "impulse response",
      {{Role::kTrue, "true plant", ImpulseResponses(result.truth)},
       {Role::kInitial, "before correction", ImpulseResponses(result.initial)},
       {Role::kCorrected, "corrected, λ*", ImpulseResponses(run.corrected)}});
  return named;
}

// Noise-free set-point changes under each of the models; nothing where a loop
// could not be run.
void FillLoopPanel(const CaseResult& result, int output, int change,
                   Panel& panel) {
  constexpr Role kRoles[] = {Role::kInitial, Role::kCorrected, Role::kTrue};
  const auto& loops = result.runs.front().closed_loop.noise_free;
  // The widest line first, beneath the others.
  for (const std::size_t model : {2, 0, 1}) {
    const LoopRun& run = loops[model];
    if (change >= static_cast<int>(run.records.size())) continue;
    const Record& record = run.records[change];
    std::vector<double> time;
    for (int k = 0; k < record.samples(); ++k) time.push_back(record.time(k));
    if (panel.series.empty()) {
      panel.series.push_back(
          MakeSeries(Role::kSetPoint, "set point", time,
                     ToVector(record.set_points.row(output))));
      panel.series.back().steps = true;
    }
    panel.series.push_back(MakeSeries(
        kRoles[model], absl::StrCat(kLoopModelNames[model], " model"), time,
        ToVector(record.outputs.row(output))));
    panel.series.back().max_points = kMaxPoints;
  }
}

NamedFigure ClosedLoopFigure(const CaseResult& result) {
  const ProcessModel& plant = result.plant;
  const int p = plant.num_outputs();
  NamedFigure named{
      .name = absl::StrCat("closed_loop_", result.name),
      .caption = absl::StrCat(
          "Case ", result.name,
          ": the aged plant under control, without noise, by the model in the "
          "controller; a column for each set point that is changed, first "
          "seed.")};
  Figure& figure = named.figure;
  figure.columns = p;
  figure.width_cm = std::clamp(kColumnWidthCm * p, 12.0, 60.0);
  figure.height_cm = std::min(1.5 + 5.0 * p, 100.0);
  for (int i = 0; i < p; ++i) {
    for (int e = 0; e < p; ++e) {
      Panel& panel = figure.AddPanel(absl::StrCat(
          plant.outputs()[i].name, "; set point of ", plant.outputs()[e].name));
      const std::string& unit = plant.outputs()[i].unit;
      panel.y.label = unit.empty() ? "deviation" : unit;
      if (i + 1 == p) {
        panel.x.label = absl::StrCat("time (", plant.time_unit(), ")");
      }
      FillLoopPanel(result, i, e, panel);
    }
  }
  return named;
}

}  // namespace

std::vector<NamedFigure> MakeFigures(const std::vector<CaseResult>& cases,
                                     const Eigen::VectorXd& lambdas) {
  std::vector<NamedFigure> figures = {OverviewFigure(cases, lambdas),
                                      DistanceFigure(cases, lambdas)};
  for (const CaseResult& result : cases) {
    figures.push_back(StepFigure(result));
    figures.push_back(ImpulseFigure(result));
    figures.push_back(ClosedLoopFigure(result));
  }
  return figures;
}

}  // namespace mle::reproduce
