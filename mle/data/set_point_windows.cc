#include "mle/data/set_point_windows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Core"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/line.h"
#include "mle/data/steady_operation.h"

namespace mle {
namespace {

// The residual of a process model: y − Σ_j g_ij u_j. In closed loop control
// removes a disturbance from the outputs; in the residual it remains visible.

constexpr double kMaxProducts = 1e8;

struct Move {
  int sample = 0;
  double size = 0.0;
};

// Moves of an input from `begin` to `last`.
std::vector<Move> MovesOfInput(const Record& record, int input, int begin,
                               int last) {
  std::vector<Move> moves;
  double held = std::numeric_limits<double>::quiet_NaN();
  for (int k = begin; k <= last; ++k) {
    const double value = record.inputs(input, k);
    if (!std::isfinite(value)) continue;
    if (std::isfinite(held) && value != held) {
      moves.push_back({k - begin, value - held});
    }
    held = value;
  }
  return moves;
}

// p × (last − first + 1): samples first … last of `record`, up to a constant,
// of outputs that integrate less the line of least squares: what balances them
// is not known.
// The inputs count from `settling` samples before, as if they had been steady
// until then; a bad input keeps its last value. Responses are summed move by
// move; an element for which that would take very long is left out.
Eigen::MatrixXd ModelResidual(const Record& record, const ProcessModel& model,
                              int first, int last, int settling) {
  const int begin = std::max(0, first - settling);
  const int length = last - begin + 1;
  Eigen::MatrixXd residual = record.outputs.middleCols(begin, length);
  const int responses = std::min(settling + 2, length);
  for (int j = 0; j < model.num_inputs(); ++j) {
    const std::vector<Move> moves = MovesOfInput(record, j, begin, last);
    const double products = static_cast<double>(moves.size()) * responses;
    if (moves.empty() || products > kMaxProducts) continue;
    for (int i = 0; i < model.num_outputs(); ++i) {
      if (model.element(i, j).IsZero()) continue;
      const Eigen::VectorXd step =
          model.element(i, j).StepResponse(record.sample_time, responses);
      Eigen::VectorXd response = Eigen::VectorXd::Zero(length);
      Eigen::VectorXd settled = Eigen::VectorXd::Zero(length);
      Eigen::VectorXd sloping = Eigen::VectorXd::Zero(length);
      const double slope =
          model.element(i, j).IsIntegrating()
              ? model.element(i, j).StaticGain() * record.sample_time
              : 0.0;
      for (const Move& move : moves) {
        const int count = std::min(responses, length - move.sample);
        response.segment(move.sample, count) += move.size * step.head(count);
        if (move.sample + count < length) {
          settled(move.sample + count) += move.size * step(responses - 1);
          sloping(move.sample + count) += move.size * slope;
        }
      }
      double level = 0.0;
      double rate = 0.0;
      for (int k = 0; k < length; ++k) {
        rate += sloping(k);
        level += settled(k) + rate;
        residual(i, k) -= response(k) + level;
      }
    }
  }
  residual = residual.rightCols(last - first + 1).eval();
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (!IsIntegrating(model, i)) continue;
    residual.row(i) = WithoutLine(residual.row(i).transpose()).transpose();
  }
  return residual;
}

// A window with fewer tells nothing.
constexpr int kMinWindowSamples = 20;
// Share of the samples at which inputs that are moved by hand rest.
constexpr double kAtRest = 0.9;

// Times as numbers of samples.
struct Extent {
  double settling = 0.0;
  double before = 0.0;
  double after = 0.0;
  double join = 0.0;
};

Extent InSamples(const WindowOptions& options, double settling,
                 double sample_time) {
  Extent extent;
  extent.settling = std::ceil(settling / sample_time - 1e-9);
  extent.before = std::round(
      (options.before > 0.0 ? options.before : settling) / sample_time);
  // Windows of slow samples are longer than the plant needs, not too short.
  extent.after =
      options.after > 0.0
          ? std::round(options.after / sample_time)
          : std::max<double>(std::round(1.5 * settling / sample_time),
                             kMinWindowSamples);
  extent.join = options.join_within > 0.0
                    ? std::round(options.join_within / sample_time)
                    : std::max<double>(std::min(extent.settling, extent.after),
                                       kMinWindowSamples);
  return extent;
}

// Changes first … last of a record share a window.
struct Group {
  std::vector<SetPointChange> changes;
  int begin = 0;  // samples of the record
  int end = 0;    // the last
  bool clipped_before = false;
  bool clipped_after = false;

