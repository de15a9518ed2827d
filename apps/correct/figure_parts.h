// Parts that the figures of a correction have in common.

#ifndef APPS_CORRECT_FIGURE_PARTS_H_
#define APPS_CORRECT_FIGURE_PARTS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "Eigen/Core"
#include "apps/correct/result.h"
#include "apps/report/drawing.h"

namespace mle::correct {

// Longer curves are thinned, their extremes kept.
inline constexpr int kMaxPoints = 1500;

std::vector<double> ToVector(const Eigen::VectorXd& values);

// "time (min)".
std::string TimeLabel(const Result& result, const std::string& what);

// A figure without panels yet, its caption for all readers.
report::NamedFigure NewFigure(const std::string& name,
                              const std::string& caption, int rows, int columns,
                              double row_height_cm);

// fill(i, j, panel) for each output i (row) and input j (column), titled and
// labelled along x, which all panels share.
void AddPairPanels(
    const Result& result, const std::string& x_label, report::Figure& figure,
    const std::function<void(int i, int j, report::Panel& panel)>& fill);

// Thinned to kMaxPoints.
report::Series& AddCurve(report::Role role, const std::string& label,
                         std::vector<double> x, std::vector<double> y,
                         report::Panel& panel);

// first, first + step, …
std::vector<double> Times(double first, double step, Eigen::Index count);

// Responses of pairs, and of the loop (response_figures.cc).
std::optional<report::NamedFigure> StepResponseFigure(const Result& result);
std::optional<report::NamedFigure> ChangedResponseFigure(const Result& result);
std::optional<report::NamedFigure> ControlFigure(const Result& result);

// How gains follow positions and levels, where the records showed it.
std::optional<report::NamedFigure> CurveFigure(const Result& result);

// The plan of the next move (next_move_text.cc).
std::optional<report::NamedFigure> NextMoveFigure(const Result& result);

// Records, and predictions in their windows (record_figures.cc).
report::NamedFigure RecordFigure(const Result& result);
report::NamedFigure PredictionFigure(const Result& result);

}  // namespace mle::correct

#endif  // APPS_CORRECT_FIGURE_PARTS_H_
