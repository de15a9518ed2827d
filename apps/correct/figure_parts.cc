#include "apps/correct/figure_parts.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"

namespace mle::correct {
namespace {

constexpr double kPanelWidthCm = 8.5;
constexpr double kMaxWidthCm = 34.0;
constexpr double kMaxHeightCm = 100.0;

}  // namespace

std::vector<double> ToVector(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

std::string TimeLabel(const Result& result, const std::string& what) {
  return absl::StrCat(what, " (", result.initial.time_unit(), ")");
}

report::NamedFigure NewFigure(const std::string& name,
                              const std::string& caption, int rows, int columns,
                              double row_height_cm) {
  report::NamedFigure named{.name = name, .caption = caption};
  named.figure.columns = columns;
  named.figure.width_cm =
      std::clamp(kPanelWidthCm * columns, 2.0 * kPanelWidthCm, kMaxWidthCm);
  named.figure.height_cm = std::min(1.5 + row_height_cm * rows, kMaxHeightCm);
  return named;
}

void AddPairPanels(
    const Result& result, const std::string& x_label, report::Figure& figure,
    const std::function<void(int i, int j, report::Panel& panel)>& fill) {
  const ProcessModel& model = result.initial;
  for (const auto& [i, j] : Pairs(model)) {
    report::Panel& panel = figure.AddPanel(PairName(model, i, j));
    if (i + 1 == model.num_outputs()) panel.x.label = x_label;
    fill(i, j, panel);
  }
}

std::vector<double> Times(double first, double step, Eigen::Index count) {
  std::vector<double> times;
  for (Eigen::Index k = 0; k < count; ++k) {
    times.push_back(first + static_cast<double>(k) * step);
  }
  return times;
}

report::Series& AddCurve(report::Role role, const std::string& label,
                         std::vector<double> x, std::vector<double> y,
                         report::Panel& panel) {
  panel.series.push_back(
      report::MakeSeries(role, label, std::move(x), std::move(y)));
  panel.series.back().max_points = kMaxPoints;
  return panel.series.back();
}

}  // namespace mle::correct