  int first_change() const { return changes.front().sample; }
  int last_change() const { return changes.back().sample; }
};

std::vector<Group> GroupChanges(const std::vector<SetPointChange>& changes,
                                const Extent& extent) {
  std::vector<Group> groups;
  for (const SetPointChange& change : changes) {
    if (groups.empty() ||
        change.sample - groups.back().last_change() > extent.join) {
      groups.emplace_back();
    }
    groups.back().changes.push_back(change);
  }
  return groups;
}

// Where windows begin and end. Between two changes that are too close for both
// parts the time is shared, in proportion, but the first gets what its plant
// needs to settle.
void PlaceWindows(const Extent& extent, int samples,
                  std::vector<Group>& groups) {
  for (std::size_t g = 0; g < groups.size(); ++g) {
    Group& group = groups[g];
    double begin = group.first_change() - extent.before;
    double end = group.last_change() + extent.after;
    const auto split = [&](const Group& left, const Group& right) {
      const double gap = right.first_change() - left.last_change();
      const double share = extent.after / (extent.after + extent.before);
      return left.last_change() +
             std::min(gap - 1.0,
                      std::max(extent.join, std::floor(gap * share)));
    };
    double earliest = 0.0;
    double latest = samples - 1.0;
    if (g > 0 && groups[g - 1].last_change() + extent.after >= begin) {
      earliest = split(groups[g - 1], group) + 1.0;
    }
    if (g + 1 < groups.size() &&
        groups[g + 1].first_change() - extent.before <= end) {
      latest = split(group, groups[g + 1]);
    }
    group.clipped_before = begin < earliest;
    group.clipped_after = end > latest;
    group.begin = static_cast<int>(std::max(begin, earliest));
    group.end = static_cast<int>(std::min(end, latest));
  }
}

// Samples first … last of a record, less what the model makes of the inputs.
std::vector<SteadyOperation> TestParts(const Record& record,
                                       const ProcessModel& model, int first,
                                       int last, double settling,
                                       const WindowOptions& options) {
  if (last < first) return std::vector<SteadyOperation>(record.num_outputs());
  const Eigen::MatrixXd residual = ModelResidual(
      record, model, first, last, static_cast<int>(std::min(settling, 1e9)));
  std::vector<SteadyOperation> parts;
  for (int i = 0; i < record.num_outputs(); ++i) {
    parts.push_back(TestSteadyOperation(
        residual.row(i), record.time(first), record.sample_time,
        {options.report_threshold, options.report_size}));
  }
  return parts;
}

// `settled`: the first sample of the record at which the plant has settled
// after the change before.
absl::StatusOr<SetPointWindow> MakeWindow(const Record& record,
                                          const ProcessModel& model,
                                          const Group& group, int settled,
                                          const Extent& extent,
                                          const WindowOptions& options) {
  SetPointWindow window;
  const int center = group.first_change();
  MLE_ASSIGN_OR_RETURN(
      window.record,
      CutWindow(record, center, (center - group.begin) * record.sample_time,
                (group.end - center) * record.sample_time));
  window.first_sample = group.begin;
  window.changes = group.changes;
  for (SetPointChange& change : window.changes) change.sample -= group.begin;
  window.clipped_before = group.clipped_before;
  window.clipped_after = group.clipped_after;

  const int first_steady = std::max(settled - group.begin, 0);
  window.before = TestParts(record, model, group.begin + first_steady,
                            center - 1, extent.settling, options);
  window.after = TestParts(
      record, model,
      static_cast<int>(std::min(group.last_change() + extent.settling, 2e9)),
      group.end, extent.settling, options);
  return window;
}

// Where inputs move that rest nearly always: steps made by hand. None where a
// controller moves them all the time, in answer to what nobody knows.
std::vector<SetPointChange> FindMovesByHand(const Record& record) {
  std::vector<SetPointChange> moves;
  for (int k = 1; k < record.samples(); ++k) {
    const auto before = record.inputs.col(k - 1).array();
    const auto now = record.inputs.col(k).array();
    if (((now - before).isFinite() && now != before).any()) {
      moves.push_back({k, -1, 0.0, 0.0});
    }
  }
  const double most = (1.0 - kAtRest) * record.samples();
  return static_cast<double>(moves.size()) > most
             ? std::vector<SetPointChange>()
             : moves;
}

// A change of an input by more than this share of its range is a move by hand.
constexpr double kLeastMove = 0.02;

bool Covers(const ByHand& segment, double time) {
  return time >= segment.from && time <= segment.to;
}

bool SaysNothing(const SetPointChange& change, const Record& record,
                 const std::vector<ByHand>& by_hand) {
  const double time = record.time(change.sample);
  return std::any_of(by_hand.begin(), by_hand.end(), [&](const ByHand& part) {
    return Covers(part, time) &&
           (part.output == ByHand::kAll || part.output == change.output);
  });
}

// Moves of inputs while an operator moved them.
void AddMovesByHand(const Record& record, const std::vector<ByHand>& by_hand,
                    std::vector<SetPointChange>& changes) {
  std::vector<bool> moved(record.samples(), false);
  for (int j = 0; j < record.num_inputs(); ++j) {
    const auto values = record.inputs.row(j).array();
    const double low = values.isFinite().select(values, HUGE_VAL).minCoeff();
    const double high = values.isFinite().select(values, -HUGE_VAL).maxCoeff();
    for (const ByHand& part : by_hand) {
      if (part.input != ByHand::kAll && part.input != j) continue;
      for (int k = 1; k < record.samples(); ++k) {
        if (!Covers(part, record.time(k - 1)) ||
            !Covers(part, record.time(k))) {
          continue;
        }
        const double move = std::abs(values(k) - values(k - 1));
        if (move > kLeastMove * (high - low)) moved[k] = true;
      }
    }
  }
  for (int k = 0; k < record.samples(); ++k) {
    if (moved[k]) changes.push_back({k, -1, 0.0, 0.0});
  }
  std::stable_sort(changes.begin(), changes.end(),
                   [](const SetPointChange& a, const SetPointChange& b) {
                     return a.sample < b.sample;
                   });
}

absl::Status CheckRecords(const std::vector<Record>& records,
                          const ProcessModel& model) {
  for (std::size_t r = 0; r < records.size(); ++r) {
    const absl::Status valid = records[r].Validate();
    if (!valid.ok()) {
      return InvalidArgument("windows: records[", r, "]: ", valid.message());
    }
    if (records[r].num_outputs() != model.num_outputs() ||
        records[r].num_inputs() != model.num_inputs()) {
      return InvalidArgument("windows: records[", r, "] has ",
                             records[r].num_outputs(), " outputs and ",
                             records[r].num_inputs(), " inputs, the model ",
                             model.num_outputs(), " and ", model.num_inputs());
    }
  }
  return absl::OkStatus();
}

void WarnOfFew(WindowSet& set) {
  if (set.windows.size() == 1) {
    set.warnings.push_back(
        "there is one window only: a correction cannot be validated on a "
        "held-out change, folds are blocks of this window, and only what this "
        "change excites can be estimated");
  }
}

}  // namespace

