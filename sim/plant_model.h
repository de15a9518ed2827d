// The interface of a plant to the simulations, however it is computed: it goes
// from one sample to the next under held inputs, and tells its outputs there.
//
// Implementations: Plant (transfer functions, the fast path), ContinuousPlant
// (any differential equations with dead times), AgeingPlant.

#ifndef SIM_PLANT_MODEL_H_
#define SIM_PLANT_MODEL_H_

#include "Eigen/Core"

namespace mle::sim {

class PlantModel {
 public:
  virtual ~PlantModel() = default;

  virtual int num_inputs() const = 0;   // m
  virtual int num_outputs() const = 0;  // p

  // Holds `input` (m) from the present sample to the next one and goes there.
  virtual void Advance(const Eigen::Ref<const Eigen::VectorXd>& input) = 0;

  // y (p) at the present sample, just before the input may change, without
  // measurement noise. Not finite once a plant has blown up.
  virtual const Eigen::VectorXd& outputs() const = 0;

 protected:
  PlantModel() = default;
  PlantModel(const PlantModel&) = default;
  PlantModel(PlantModel&&) = default;
  PlantModel& operator=(const PlantModel&) = default;
  PlantModel& operator=(PlantModel&&) = default;
};

}  // namespace mle::sim

#endif  // SIM_PLANT_MODEL_H_
