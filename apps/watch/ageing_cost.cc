#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/report/text.h"
#include "apps/watch/health.h"
#include "apps/watch/source.h"
#include "control/expected_operation.h"
#include "control/mpc.h"
#include "control/prediction_model.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/filter/disturbance_system.h"
#include "sim/ageing.h"

namespace mle::watch {
namespace {

constexpr double kMonthDays = 30.0;
// Days from now for which costs are computed.
constexpr int kDaysAhead[] = {0, 30, 90, 180, 365};
// Factors of a gain or time constant beyond which no trend is carried on.
constexpr double kLeastFactor = 0.4;
constexpr double kMostFactor = 2.5;
// A tuning is not the one in operation where the mean squared error between
// changes that it is expected to leave differs from that of the reference by
// more than this factor.
constexpr double kOtherTuning = 2.0;
constexpr double kRoundingOfPeriods = 1e-6;

// The change of an output that is known to have changed.
struct KnownChange {
  int output = 0;
  int input = 0;
  int parameter = 0;
  CourseEstimate change;
  CourseEstimate rate;  // of 30 days
};

enum class End { kNear, kMean, kFar };

double ChangeAt(const KnownChange& known, int days, End end) {
  const double months = days / kMonthDays;
  if (end == End::kMean) return known.change.mean + months * known.rate.mean;
  const double low = known.change.low + months * known.rate.low;
  const double high = known.change.high + months * known.rate.high;
  const bool low_is_far = std::abs(low) > std::abs(high);
  if (end == End::kFar) return low_is_far ? low : high;
  if (low <= 0.0 && high >= 0.0) return 0.0;
  return low_is_far ? high : low;
}

std::vector<control::OutputConditions> ConditionsOf(
    const WatchReference& reference, const Eigen::VectorXd& allowed_error,
    int samples_of_period, double days_of_unit) {
  std::vector<control::OutputConditions> conditions;
  for (std::size_t i = 0; i < reference.outputs.size(); ++i) {
    const NoiseEstimate& noise = reference.outputs[i].noise;
    const OutputOperation& operation = reference.operation[i];
    control::OutputConditions& met = conditions.emplace_back();
    met.noise_variance = noise.variance;
    met.walk_variance = samples_of_period * noise.increment_variance();
    met.changes = operation.changes * days_of_unit;
    met.change_size = operation.change_size;
    met.allowed_error = allowed_error(static_cast<Eigen::Index>(i));
    met.covariances = Autocovariances(noise, samples_of_period);
  }
  return conditions;
}

class Valuer {
 public:
  Valuer(const Controller& controller, const ProcessModel& model,
         const Watch& watch, double seconds_per_unit)
      : prices_(controller.valuation->prices),
        tuning_(*controller.tuning),
        model_(model),
        reference_(*watch.reference),
        hours_per_unit_(seconds_per_unit / 3600.0),
        share_of_hours_(controller.valuation->operating_hours / kHoursOfYear) {
    const auto samples = static_cast<int>(
        std::llround(tuning_.control_period / watch.sample_time));
    conditions_ = ConditionsOf(reference_, controller.valuation->allowed_error,
                               samples, seconds_per_unit / kSecondsOfDay);
  }

  // A sentence where the reference does not look like this tuning.
  absl::StatusOr<std::string> OtherTuning() const;
  // C, in 30 days; nothing where the loop does not settle.
  absl::StatusOr<double> CostAt(const std::vector<KnownChange>& known, int days,
                                End end) const;

