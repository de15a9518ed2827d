// Plants with equations of their own, by the names that --plant has for them.

#ifndef APPS_SIMULATE_NONLINEAR_PLANTS_H_
#define APPS_SIMULATE_NONLINEAR_PLANTS_H_

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "sim/continuous_plant.h"

namespace mle::simulate {

struct NonlinearPlant {
  std::string name;
  std::string about;      // "a stirred tank reactor"
  ProcessModel channels;  // without elements
  // Where it starts unless other inputs are given.
  std::vector<double> operating_inputs;
  // At its steady state for the inputs, at a time of the ageing in a file
  // (empty: none). Errors name the option.
  std::function<absl::StatusOr<sim::ContinuousSystem>(
      const std::vector<double>& inputs, const std::string& ageing_path,
      double age)>
      make;
};

const std::vector<NonlinearPlant>& NonlinearPlants();

// Null where there is none of that name.
const NonlinearPlant* FindNonlinearPlant(std::string_view name);

}  // namespace mle::simulate

#endif  // APPS_SIMULATE_NONLINEAR_PLANTS_H_
