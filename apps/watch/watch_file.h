// The file that lists the controllers that are watched (docs/formats.md).

#ifndef APPS_WATCH_WATCH_FILE_H_
#define APPS_WATCH_WATCH_FILE_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "apps/correct/next_move.h"
#include "control/mpc_options.h"
#include "control/operating_cost.h"
#include "mle/base/double_limits.h"
#include "mle/database/database_options.h"
#include "mle/model/process_model.h"
#include "mle/monitor/change_evidence.h"

namespace mle::watch {

// Hours in a mean year, leap years included.
inline constexpr double kHoursOfYear = 8766.0;

// The prices of operation and of an update, and the time that an update is
// expected to serve.
struct Valuation {
  control::Prices prices;
  // p, or one value for all, each ≥ 0: |y − r| beyond which the price of
  // violation holds.
  Eigen::VectorXd allowed_error = Eigen::VectorXd::Constant(1, kInfinity);
  std::string currency;            // as it is shown; may be empty
  int days_between_updates = 365;  // for which one is expected to serve
  double operating_hours = kHoursOfYear;
};

struct Controller {
  std::string list;  // the file that it stands in
  std::string name;
  std::string model;         // path
  std::string records;       // folder of exports (CSV), or a database
  DatabaseOptions database;  // query, or table and columns
  std::string begin;         // date of the first record; empty: all
  // For a database: how many of the last days looked at are read again, for
  // samples that come late or are corrected.
  int overlap_days = 2;
  std::string tag_file;      // or empty
  std::string time_zone;     // of dates without one; empty: UTC
  double sample_time = 0.0;  // of the model's time unit; 0: that of the files
  int reference_days = 14;
  WatchOptions options;
  // Vectors have one value, or one for each channel: see FitToModel().
  std::optional<Valuation> valuation = {};
  std::optional<control::MpcOptions> tuning = {};
  // What corrections plan where records leave something open; nothing: they
  // plan nothing.
  std::optional<correct::NextMoveOptions> plan = {};
};

// Paths that are not absolute are taken from the folder of the file.
// InvalidArgument names the file, the key, what was found and what would be
// right; names of controllers are not empty, differ, and may stand in the names
// of files.
absl::StatusOr<std::vector<Controller>> ParseWatchFile(std::string_view json,
                                                       const std::string& path);
absl::StatusOr<std::vector<Controller>> ReadWatchFile(const std::string& path);

// Prices, tuning and limits of the plan with a value for each channel of the
// model. InvalidArgument names the file, the controller, the key, what was
// found and what would be right.
absl::Status FitToModel(const ProcessModel& model, Controller& controller);

}  // namespace mle::watch

#endif  // APPS_WATCH_WATCH_FILE_H_
