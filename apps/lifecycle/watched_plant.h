// A plant about an operating point, with a disturbance of its outputs. It keeps
// what the outputs really were, without measurement noise.

#ifndef APPS_LIFECYCLE_WATCHED_PLANT_H_
#define APPS_LIFECYCLE_WATCHED_PLANT_H_

#include <utility>

#include "Eigen/Core"
#include "sim/plant_model.h"

namespace mle::lifecycle {

class WatchedPlant final : public sim::PlantModel {
 public:
  // The plant's own inputs are `input_offset` more than those here, and the
  // outputs here `output_offset` more than its own. `disturbance` (p × (N + 1))
  // has one column more than there will be samples.
  WatchedPlant(sim::PlantModel& plant, Eigen::VectorXd input_offset,
               const Eigen::VectorXd& output_offset,
               Eigen::MatrixXd disturbance)
      : plant_(plant),
        input_offset_(std::move(input_offset)),
        truth_(std::move(disturbance)) {
    truth_.colwise() += output_offset;
    Look();
  }

  int num_inputs() const override { return plant_.num_inputs(); }
  int num_outputs() const override { return plant_.num_outputs(); }
  void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) override {
    plant_.Advance(input + input_offset_);
    ++sample_;
    Look();
  }
  const Eigen::VectorXd& outputs() const override { return outputs_; }

  // p × (N + 1); columns of samples that are still to come are the disturbance.
  const Eigen::MatrixXd& truth() const { return truth_; }

 private:
  void Look() {
    truth_.col(sample_) += plant_.outputs();
    outputs_ = truth_.col(sample_);
  }

  sim::PlantModel& plant_;
  Eigen::VectorXd input_offset_;
  Eigen::MatrixXd truth_;
  Eigen::VectorXd outputs_;
  Eigen::Index sample_ = 0;
};

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_WATCHED_PLANT_H_
