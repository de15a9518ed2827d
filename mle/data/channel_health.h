// Data quality of the channels of records: frozen, saturated, quantised,
// outlying, constant, missing.
//
//   const HealthReport health = CheckHealth(records, model, HealthOptions());
//   std::cout << health.Report(records);
//   MarkBad(health, MarkOptions(), records);   // frozen and outlying → NaN
//
// frozen     an output repeats one value for longer than its noise, or its
//            rounding, lets it; one without noise, if that stops a movement
//            while other channels go on
// saturated  an input stays at its largest or smallest value while other
//            channels move: at a limit, or not under control
// quantised  all samples are multiples of a step that is not small beside the
//            noise
// outlying   outputs by the Hampel filter (outliers.h), which does not take a
//            response to a set point for one; inputs where a single sample
//            leaves a value that is held on both sides
// constant   the channel never moves

#ifndef MLE_DATA_CHANNEL_HEALTH_H_
#define MLE_DATA_CHANNEL_HEALTH_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/data/time_names.h"
#include "mle/model/process_model.h"

namespace mle {

// Of the Hampel filter.
struct OutlierOptions {
  // Samples on each side, ≥ 2. Fewer than this in a row are found.
  int half_width = 5;
  double threshold = 5.0;  // > 0
};

struct HealthOptions {
  OutlierOptions outliers;
  // A value repeated up to this often is not a freeze, ≥ 2.
  int min_frozen_samples = 10;
  // Where inputs end (m), NaN where unknown; or empty. Samples there are
  // saturated, whatever else happens.
  Eigen::VectorXd input_min = {};
  Eigen::VectorXd input_max = {};
};

// `samples` samples of records[record] from `first` on.
struct SampleRun {
  int record = 0;
  int first = 0;
  int samples = 0;
};

struct ChannelHealth {
  std::string name;
  bool is_output = false;
  int channel = 0;
  int samples = 0;
  int bad = 0;  // NaN
  bool is_constant = false;
  std::vector<SampleRun> frozen;
  std::vector<SampleRun> saturated;
  double quantum = 0.0;             // 0: negligible or none
  double noise = 0.0;               // standard deviation of the white part
  std::vector<SampleRun> outliers;  // of one sample each

  int frozen_samples() const;
  int saturated_samples() const;
  bool is_healthy() const;
  // A line for each finding; times are those of `records`.
  std::string Report(const std::vector<Record>& records,
                     const TimeNames& times = TimeNames()) const;
};

struct HealthReport {
  std::vector<ChannelHealth> channels;  // outputs, then inputs

  // Lines for the channels with findings; one line without findings.
  std::string Report(const std::vector<Record>& records) const;
};

// The records are of the model's channels.
HealthReport CheckHealth(const std::vector<Record>& records,
                         const ProcessModel& model,
                         const HealthOptions& options);

struct MarkOptions {
  bool frozen = true;  // all but the first sample of a freeze
  bool outliers = true;
};

// Turns what the report found into bad samples (NaN), an outlier of an input
// into the value held around it; returns how many. `records` are those that the
// report describes.
int MarkBad(const HealthReport& report, const MarkOptions& options,
            std::vector<Record>& records);

}  // namespace mle

#endif  // MLE_DATA_CHANNEL_HEALTH_H_
