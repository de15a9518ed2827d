#include "apps/watch/outlook.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/report/text.h"
#include "apps/watch/update.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {
namespace {

std::string Percent(double share) {
  return report::FormatSignificant(100.0 * share, 2);
}

// "−1.9 %", or "+0.42 min" of a dead time.
std::string ChangeText(const ProcessModel& model, int parameter, double value,
                       bool with_unit = true) {
  const bool time = parameter == kDeadTime;
  return absl::StrCat(Signed(time ? value : 100.0 * value, time ? 2 : 1),
                      !with_unit ? ""
                      : time     ? absl::StrCat(" ", model.time_unit())
                                 : " %");
}

std::string EstimateText(const ProcessModel& model, int parameter,
                         const CourseEstimate& estimate) {
  return absl::StrCat(
      ChangeText(model, parameter, estimate.mean), " (",
      ChangeText(model, parameter, estimate.low, /*with_unit=*/false), " to ",
      ChangeText(model, parameter, estimate.high, /*with_unit=*/false), ")");
}

std::string DurationText(const ProcessModel& model) {
  return absl::StrCat(report::FormatSignificant(SettlingTime(model), 2), " ",
                      model.time_unit());
}

std::string QuestionText(const ProcessModel& model,
                         const ProposedChange& proposed) {
  const NextChange& next = proposed.next;
  const std::string pair = PairName(model, next.output, proposed.input);
  if (next.question == NextChange::Question::kLikely) {
    return absl::StrCat("whether it is ", pair, " that has changed (its ",
                        ParameterName(next.parameter), " by ",
                        ChangeText(model, next.parameter, next.change), ")");
  }
  if (next.question == NextChange::Question::kBaseline) {
    return absl::StrCat("of ", pair,
                        ", of which too little is known to notice a later "
                        "change of ",
                        report::FormatFixed(100.0 * next.change, 0),
                        " % of its gain by as many changes");
  }
  return absl::StrCat("of ", pair, ", of which least is known: a change of ",
                      report::FormatFixed(100.0 * next.change, 0),
                      " % of its gain a month ago would not have raised an "
                      "alarm yet");
}

void Scale(double unit, CourseEstimate& estimate) {
  estimate.mean *= unit;
  estimate.low *= unit;
  estimate.high *= unit;
}

OutputTrend MakeTrend(const ModelWatch& model, int output,
                      const std::vector<ScoredBatch>& batches, int last) {
  OutputTrend trend{.course = EstimateCourse(batches, last, model.options())};
  AgeingCourse& course = trend.course;
  const std::vector<int>& inputs = model.inputs(output);
  if (inputs.empty()) return trend;
  trend.input = inputs[static_cast<std::size_t>(course.element)];
  const double unit =
      model.units(output)(3 * course.element + course.parameter);
  Scale(unit, course.change);
  Scale(unit, course.rate);
  for (CoursePoint& point : course.points) Scale(unit, point.change);
  return trend;
}

}  // namespace

Outlook MakeOutlook(const Controller& controller, const ProcessModel& model,
                    const Watch& watch) {
  Outlook outlook;
  if (!watch.reference.has_value() || watch.days.empty() ||
      watch.outputs.size() != static_cast<std::size_t>(model.num_outputs())) {
    return outlook;
  }
  const absl::StatusOr<ModelWatch> watched =
      ModelWatch::Create(model, watch.sample_time, controller.options);
  if (!watched.ok()) return outlook;
  const int last = watch.last_day() - watch.first;
  std::vector<ScoredOutput> outputs;
  for (int i = 0; i < model.num_outputs(); ++i) {
    ScoredOutput& output = outputs.emplace_back();
    for (const auto& [number, stored] : watch.outputs[i]) {
      output.batches.push_back(stored.batch);
      output.evidence = stored.evidence;
    }
    outlook.trends.push_back(MakeTrend(*watched, i, output.batches, last));
  }
  const absl::StatusOr<NextChange> next = FindNextChange(
      *watched, *watch.reference, outputs,
      {.last = last,
       .share_of_output = ShareOfOutput(model, controller.options),
       .share_of_element = ShareOfElement(model, controller.options)});
  // A state of another model: nothing can be proposed.
  if (!next.ok()) return outlook;
  ProposedChange proposed{.next = *next};
  const std::vector<int>& inputs = watched->inputs(next->output);
  if (!inputs.empty()) {
    proposed.input = inputs[static_cast<std::size_t>(next->element)];
    proposed.next.change *=
        watched->units(next->output)(3 * next->element + next->parameter);
  }
  outlook.next = std::move(proposed);
  return outlook;
}

std::string_view NameOf(AgeingCourse::State state) {
  switch (state) {
    case AgeingCourse::State::kTrend:
      return "trend";
    case AgeingCourse::State::kSteady:
      return "steady";
    default:
      return "cannot_tell";
  }
}

std::string_view NameOf(NextChange::State state) {
  switch (state) {
    case NextChange::State::kEnough:
    case NextChange::State::kNamed:
      return "not_needed";
    case NextChange::State::kPropose:
      return "proposed";
    case NextChange::State::kNoneTells:
      return "none_tells";
  }
  return "";
}

