// The part of a controller's page that says how it goes on over months.

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/report/figure.h"
#include "apps/report/html.h"
#include "apps/watch/outlook.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"

namespace mle::watch {
namespace {

// A page of ten years stays small.
constexpr int kMostHealthPoints = 400;
constexpr report::Role kOutputRoles[] = {
    report::Role::kCorrected, report::Role::kAlternative, report::Role::kFitted,
    report::Role::kTrue};

report::Figure HealthFigure(const Report& report) {
  report::Figure figure{.height_cm = 7.0};
  report::Panel& panel = figure.AddPanel("");
  panel.x = DayAxis();
  panel.y = {.label = "health", .range = report::Range{0.0, 1.0}};
  for (std::size_t i = 0; i < report.trends.size(); ++i) {
    std::vector<double> days;
    std::vector<double> health;
    for (const HealthPoint& point : report.trends[i]) {
      days.push_back(point.day + 1);  // at its end
      health.push_back(point.health);
    }
    report::Series series = report::MakeSeries(
        kOutputRoles[i % std::size(kOutputRoles)],
        report.model.outputs()[i].name, std::move(days), std::move(health));
    series.max_points = kMostHealthPoints;
    panel.series.push_back(std::move(series));
  }
  panel.lines.push_back(
      report::HorizontalLine(report::Role::kReference, "alarm", 0.5));
  return figure;
}

report::Figure ChangeFigure(const Report& report, const OutputTrend& trend) {
  const AgeingCourse& course = trend.course;
  const bool time = course.parameter == kDeadTime;
  report::Figure figure{.height_cm = 6.0};
  report::Panel& panel = figure.AddPanel("");
  panel.x = DayAxis();
  panel.y = {.label =
                 absl::StrCat("change of the ", ParameterName(course.parameter),
                              ", ", time ? report.model.time_unit() : "%")};
  report::Series series = report::MakeSeries(
      report::Role::kCorrected, "estimate, with its interval of 95 %", {}, {});
  const double unit = time ? 1.0 : 100.0;
  for (const CoursePoint& point : course.points) {
    series.x.push_back(report.watch->first + point.number + 1.0);
    series.y.push_back(unit * point.change.mean);
    series.lower.push_back(unit * point.change.low);
    series.upper.push_back(unit * point.change.high);
  }
  panel.series.push_back(std::move(series));
  panel.lines.push_back(
      report::HorizontalLine(report::Role::kReference, "the model", 0.0));
  return figure;
}

}  // namespace

report::Axis DayAxis() {
  return {.label = "date",
          .dates = report::DateScale{.seconds_per_unit = kSecondsOfDay}};
}

void AddTrend(const Report& report, report::HtmlPage& page) {
  const bool any = std::any_of(
      report.trends.begin(), report.trends.end(),
      [](const std::vector<HealthPoint>& points) { return points.size() > 1; });
  if (!any) return;
  page.AddHeading("Trend");
  page.AddFigure(HealthFigure(report), "Health of the outputs, day by day.",
                 "Curves of health between 0 and 1 over dates, with a line at "
                 "one half, where alarms are raised.");
  std::vector<std::pair<std::string, std::string>> terms;
  for (std::size_t i = 0; i < report.outlook.trends.size(); ++i) {
    terms.emplace_back(
        report.model.outputs()[i].name,
        TrendText(report.model, static_cast<int>(i), report.outlook.trends[i]));
  }
  if (!terms.empty()) page.AddTerms(terms);
  for (std::size_t i = 0; i < report.outlook.trends.size(); ++i) {
    const OutputTrend& trend = report.outlook.trends[i];
    if (!trend.course.is_known() || trend.course.points.size() < 2) continue;
    const std::string what =
        absl::StrCat("the ", ParameterName(trend.course.parameter), " of ",
                     PairName(report.model, static_cast<int>(i), trend.input));
    page.AddFigure(
        ChangeFigure(report, trend),
        absl::StrCat("By how much ", what, " has changed."),
        absl::StrCat("A curve of the change of ", what,
                     " over dates, in a band that holds it with a probability "
                     "of 95 %."));
  }
}

}  // namespace mle::watch
