// The life of a proposed correction: a published plant under predictive
// control, a model that the plant has left or not, a correction of it that is
// right or wrong, and days of operation on which a trial decides.
//
// A day is a record of its own of six settling times from rest; on half of the
// days one set point moves. Each life has white noise at every output and one
// of: nothing else, drift, coloured noise, loads at the inputs, steps, a
// sinusoid.

#ifndef BENCHMARKS_TRIAL_TRIAL_LIFE_H_
#define BENCHMARKS_TRIAL_TRIAL_LIFE_H_

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/mpc_options.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"
#include "mle/trial/model_trial.h"
#include "sim/plant_conditions.h"
#include "sim/set_point_profile.h"

namespace mle::benchmarks {

// The proposed change of an element, and what it is to the plant's.
enum class Proposal {
  kEstimated,       // by CorrectFromRecords()
  kSmall,           // half of the true change
  kTwice,           // twice the true change
  kOppositeSign,    // the true change with the other sign
  kOtherElement,    // a change of as much of another element of the output
  kOtherParameter,  // a change of as much of another parameter of the element
  kNothingAged,     // a change of a plant that has not changed
  kOneOfTwo,        // the true change, and one of another output
};
inline constexpr int kProposals = 8;
inline constexpr std::array<const char*, kProposals> kProposalNames = {
    "estimated",     "half",          "twice",
    "opposite sign", "other element", "other parameter",
    "nothing aged",  "one of two"};

inline constexpr int kDisturbances = 6;
inline constexpr std::array<const char*, kDisturbances> kDisturbanceNames = {
    "white noise", "drift", "coloured noise", "input loads", "steps", "sine"};

// In units in which steps of set points, and the inputs that make them, are 1.
struct TrialPlant {
  ProcessModel model;
  double settling = 0.0;
  double sample_time = 0.0;
  control::MpcOptions tuning;
};

TrialPlant ReadTrialPlant(const std::string& path, std::vector<double> steps,
                          double sample_time, double control_period,
                          int horizon);

class TrialLife {
 public:
  TrialLife(const TrialPlant& plant, Proposal proposal, std::uint64_t seed);

  // Nothing where the correction proposes none.
  const std::optional<ProcessModel>& proposed() const { return proposed_; }
  const ProcessModel& truth() const { return truth_; }
  const Record& first_record() const { return first_record_; }
  int disturbance() const { return disturbance_; }

  // With `model` in the controller and `truth` as the plant.
  Record Day(const ProcessModel& model, const ProcessModel& truth,
             int day) const;
  // The sum of squared errors of the outputs after a step of each set point and
  // of each output's disturbance in turn, without noise, with `model` in the
  // controller; infinite where the loop is not stable.
  double ControlCost(const ProcessModel& model) const;
  // E: the sum of squared differences to the plant's step responses.
  double Distance(const ProcessModel& model) const;

 private:
  Record Simulate(const ProcessModel& model, const ProcessModel& truth,
                  const sim::SetPointProfile& profile, double duration,
                  std::uint64_t stream) const;

  const TrialPlant& plant_;
  std::uint64_t seed_;
  int disturbance_ = 0;
  double noise_ = 0.0;  // standard deviation
  sim::PlantConditions conditions_;
  ProcessModel truth_;
  std::optional<ProcessModel> proposed_;
  Record first_record_;
};

}  // namespace mle::benchmarks

#endif  // BENCHMARKS_TRIAL_TRIAL_LIFE_H_