bool Adjoin(const SetPointWindow& before, const SetPointWindow& after) {
  return before.source == after.source &&
         before.first_sample + before.record.samples() == after.first_sample;
}

std::vector<Record> WindowSet::Records() const {
  std::vector<Record> records;
  for (const SetPointWindow& window : windows) records.push_back(window.record);
  return records;
}

absl::Status WindowOptions::Validate() const {
  const auto check = [](const char* field, double value) {
    if (value >= 0.0 && std::isfinite(value)) return absl::OkStatus();
    return InvalidArgument("windows: ", field, " is ", value,
                           ", must be finite and not negative");
  };
  MLE_RETURN_IF_ERROR(check("before", before));
  MLE_RETURN_IF_ERROR(check("after", after));
  MLE_RETURN_IF_ERROR(check("join_within", join_within));
  MLE_RETURN_IF_ERROR(check("min_change", min_change));
  MLE_RETURN_IF_ERROR(check("report_size", report_size));
  if (!(report_threshold > 0.0)) {
    return InvalidArgument("windows: report_threshold is ", report_threshold,
                           ", must be positive");
  }
  for (std::size_t k = 0; k < change_times.size(); ++k) {
    if (std::isfinite(change_times[k]) &&
        (k == 0 || change_times[k] > change_times[k - 1])) {
      continue;
    }
    return InvalidArgument("windows: change_times[", k, "] is ",
                           change_times[k],
                           "; times must be finite and increase");
  }
  return absl::OkStatus();
}

