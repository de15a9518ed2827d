#include "mle/data/stuck_outputs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "mle/base/status.h"
#include "mle/data/robust_statistics.h"
#include "mle/model/process_simulator.h"

namespace mle {
namespace {

constexpr int kLeastSamples = 10;
constexpr double kUsualRuns = 3.0;  // longer than so many times the usual run
constexpr double kPart = 0.6;
constexpr double kDeviations = 5.0;
constexpr double kQuanta = 20.0;
constexpr double kOfRange = 0.1;
constexpr double kDeadShare = 0.9;

// Inputs without gaps: held, and before the first good sample as that one.
Eigen::MatrixXd Held(const Eigen::MatrixXd& inputs) {
  Eigen::MatrixXd held = inputs;
  for (Eigen::Index j = 0; j < held.rows(); ++j) {
    double last = 0.0;
    for (Eigen::Index k = held.cols() - 1; k >= 0; --k) {
      if (std::isfinite(held(j, k))) last = held(j, k);
    }
    for (Eigen::Index k = 0; k < held.cols(); ++k) {
      if (!std::isfinite(held(j, k))) held(j, k) = last;
      last = held(j, k);
    }
  }
  return held;
}

double RangeOf(const SampleRow& row) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : row) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return high >= low ? high - low : 0.0;
}

// Runs of equal good samples; of a constant row one, whatever its gaps.
std::vector<SampleRun> EqualRuns(const SampleRow& row, int record) {
  std::vector<SampleRun> runs;
  for (Eigen::Index k = 0; k < row.size(); ++k) {
    if (!std::isfinite(row(k))) continue;
    const int at = static_cast<int>(k);
    const bool goes_on = !runs.empty() && row(k) == row(runs.back().first) &&
                         runs.back().first + runs.back().samples == at;
    if (goes_on) {
      ++runs.back().samples;
    } else {
      runs.push_back({record, at, 1});
    }
  }
  const bool is_constant =
      std::all_of(runs.begin(), runs.end(), [&](const SampleRun& run) {
        return row(run.first) == row(runs.front().first);
      });
  if (is_constant && runs.size() > 1) {
    runs.front().samples =
        runs.back().first + runs.back().samples - runs.front().first;
    runs.resize(1);
  }
  return runs;
}

// The usual behaviour of an output.
struct Usual {
  double change = 0.0;  // of the model's response, to be beyond
  double run = 1.0;
  double good = 0.0;   // samples
  bool moves = false;  // within any record
};

Usual UsualOf(const std::vector<Record>& records,
              const std::vector<Eigen::MatrixXd>& responses, int output,
              const std::vector<SampleRun>& runs) {
  Usual usual;
  std::vector<SampleRow> rows;
  std::vector<double> noises;
  double range = 0.0;
  for (std::size_t r = 0; r < records.size(); ++r) {
    rows.emplace_back(records[r].outputs.row(output));
    noises.push_back(WhiteDeviation(rows.back()));
    range = std::max(range, RangeOf(responses[r].row(output)));
  }
  const double noise = MedianInPlace(noises);
  usual.change = std::max({kOfRange * range, kDeviations * noise,
                           kQuanta * FindQuantum(rows, noise)});
  std::vector<double> lengths;
  for (const SampleRun& run : runs) {
    lengths.push_back(run.samples);
    usual.good += run.samples;
  }
  // A constant output has one run in each record.
  usual.moves = runs.size() > records.size();
  if (usual.moves) usual.run = MedianInPlace(lengths);
  return usual;
}

StuckOutput FindStuck(const std::vector<Record>& records,
                      const std::vector<Eigen::MatrixXd>& responses,
                      int output) {
  StuckOutput stuck;
  stuck.output = output;
  std::vector<SampleRun> runs;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const std::vector<SampleRun> found =
        EqualRuns(records[r].outputs.row(output), static_cast<int>(r));
    runs.insert(runs.end(), found.begin(), found.end());
  }
  const Usual usual = UsualOf(records, responses, output, runs);
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const SampleRun& run : runs) {
    const double value = records[run.record].outputs(output, run.first);
    low = std::min(low, value);
    high = std::max(high, value);
    if (run.samples < kLeastSamples || run.samples < kUsualRuns * usual.run) {
      continue;
    }
    // The change that ends a run of an output that moves may be the one
    // expected.
    const auto part =
        static_cast<Eigen::Index>((usual.moves ? kPart : 1.0) * run.samples);
    const double change =
        RangeOf(responses[run.record].row(output).segment(run.first, part));
    if (!(change > usual.change)) continue;
    if (stuck.runs.empty()) stuck.value = value;
    stuck.expected = std::max(stuck.expected, change);
    stuck.runs.push_back(run);
  }
  if (stuck.samples() >= kDeadShare * usual.good) {
    stuck.kind = StuckOutput::Kind::kDead;
  } else if (stuck.runs.size() > 1 &&
             std::all_of(stuck.runs.begin(), stuck.runs.end(),
                         [&](const SampleRun& run) {
                           const double value =
                               records[run.record].outputs(output, run.first);
                           return value == low || value == high;
                         })) {
    stuck.kind = StuckOutput::Kind::kClipped;
  }
  return stuck;
}

}  // namespace

int StuckOutput::samples() const {
  int count = 0;
  for (const SampleRun& run : runs) count += run.samples;
  return count;
}

absl::StatusOr<std::vector<StuckOutput>> FindStuckOutputs(
    const std::vector<Record>& records, const ProcessModel& model) {
  std::vector<Eigen::MatrixXd> responses;
  for (const Record& record : records) {
    MLE_ASSIGN_OR_RETURN(
        Eigen::MatrixXd response,
        SimulateResponse(model, record.sample_time, Held(record.inputs)));
    responses.push_back(std::move(response));
  }
  std::vector<StuckOutput> all;
  for (int i = 0; i < model.num_outputs(); ++i) {
    StuckOutput stuck = FindStuck(records, responses, i);
    if (!stuck.runs.empty()) all.push_back(std::move(stuck));
  }
  return all;
}

}  // namespace mle
