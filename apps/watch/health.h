// The report of a watch on its controller: the health of the model, of its
// outputs and of its elements, each from 0 to 1 (HealthOf() in
// mle/monitor/change_evidence.h): the probability that nothing has changed. An
// alarm is raised where it falls to one half.

#ifndef APPS_WATCH_HEALTH_H_
#define APPS_WATCH_HEALTH_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/watch/outlook.h"
#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/model/process_model.h"
#include "mle/monitor/ageing_course.h"
#include "mle/trial/trial_verdict.h"

namespace mle::watch {

// The cost of the ageing of a controller's model, how it grows, and from when
// on an update pays.
//
// For each output that is known to have aged, the plant is the model with its
// most probable change δ (ageing_course.h). The cost of ageing is that of
// operation (control/expected_operation.h) under the controller with the model
// as it is, less that with the corrected one, both with the tuning given:
//
//   C(δ) = c(model, plant(δ)) − c(plant(δ), plant(δ)),
//
// under the noise, the disturbances and the changes of set points of the
// reference. Its interval is that of C at the estimates and at the near and far
// ends (from zero) of the intervals of 95 % of all δ. For later days t each δ
// goes on by its trend, δ + ρ t/30 days, with the ends of both intervals.
//
// An update costs U = engineer's hour × hours per update, and serves until the
// next one, H days later. It pays from the day on which H C ≥ U: what ageing
// costs by then, if it went no further.

struct CostPoint {
  int day = 0;          // since 1970
  CourseEstimate cost;  // money in 30 days; infinite where the loop is unstable
};

struct AgeingCost {
  enum class State {
    kNotAsked,     // prices or tuning are not given: see `reason`
    kCannotTell,   // see `reason`
    kNothingAged,  // of no output a change is known or likely
    kTold,
  };
  State state = State::kNotAsked;
  std::string reason = {};  // whole sentences
  // Whether kCannotTell is due to an error in the list of controllers.
  bool wrong_list = false;
  // The cost now, and later as far as it can be predicted, no further than the
  // watch has looked back and a year at most; filled in for kTold alone.
  std::vector<CostPoint> points = {};
  std::vector<int> not_counted = {};  // outputs that may have changed, too
  double update = 0.0;                // U, money
  int days_between_updates = 0;       // H
  std::string currency = {};
  // From when on an update pays, by the estimate, at the earliest and at the
  // latest; nothing where it does not in the time of `points`.
  std::optional<int> pays = {};
  std::optional<int> earliest = {};
  std::optional<int> latest = {};

  bool pays_now() const {
    return latest.has_value() && *latest == points.front().day;
  }
};

// `trends` (p): those of the watch. Tens of milliseconds and more where
// something has aged.
AgeingCost CostOfAgeing(const Controller& controller, const ProcessModel& model,
                        const Watch& watch,
                        const std::vector<OutputTrend>& trends);

// "not_asked", "cannot_tell", "nothing_aged", "told".
std::string_view NameOf(AgeingCost::State state);
// A month, "1,240", "0", "cannot tell"; "–" where it was not asked for.
std::string ShortCost(const AgeingCost& cost);
// "now", "2026-12-04", "not foreseen", "cannot tell", "–".
std::string ShortDate(const AgeingCost& cost);
// "910 to 1,600".
std::string CostInterval(const CourseEstimate& cost);
// Whole sentences: what it costs; when an update pays, empty where that cannot
// be told.
std::string CostText(const ProcessModel& model, const AgeingCost& cost);
std::string UpdateText(const AgeingCost& cost);

// The last trial of a correction, as pages show it.
struct TrialReport {
  struct Point {
    double day = 0.0;        // since 1970
    double log10_for = 0.0;  // E for the proposed model
    double log10_against = 0.0;
  };
  int day = 0;       // of the correction
  int last_day = 0;  // that was looked at
  double level = 0.0;
  TrialVerdict verdict;  // since the correction, or since it was adopted
  std::vector<Point> history = {};
  double loss_ratio = 1.0;
  std::string ended = {};
  std::string fault = {};
  std::optional<Acknowledgement> adopted = {};
  int adopted_day = 0;
  std::vector<std::string> before = {};  // a sentence on each earlier trial

  // There is nothing more to do: `verdict` is the last before it ended.
  bool IsOver() const { return !ended.empty(); }
};

enum class Status {
  kFailed,      // the records or the model could not be read
  kLearning,    // the reference is being gathered
  kAged,        // an alarm was raised
  kCannotTell,  // no day of the last month could be used
  kHealthy,
};

// "failed", "learning", "aged", "cannot_tell", "healthy"; the same in words.
std::string_view NameOf(Status status);
std::string_view WordsFor(Status status);

struct HealthPoint {
  int day = 0;  // since 1970
  double health = 1.0;
};

struct ElementHealth {
  int output = 0;
  int input = 0;
  double health = 1.0;
  double log_evidence = 0.0;
};

struct Report {
  std::string name;
  const Watch* watch = nullptr;
  ProcessModel model;  // no channels where it could not be read
  Status status = Status::kFailed;
  double health = 1.0;  // the least of all
  int last_day = 0;     // since 1970; 0 without days
  int used_days = 0;    // days in which anything could be learnt
  int unused_days = 0;  // days of which it cannot be told
  std::vector<ElementHealth> elements;
  std::vector<double> output_health;             // p
  std::vector<std::vector<HealthPoint>> trends;  // p, of outputs
  Outlook outlook;
  AgeingCost cost;
  std::optional<TrialReport> trial;
  std::string sentence;
};

// `watch` must outlive the report. Outlook and costs, which take some
// milliseconds and more, are those of `known`, a report of the same watch with
// the same controller and model, if there is one.
Report MakeReport(const Controller& controller, const ProcessModel& model,
                  const Watch& watch, const Report* known = nullptr);

}  // namespace mle::watch

#endif  // APPS_WATCH_HEALTH_H_