 private:
  absl::StatusOr<control::ExpectedOperation> Expect(
      const ProcessModel& model, const ProcessModel& plant) const {
    // At rest at the operating point of transforms, where there are any.
    MLE_ASSIGN_OR_RETURN(
        const control::Mpc mpc,
        control::Mpc::Create(WithoutTransforms(model), tuning_));
    return control::ExpectOperation(mpc, plant, conditions_);
  }
  absl::StatusOr<double> MonthOf(const ProcessModel& model,
                                 const ProcessModel& plant) const {
    MLE_ASSIGN_OR_RETURN(const control::ExpectedOperation operation,
                         Expect(model, plant));
    const double units = kMonthDays * 24.0 / hours_per_unit_;
    return share_of_hours_ * units *
           CostOf(operation.sums, prices_, hours_per_unit_).total();
  }
  ProcessModel PlantAt(const std::vector<KnownChange>& known, int days,
                       End end) const;

  const control::Prices& prices_;
  const control::MpcOptions& tuning_;
  const ProcessModel& model_;
  const WatchReference& reference_;
  double hours_per_unit_;
  double share_of_hours_;
  std::vector<control::OutputConditions> conditions_;
};

absl::StatusOr<std::string> Valuer::OtherTuning() const {
  MLE_ASSIGN_OR_RETURN(const control::ExpectedOperation operation,
                       Expect(model_, model_));
  for (std::size_t i = 0; i < conditions_.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const std::optional<double>& was = reference_.operation[i].squared_error;
    if (!was.has_value() || prices_.squared_error(row) +
                                    prices_.absolute_error(row) +
                                    prices_.violation(row) ==
                                0.0) {
      continue;
    }
    const double expected =
        operation.resting_variance(row) + conditions_[i].noise_variance;
    if (expected <= kOtherTuning * *was && *was <= kOtherTuning * expected) {
      continue;
    }
    return absl::StrCat(
        "With the tuning in the list of controllers the root mean square error "
        "of ",
        model_.outputs()[i].name, " between changes would be ",
        report::FormatSignificant(std::sqrt(expected), 2),
        "; in the reference it was ",
        report::FormatSignificant(std::sqrt(*was), 2),
        ". Is it another tuning that runs, or were limits active?");
  }
  return std::string();
}

ProcessModel Valuer::PlantAt(const std::vector<KnownChange>& known, int days,
                             End end) const {
  sim::AgeingSchedule ageing;
  for (const KnownChange& changed : known) {
    const double change = ChangeAt(changed, days, end);
    const double factor = std::clamp(1.0 + change, kLeastFactor, kMostFactor);
    sim::ElementAgeing element{.output = changed.output,
                               .input = changed.input};
    if (changed.parameter == kDeadTime) {
      const double delay =
          model_.element(changed.output, changed.input).delay();
      element.delay = sim::Schedule(std::max(change, -delay));
    } else {
      (changed.parameter == 0 ? element.gain : element.time_constant) =
          sim::Schedule(factor);
    }
    ageing.elements.push_back(std::move(element));
  }
  return sim::AgedModel(model_, ageing, 0.0);
}

absl::StatusOr<double> Valuer::CostAt(const std::vector<KnownChange>& known,
                                      int days, End end) const {
  const ProcessModel plant = PlantAt(known, days, end);
  MLE_ASSIGN_OR_RETURN(const double corrected, MonthOf(plant, plant));
  MLE_ASSIGN_OR_RETURN(const double aged, MonthOf(model_, plant));
  return aged - corrected;
}

// Whether all changes are in the range that a trend is carried on to.
bool IsForeseen(const std::vector<KnownChange>& known, int days) {
  return std::all_of(
      known.begin(), known.end(), [days](const KnownChange& changed) {
        const double factor = 1.0 + ChangeAt(changed, days, End::kMean);
        return changed.parameter == kDeadTime ||
               (factor >= kLeastFactor && factor <= kMostFactor);
      });
}

// The outputs that are known to have changed, and those that may have.
struct Changes {
  std::vector<KnownChange> known;
  std::vector<int> doubtful;  // outputs
  bool any_told = false;
};

Changes ChangesOf(const std::vector<OutputTrend>& trends) {
  using Course = AgeingCourse::State;
  Changes changes;
  for (std::size_t i = 0; i < trends.size(); ++i) {
    const AgeingCourse& course = trends[i].course;
    if (course.state == Course::kTooShort) continue;
    changes.any_told = true;
    const auto output = static_cast<int>(i);
    if (course.is_known() && course.state != Course::kNoSingleChange) {
      changes.known.push_back({.output = output,
                               .input = trends[i].input,
                               .parameter = course.parameter,
                               .change = course.change,
                               .rate = course.state == Course::kSteady
                                           ? CourseEstimate()
                                           : course.rate});
    } else if (course.changed >= 0.5 ||
               course.state == Course::kNoSingleChange) {
      changes.doubtful.push_back(output);
    }
  }
  return changes;
}

// The first day on which a curve through the points reaches `level`.
std::optional<int> FirstDay(const std::vector<CostPoint>& points,
                            double CourseEstimate::*value, double level) {
  for (std::size_t k = 0; k < points.size(); ++k) {
    const double now = points[k].cost.*value;
    if (!(now >= level)) continue;
    if (k == 0 || !std::isfinite(now)) return points[k].day;
    const double before = points[k - 1].cost.*value;
    const double share = (level - before) / (now - before);
    return points[k - 1].day +
           static_cast<int>(
               std::ceil(share * (points[k].day - points[k - 1].day)));
  }
  return std::nullopt;
}

AgeingCost Unavailable(AgeingCost::State state, std::string reason) {
  return {.state = state, .reason = std::move(reason)};
}

AgeingCost CannotTell(std::string reason) {
  return Unavailable(AgeingCost::State::kCannotTell, std::move(reason));
}

// Why no cost can be estimated before anything is computed, or nothing.
std::string WhyNot(const ProcessModel& model, const Watch& watch,
                   const Controller& controller, const Changes& changes) {
  if (!changes.any_told) {
    return "Cannot tell what ageing costs yet: at least 5 days with changes of "
           "set points, over a month, are needed.";
  }
  if (changes.known.empty() && !changes.doubtful.empty()) {
    return absl::StrCat(
        "Cannot tell what ageing costs: ",
        model.outputs()[changes.doubtful.front()].name,
        " may have aged, and it is not known yet which parameter of it.");
  }
  if (changes.known.empty()) return "";
  if (watch.reference->operation.size() !=
      static_cast<std::size_t>(model.num_outputs())) {
    return "Cannot tell what ageing costs: the reference says nothing of "
           "changes of set points. The records have none, or it was made by an "
           "earlier version of the program.";
  }
  for (const KnownChange& known : changes.known) {
    if (model.inputs()[known.input].role == InputRole::kDisturbance) {
      return absl::StrCat(
          "Cannot tell what ageing costs: ", model.inputs()[known.input].name,
          " is a measured disturbance, and how it moves is not in the "
          "reference.");
    }
  }
  const double periods = controller.tuning->control_period / watch.sample_time;
  if (std::abs(periods - std::round(periods)) > kRoundingOfPeriods * periods ||
      periods < 1.0 - kRoundingOfPeriods) {
    return absl::StrFormat(
        "Cannot tell what ageing costs: the control period is %.4g %s, and "
        "records have a sample every %.4g %s; it must be a whole multiple.",
        controller.tuning->control_period, model.time_unit(), watch.sample_time,
        model.time_unit());
  }
  return "";
}

// A trend is not carried on for longer than it was looked at, in days.
std::vector<int> DaysAhead(int looked_at) {
  std::vector<int> ahead;
  for (const int days : kDaysAhead) {
    ahead.push_back(std::min(days, looked_at));
    if (days >= looked_at) break;
  }
  return ahead;
}

// `first`: the day that the watch began on.
absl::Status AddPoints(const Valuer& valuer,
                       const std::vector<KnownChange>& known, int first,
                       int today, AgeingCost& cost) {
  const bool goes_on =
      std::any_of(known.begin(), known.end(), [](const KnownChange& changed) {
        return changed.rate.low != 0.0 || changed.rate.high != 0.0;
      });
  for (const int days : DaysAhead(today - first)) {
    if (days > 0 && !IsForeseen(known, days)) break;
    if (days > 0 && !goes_on) {
      cost.points.push_back({today + days, cost.points.front().cost});
      continue;
    }
    MLE_ASSIGN_OR_RETURN(const double mean,
                         valuer.CostAt(known, days, End::kMean));
    CostPoint point{today + days, {mean, mean, mean}};
    for (const End end : {End::kNear, End::kFar}) {
      const absl::StatusOr<double> at = valuer.CostAt(known, days, end);
      // Where the loop is not stable any more.
      const double value = at.ok() ? *at : kInfinity;
      point.cost.low = std::min(point.cost.low, value);
      point.cost.high = std::max(point.cost.high, value);
    }
    cost.points.push_back(point);
  }
  return absl::OkStatus();
}

}  // namespace

AgeingCost CostOfAgeing(const Controller& controller, const ProcessModel& model,
                        const Watch& watch,
                        const std::vector<OutputTrend>& trends) {
  if (!controller.valuation.has_value() || !controller.tuning.has_value()) {
    return Unavailable(
        AgeingCost::State::kNotAsked,
        absl::StrCat("To say what ageing costs, and from when on an update "
                     "pays, the list of controllers has to have ",
                     controller.valuation.has_value()
                         ? "the controller's tuning (tuning)"
                     : controller.tuning.has_value()
                         ? "prices (prices)"
                         : "prices (prices) and the controller's tuning "
                           "(tuning)",
                     "."));
  }
  Controller fitted = controller;
  if (const absl::Status status = FitToModel(model, fitted); !status.ok()) {
    AgeingCost cost = CannotTell(std::string(status.message()));
    cost.wrong_list = true;
    return cost;
  }
  const Changes changes = ChangesOf(trends);
  if (std::string why = WhyNot(model, watch, fitted, changes); !why.empty()) {
    return CannotTell(std::move(why));
  }
  AgeingCost cost{
      .state = AgeingCost::State::kNothingAged,
      .not_counted = changes.doubtful,
      .days_between_updates = fitted.valuation->days_between_updates,
      .currency = fitted.valuation->currency};
  if (changes.known.empty()) return cost;
  const absl::StatusOr<double> seconds = SecondsOf(model);
  if (!seconds.ok()) {
    return CannotTell(absl::StrCat(
        "Cannot tell what ageing costs: ", seconds.status().message(), "."));
  }
  const Valuer valuer(fitted, model, watch, *seconds);
  const absl::StatusOr<std::string> other = valuer.OtherTuning();
  if (!other.ok() || !other->empty()) {
    return CannotTell(absl::StrCat(
        "Cannot tell what ageing costs. ",
        other.ok() ? *other
                   : absl::StrCat("With the tuning in the list of controllers ",
                                  other.status().message(), ".")));
  }
  if (const absl::Status status =
          AddPoints(valuer, changes.known, watch.first, watch.last_day(), cost);
      cost.points.empty()) {
    return CannotTell(absl::StrCat(
        "Cannot tell what ageing costs. On the plant as it has become, ",
        status.message(),
        "; with the tuning in the list of controllers it would not run."));
  }
  cost.state = AgeingCost::State::kTold;
  const control::Prices& prices = fitted.valuation->prices;
  cost.update = prices.engineer_hour * prices.hours_per_update;
  const double level = cost.update * kMonthDays / cost.days_between_updates;
  cost.pays = FirstDay(cost.points, &CourseEstimate::mean, level);
  cost.earliest = FirstDay(cost.points, &CourseEstimate::high, level);
  cost.latest = FirstDay(cost.points, &CourseEstimate::low, level);
  return cost;
}

}  // namespace mle::watch
