// The runs of a campaign by number, and the units of work they are dealt in.
//
// A run's number is (scenario · methods + method) · seeds + seed, the
// scenario's own digits being model, noise, ablation, drift, effects,
// controller, windows and mismatch: the runs of a cell of the grid, which
// differ in nothing but the seed, follow one another.
//
// A unit is one seed with a few scenarios that share the
// conversion of the initial model, and all methods on them: what they have in
// common is computed once. Units follow one another seed by seed, so that a
// campaign that is cut short has seen every cell. Nothing is kept in memory:
// both orders are arithmetic.

#ifndef APPS_EXPERIMENT_GRID_H_
#define APPS_EXPERIMENT_GRID_H_

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"

namespace mle::experiment {

struct Coordinates {
  Scenario scenario;
  int method = 0;
  int seed = 0;  // index
};

class Grid {
 public:
  static constexpr int kUnitScenarios = 4;

  // Units of up to `unit_scenarios` ≥ 1 scenarios.
  explicit Grid(const Campaign& campaign, int unit_scenarios = kUnitScenarios);

  std::int64_t num_runs() const { return num_cells() * seeds_; }
  std::int64_t num_cells() const { return scenarios_ * methods_; }
  std::int64_t num_units() const { return conversions_ * blocks_ * seeds_; }
  int seeds() const { return seeds_; }

  // False where the campaign has more runs than can be counted.
  bool IsCountable() const { return countable_; }

  Coordinates At(std::int64_t run) const;
  std::int64_t CellOf(std::int64_t run) const { return run / seeds_; }

  // The runs of a unit: scenario by scenario, method by method.
  std::vector<std::int64_t> RunsOf(std::int64_t unit) const;

 private:
  std::array<int, 8> scenario_counts_;  // digit by digit
  int methods_, seeds_;
  int unit_scenarios_;
  std::int64_t conversions_;  // models × noises × ablations
  std::int64_t shared_;       // scenarios that share a conversion
  std::int64_t blocks_;       // units they make
  std::int64_t scenarios_;
  bool countable_;
};

// The row of one run, a line of runs.csv (docs/formats.md).

// The metrics of a run. NaN stands for "there is none" and is written as an
// empty field.
enum class Metric {
  kInitialE,   // E(M, G₀), the model left as it is
  kE,          // E of the model estimated
  kBestE,      // E at the best λ of the grid, one for all outputs
  kRatio,      // E / E at the best λ
  kZeroE,      // E at the smallest λ of the grid
  kLambdaMin,  // λ chosen; the two differ where each output has its own
  kLambdaMax,
  kBestLambda,  // best λ in hindsight
  kGainErrorRms,  // of all elements that are not zero: (K̂ − K)/K of FOPDT fits
  kGainErrorMax,
  kDelayErrorRms,  // L̂ − L of the same fits, in time units
  kDelayErrorMax,
  kProposed,  // 1: the records proved a change, 0: not
  kPValue,    // of the initial model being right
  kGap,       // largest relative duality gap of the conversion and all fits
  // Estimators with structure alone:
  kLimitE,   // information bound of E, every element free
  kNamed,    // 1: the elements named as aged are those that differ, 0: not
  kCovered,  // share of the intervals of all parameters that hold the plant's
};
inline constexpr int kNumMetrics = 18;
extern const std::array<const char*, kNumMetrics> kMetricNames;

struct Row {
  std::int64_t run = 0;
  std::array<double, kNumMetrics> values;
  // Processor time; work that runs share counts for the first that needs it.
  double seconds = 0.0;
  std::string status = "ok";  // or why there is no result

  Row() { values.fill(std::numeric_limits<double>::quiet_NaN()); }
  double& operator[](Metric metric) {
    return values[static_cast<std::size_t>(metric)];
  }
  double operator[](Metric metric) const {
    return values[static_cast<std::size_t>(metric)];
  }
  bool ok() const { return status == "ok"; }
};

// The shortest text that reads as the same number; "" for NaN, "inf".
std::string NumberText(double value);

// A field of a CSV file (RFC 4180), quoted where need be; control characters
// become blanks.
std::string CsvField(std::string_view text);

// Header of runs.csv, and lines of the journal, without a line end. A line of
// runs.csv is one of the journal without its last column, the seconds, so that
// its bytes do not depend on the machine's load.
std::string RowHeader();
std::string RowText(const Campaign& campaign, const Grid& grid, const Row& row);

// The start of the line of a run: its number and its coordinates.
std::string RowStart(const Campaign& campaign, const Grid& grid,
                     std::int64_t run);

// Run number, metrics and status of a line of the journal. InvalidArgument says
// what is wrong with it.
absl::StatusOr<Row> ParseRow(std::string_view line);

// Names of a run's coordinates, as the columns hold them.
std::vector<std::string> CoordinateNames();
std::vector<std::string> CoordinateTexts(const Campaign& campaign,
                                         const Coordinates& at);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_GRID_H_
