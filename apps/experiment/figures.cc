#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/experiment/report.h"

namespace mle::experiment {
namespace {

using report::Figure;
using report::LineStyle;
using report::MakeSeries;
using report::NamedFigure;
using report::Panel;
using report::Role;
using report::Series;

// Colours of the methods, in their order; more have no curve.
constexpr std::array<Role, 6> kMethodRoles = {
    Role::kCorrected, Role::kAlternative, Role::kFitted,
    Role::kChosen,    Role::kMeasured,    Role::kTrue};
constexpr std::array<LineStyle, 6> kMethodLines = {
    LineStyle::kSolid, LineStyle::kDashed,     LineStyle::kDashDotted,
    LineStyle::kSolid, LineStyle::kDashDotted, LineStyle::kDashed};

// The cells of one panel, whose runs differ in the method and the seed alone.
struct Group {
  std::string title;
  std::vector<const Cell*> cells;
};

void SizeFigure(Figure& figure) {
  const auto panels = static_cast<int>(figure.panels.size());
  if (panels == 0) return;
  figure.columns = std::min(panels, 2);
  const int rows = (panels + figure.columns - 1) / figure.columns;
  figure.width_cm = figure.columns == 1 ? 13.0 : 17.0;
  figure.height_cm = 1.8 + 5.8 * rows;
}

bool ShowsMethod(const Cell& cell) {
  return cell.at.method < static_cast<int>(kMethodRoles.size());
}

Series MethodSeries(const Campaign& campaign, const Cell& cell,
                    std::vector<double> x, std::vector<double> y) {
  const int method = cell.at.method;
  Series series = MakeSeries(kMethodRoles[method],
                             MethodLabel(campaign, campaign.methods[method]),
                             std::move(x), std::move(y));
  series.style = {.colour = kMethodRoles[method],
                  .line = kMethodLines[method],
                  .width_pt = 1.4};
  return series;
}

std::vector<Group> GroupByScenario(const Campaign& campaign,
                                   const StudySummary& summary) {
  std::vector<Group> groups;
  std::int64_t scenario = -1;
  const auto methods = static_cast<std::int64_t>(campaign.methods.size());
  for (const Cell& cell : summary.cells) {
    if (cell.number / methods != scenario) {
      scenario = cell.number / methods;
      if (static_cast<int>(groups.size()) == kMaxPanels) break;
      groups.push_back({ScenarioLabel(campaign, cell.at.scenario), {}});
    }
    groups.back().cells.push_back(&cell);
  }
  return groups;
}

// The share of the values that are at most x, as a staircase.
void AddDistribution(const Campaign& campaign, const Cell& cell,
                     std::vector<double> values, Panel& panel) {
  if (values.size() < 2) return;
  std::sort(values.begin(), values.end());
  std::vector<double> share;
  for (std::size_t i = 0; i < values.size(); ++i) {
    share.push_back(static_cast<double>(i + 1) /
                    static_cast<double>(values.size()));
  }
  Series series =
      MethodSeries(campaign, cell, std::move(values), std::move(share));
  series.steps = true;
  series.max_points = 600;
  panel.series.push_back(std::move(series));
}

const std::vector<double>* Shown(const Cell& cell, Metric metric) {
  const auto found = cell.shown.find(metric);
  return found == cell.shown.end() || found->second.empty() ? nullptr
                                                            : &found->second;
}

NamedFigure DistributionFigure(const Campaign& campaign,
                               const std::vector<Group>& groups) {
  NamedFigure named{
      .name = "distribution",
      .caption =
          "Squared distance E of the estimated model from the plant: share of "
          "the seeds whose E is at most that on the axis. The vertical line is "
          "the initial model (median)."};
  for (const Group& group : groups) {
    Panel panel;
    panel.title = group.title;
    panel.x = {.label = "E", .log = true};
    panel.y = {.label = "share of the seeds", .range = report::Range{0.0, 1.0}};
    bool best_drawn = false;
    for (const Cell* cell : group.cells) {
      if (!ShowsMethod(*cell)) continue;
      const std::vector<double>* best = Shown(*cell, Metric::kBestE);
      if (best != nullptr && !best_drawn) {
        best_drawn = true;
        AddDistribution(campaign, *cell, *best, panel);
        if (!panel.series.empty()) {
          panel.series.back().label = "best λ in hindsight";
          panel.series.back().style = {.colour = Role::kBest,
                                       .line = LineStyle::kDotted,
                                       .width_pt = 1.4};
        }
      }
      const std::vector<double>* values = Shown(*cell, Metric::kE);
      if (values != nullptr) AddDistribution(campaign, *cell, *values, panel);
    }
    if (panel.series.empty()) continue;
    const double initial = (*group.cells.front())[Metric::kInitialE].median();
    if (initial > 0.0) {
      panel.lines.push_back(
          report::VerticalLine(Role::kInitial, "model left as it is", initial));
    }
    named.figure.panels.push_back(std::move(panel));
  }
  SizeFigure(named.figure);
  return named;
}

struct SweptAxis {
  Axis axis = Axis::kNone;
  std::string label;
  bool log = false;
  std::function<double(const Scenario&)> value;
};

// The axis of numbers with the most values, at least three.
SweptAxis ChooseAxis(const Campaign& campaign) {
  std::set<double> sizes;
  for (const Mismatch& mismatch : campaign.mismatches) {
    if (!mismatch.changes.empty()) sizes.insert(mismatch.size);
  }
  const std::pair<std::size_t, SweptAxis> axes[] = {
      {campaign.noise_variances.size(),
       {Axis::kNoise, "noise variance σ²", true,
        [&campaign](const Scenario& scenario) {
          return campaign.noise_variances[scenario.noise];
        }}},
      {campaign.drift_variances.size(),
       {Axis::kDrift, "drift variance q a sample", true,
        [&campaign](const Scenario& scenario) {
          return campaign.drift_variances[scenario.drift];
        }}},
      {sizes.size(),
       {Axis::kSize, "size of the mismatch", false,
        [&campaign](const Scenario& scenario) {
          return campaign.mismatches[scenario.mismatch].size;
        }}}};
  std::size_t most = 2;
  SweptAxis chosen;
  for (const auto& [values, axis] : axes) {
    if (values <= most) continue;
    most = values;
    chosen = axis;
  }
  return chosen;
}

NamedFigure SweepFigure(const Campaign& campaign, const StudySummary& summary) {
  NamedFigure named;
  named.name = "sweep";
  const SweptAxis swept = ChooseAxis(campaign);
  if (swept.axis == Axis::kNone) return named;
  named.caption = absl::StrCat("Squared distance E over the ", swept.label,
                               ": median over the seeds, and the band from the "
                               "5 % to the 95 % quantile.");
  // Panel → method → points, in the order of the cells.
  std::vector<std::string> titles;
  std::map<std::string, std::map<int, std::vector<const Cell*>>> panels;
  for (const Cell& cell : summary.cells) {
    const std::string title =
        ScenarioLabel(campaign, cell.at.scenario, swept.axis);
    if (panels.count(title) == 0) titles.push_back(title);
    panels[title][cell.at.method].push_back(&cell);
  }
  for (const std::string& title : titles) {
    if (static_cast<int>(named.figure.panels.size()) == kMaxPanels) break;
    Panel panel;
    panel.title = title;
    panel.x = {.label = swept.label, .log = swept.log};
    panel.y = {.label = "E", .log = true};
    std::vector<double> axis;
    std::vector<double> initial;
    for (auto& [method, cells] : panels[title]) {
      std::stable_sort(
          cells.begin(), cells.end(), [&](const Cell* a, const Cell* b) {
            return swept.value(a->at.scenario) < swept.value(b->at.scenario);
          });
      std::vector<double> x;
      std::vector<double> y;
      std::vector<double> lower;
      std::vector<double> upper;
      for (const Cell* cell : cells) {
        const Distribution& E = (*cell)[Metric::kE];
        x.push_back(swept.value(cell->at.scenario));
        y.push_back(E.median());
        lower.push_back(E.quantiles.front());
        upper.push_back(E.quantiles.back());
        if (&cells == &panels[title].begin()->second) {
          axis.push_back(x.back());
          initial.push_back((*cell)[Metric::kInitialE].median());
        }
      }
      if (cells.size() < 2 || !ShowsMethod(*cells.front())) continue;
      Series series = MethodSeries(campaign, *cells.front(), x, y);
      series.lower = std::move(lower);
      series.upper = std::move(upper);
      panel.series.push_back(std::move(series));
    }
    if (panel.series.empty()) continue;
    panel.series.push_back(MakeSeries(Role::kInitial, "model left as it is",
                                      std::move(axis), std::move(initial)));
    named.figure.panels.push_back(std::move(panel));
  }
  SizeFigure(named.figure);
  return named;
}

}  // namespace

std::vector<NamedFigure> MakeFigures(const Campaign& campaign,
                                     const StudySummary& summary) {
  const std::vector<Group> groups = GroupByScenario(campaign, summary);
  std::vector<NamedFigure> figures;
  for (NamedFigure& figure :
       std::vector<NamedFigure>{SweepFigure(campaign, summary),
                                DistributionFigure(campaign, groups)}) {
    if (!figure.figure.panels.empty()) figures.push_back(std::move(figure));
  }
  return figures;
}

}  // namespace mle::experiment
