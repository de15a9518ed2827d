// What is kept of one run: a line of runs.csv (docs/formats.md).

#ifndef APPS_EXPERIMENT_ROW_H_
#define APPS_EXPERIMENT_ROW_H_

#include <array>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/experiment/campaign.h"
#include "apps/experiment/grid.h"

namespace mle::experiment {

// What is measured of a run. NaN stands for "there is none" and is written as
// an empty field.
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
  // Of the estimators with structure:
  kLimitE,   // information bound of E, every element free
  kNamed,    // 1: the elements named as aged are those that differ, 0: not
  kCovered,  // share of the intervals of all parameters that hold the plant's
};
inline constexpr int kNumMetrics = 18;
extern const std::array<const char*, kNumMetrics> kMetricNames;

struct Row {
  std::int64_t run = 0;
  std::array<double, kNumMetrics> values;
  // Of processor time; what runs share counts for the first that needs it.
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

// Header and lines without a line end. `with_seconds`: as in the journal;
// runs.csv leaves them out, so that its bytes do not depend on the machine's
// load.
std::string RowHeader(bool with_seconds);
std::string RowText(const Campaign& campaign, const Grid& grid, const Row& row);

// What the line of a run begins with: its number and its coordinates.
std::string RowStart(const Campaign& campaign, const Grid& grid,
                     std::int64_t run);

// The line of runs.csv for one of the journal: the same without seconds.
std::string WithoutSeconds(std::string_view line);

// Run number, metrics and status of a line of either file. InvalidArgument says
// what is wrong with it.
absl::StatusOr<Row> ParseRow(std::string_view line, bool with_seconds);

// Names of a run's coordinates, as the columns hold them.
std::vector<std::string> CoordinateNames();
std::vector<std::string> CoordinateTexts(const Campaign& campaign,
                                         const Coordinates& at);

}  // namespace mle::experiment

#endif  // APPS_EXPERIMENT_ROW_H_