std::string RateText(const ProcessModel& model, const OutputTrend& trend) {
  return absl::StrCat(
      ChangeText(model, trend.course.parameter, trend.course.rate.mean),
      " a month");
}

std::string ChangedText(const ProcessModel& model, int output,
                        const OutputTrend& trend) {
  const AgeingCourse& course = trend.course;
  const bool explains = course.state != AgeingCourse::State::kTooShort &&
                        course.state != AgeingCourse::State::kNoSingleChange;
  if (!explains || !course.is_known()) return "";
  return absl::StrCat("The ", ParameterName(course.parameter), " of ",
                      PairName(model, output, trend.input), " has changed by ",
                      EstimateText(model, course.parameter, course.change),
                      ".");
}

std::string TrendText(const ProcessModel& model, int output,
                      const OutputTrend& trend) {
  const AgeingCourse& course = trend.course;
  const std::string pair = PairName(model, output, trend.input);
  const std::string parameter =
      absl::StrCat("the ", ParameterName(course.parameter), " of ", pair);
  const std::string last_month =
      EstimateText(model, course.parameter, course.rate);
  const std::string so_far =
      EstimateText(model, course.parameter, course.change);
  using CourseState = AgeingCourse::State;
  switch (course.state) {
    case CourseState::kTooShort:
      return "Cannot tell a trend yet: at least 5 days with changes of set "
             "points, over a month, are needed.";
    case CourseState::kTrend:
      return absl::StrCat("In the last month ", parameter, " has changed by ",
                          last_month, ", by ", so_far, " in all.");
    case CourseState::kSteady:
      return course.is_known()
                 ? absl::StrCat("No trend: ", parameter, " has changed by ",
                                so_far, " and stands still since.")
                 : absl::StrCat(
                       "No trend: no gain of its elements changes by more "
                       "than ",
                       Percent(course.largest_gain_rate), " % a month.");
    case CourseState::kWhichElement:
      return absl::StrFormat(
          "Cannot tell of which element: something changes, most likely "
          "(%.0f %%) %s, in the last month by %s.",
          100.0 * course.probability, parameter, last_month);
    case CourseState::kWhetherAtAll:
      return course.is_known()
                 ? absl::StrCat("Cannot tell whether it goes on: ", parameter,
                                " has changed by ", so_far,
                                ", in the last month by ", last_month, ".")
                 : absl::StrCat("Cannot tell a trend: a gain could change by ",
                                Percent(course.largest_gain_rate),
                                " % a month without being seen yet.");
    case CourseState::kNoSingleChange:
      return "Cannot tell a trend: no change of a single parameter, at once or "
             "over time, explains the days together.";
  }
  return "";
}

std::string NextChangeText(const ProcessModel& model,
                           const ProposedChange& proposed) {
  const NextChange& next = proposed.next;
  switch (next.state) {
    case NextChange::State::kEnough:
      return "None is needed: a change of 10 % of any gain a month ago would "
             "have raised an alarm.";
    case NextChange::State::kNamed:
      return "None is needed: the element that has aged is named.";
    case NextChange::State::kNoneTells:
      return absl::StrCat(
          "No change of one set point within the usual range tells enough ",
          QuestionText(model, proposed), ". None moves ",
          model.inputs()[proposed.input].name,
          " enough by itself, or none did before the change, so that there is "
          "nothing to compare with. A correction (mle_correct) of records in "
          "which this input moves by itself, as in a step test, would tell.");
    case NextChange::State::kPropose: {
      const OutputChannel& moved = model.outputs()[next.set_point];
      return absl::StrCat(
          "Move the set point of ", moved.name, " by ",
          report::FormatSignificant(next.size, 2),
          moved.unit.empty() ? "" : absl::StrCat(" ", moved.unit),
          ", up or down, wait until the plant has settled (about ",
          DurationText(model), "), and move it back",
          next.changes == 1
              ? ""
              : absl::StrCat(", on ", next.changes, " different days"),
          ". That tells most ", QuestionText(model, proposed),
          next.question == NextChange::Question::kBaseline
              ? ". Expected then is evidence of ln E = "
              : ". Expected is evidence of ln E = ",
          report::FormatFixed(next.log_expected, 1), " for that element, from ",
          report::FormatFixed(next.log_evidence, 1),
          " now; its alarm is raised at ",
          report::FormatFixed(next.log_alarm, 1), ".");
    }
  }
  return "";
}

const char* ParameterName(int parameter) {
  constexpr const char* kNames[] = {"gain", "time constant", "dead time"};
  return kNames[parameter];
}

const char* ParameterKey(int parameter) {
  constexpr const char* kKeys[] = {"gain", "time_constant", "dead_time"};
  return kKeys[parameter];
}

std::string Signed(double value, int decimals) {
  return absl::StrCat(value > 0.0 ? "+" : "",
                      report::FormatFixed(value, decimals));
}

}  // namespace mle::watch