std::vector<std::vector<SetPointChange>> FindChanges(
    const std::vector<Record>& records, const WindowOptions& options) {
  std::vector<std::vector<SetPointChange>> changes;
  for (const Record& record : records) {
    std::vector<SetPointChange>& found = changes.emplace_back();
    for (const double time : options.change_times) {
      const double sample =
          std::round((time - record.start_time) / record.sample_time);
      if (sample < 0.0 || sample >= record.samples()) continue;
      found.push_back({static_cast<int>(sample), -1, 0.0, 0.0});
    }
    if (!options.change_times.empty()) continue;
    // A change grows from the last value that counted, so that a slow ramp of
    // small ones is seen.
    Eigen::VectorXd last = Eigen::VectorXd::Constant(
        record.set_points.rows(), std::numeric_limits<double>::quiet_NaN());
    for (const SetPointChange& change : FindSetPointChanges(record)) {
      if (SaysNothing(change, record, options.by_hand)) {
        last(change.output) = std::numeric_limits<double>::quiet_NaN();
        continue;
      }
      double& from = last(change.output);
      if (!std::isfinite(from)) from = change.from;
      if (std::abs(change.to - from) <= options.min_change) continue;
      found.push_back({change.sample, change.output, from, change.to});
      from = change.to;
    }
    AddMovesByHand(record, options.by_hand, found);
  }
  const bool any =
      std::any_of(changes.begin(), changes.end(),
                  [](const auto& found) { return !found.empty(); });
  if (any || !options.change_times.empty()) return changes;
  for (std::size_t r = 0; r < records.size(); ++r) {
    changes[r] = FindMovesByHand(records[r]);
  }
  return changes;
}

absl::StatusOr<WindowSet> FindWindows(const std::vector<Record>& records,
                                      const ProcessModel& model,
                                      const WindowOptions& options) {
  MLE_RETURN_IF_ERROR(options.Validate());
  MLE_RETURN_IF_ERROR(CheckRecords(records, model));
  const double settling = SettlingTime(model);
  const std::vector<std::vector<SetPointChange>> changes =
      FindChanges(records, options);
  WindowSet set;
  int short_windows = 0;
  std::string first_short;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const Record& record = records[r];
    const Extent extent = InSamples(options, settling, record.sample_time);
    set.before = extent.before * record.sample_time;
    set.after = extent.after * record.sample_time;
    set.changes += static_cast<int>(changes[r].size());
    std::vector<Group> groups = GroupChanges(changes[r], extent);
    PlaceWindows(extent, record.samples(), groups);
    double settled = 0.0;
    for (const Group& group : groups) {
      const int usable = group.end - group.first_change();
      if (usable < kMinWindowSamples) {
        if (short_windows == 0) {
          first_short =
              absl::StrCat("the change at ",
                           options.times.At(record.time(group.first_change())),
                           " has ", usable, " samples after it");
        }
        ++short_windows;
      } else {
        MLE_ASSIGN_OR_RETURN(
            SetPointWindow window,
            MakeWindow(record, model, group,
                       static_cast<int>(std::min(settled, 2e9)), extent,
                       options));
        window.source = static_cast<int>(r);
        set.windows.push_back(std::move(window));
      }
      settled = group.last_change() + extent.settling;
    }
  }
  if (short_windows > 0) {
    set.warnings.push_back(absl::StrCat(
        first_short,
        short_windows > 1
            ? absl::StrCat(", ", short_windows - 1, " more are like it")
            : "",
        ": at least ", kMinWindowSamples, " are needed; ",
        short_windows > 1 ? "they are left out" : "it is left out"));
  }
  const bool by_hand = options.change_times.empty() &&
                       options.by_hand.empty() && !set.windows.empty() &&
                       set.windows.front().changes.front().output < 0;
  if (by_hand) {
    set.warnings.push_back(
        "no set point changes: windows are made around moves of inputs that "
        "rest otherwise");
  }
  int given = 0;
  for (const auto& found : changes) given += static_cast<int>(found.size());
  const int missing = static_cast<int>(options.change_times.size()) - given;
  if (missing > 0) {
    set.warnings.push_back(absl::StrCat(
        missing, " of the given times of change lie in no record"));
  }
  WarnOfFew(set);
  return set;
}

}  // namespace mle
