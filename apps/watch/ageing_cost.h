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

#ifndef APPS_WATCH_AGEING_COST_H_
#define APPS_WATCH_AGEING_COST_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/watch/outlook.h"
#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/model/process_model.h"
#include "mle/monitor/ageing_course.h"

namespace mle::watch {

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
  // The cost now, and later as far as it can be predicted, a year at most;
  // filled in for kTold alone.
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

}  // namespace mle::watch

#endif  // APPS_WATCH_AGEING_COST_H_
