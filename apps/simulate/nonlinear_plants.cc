#include "apps/simulate/nonlinear_plants.h"

#include "apps/common/option_table.h"
#include "mle/base/status.h"
#include "sim/ageing_json.h"
#include "sim/ph_neutralisation.h"
#include "sim/quadruple_tank.h"
#include "sim/van_de_vusse.h"

namespace mle::simulate {
namespace {

// `inputs`: the options that are inputs of the plant, in the order of these.
template <typename Options>
auto MakerOf(absl::StatusOr<sim::ContinuousSystem> (*make)(Options, double),
             std::vector<double Options::*> inputs) {
  return [make, inputs](const std::vector<double>& values,
                        const std::string& ageing_path,
                        double age) -> absl::StatusOr<sim::ContinuousSystem> {
    Options options;
    for (std::size_t j = 0; j < inputs.size(); ++j) {
      options.*inputs[j] = values[j];
    }
    if (!ageing_path.empty()) {
      MLE_RETURN_IF_ERROR(AboutOption(
          "ageing",
          sim::ReadAgeingFactors(ageing_path, AgeingFactors(options))));
    }
    return AboutOption("plant", make(options, age));
  };
}

}  // namespace

const std::vector<NonlinearPlant>& NonlinearPlants() {
  using Reactor = sim::VanDeVusseOptions;
  using Tanks = sim::QuadrupleTankOptions;
  using Neutralisation = sim::PhNeutralisationOptions;
  static const std::vector<NonlinearPlant>& plants =
      *new std::vector<NonlinearPlant>{
          {"van_de_vusse",
           "a stirred tank reactor",
           ProcessModel("reactor", "h", {{"feed", "1/h"}, {"heat", "kJ/h"}},
                        {{"product", "mol/L"}, {"temperature", "degC"}}),
           {8.0, -1113.5},
           MakerOf<Reactor>(sim::MakeVanDeVusseReactor,
                            {&Reactor::feed, &Reactor::heat})},
          {"quadruple_tank",
           "four tanks and two pumps",
           ProcessModel("tanks", "s", {{"pump1", "V"}, {"pump2", "V"}},
                        {{"level1", "cm"}, {"level2", "cm"}}),
           {3.0, 3.0},
           MakerOf<Tanks>(sim::MakeQuadrupleTank,
                          {&Tanks::voltage1, &Tanks::voltage2})},
          {"ph_neutralisation",
           "an acid, a base and a buffer in a tank",
           ProcessModel("neutralisation", "s",
                        {{"acid", "mL/s"}, {"base", "mL/s"}},
                        {{"level", "cm"}, {"pH", ""}}),
           {16.6, 15.55},
           MakerOf<Neutralisation>(
               sim::MakePhNeutralisation,
               {&Neutralisation::acid, &Neutralisation::base})}};
  return plants;
}

const NonlinearPlant* FindNonlinearPlant(std::string_view name) {
  for (const NonlinearPlant& plant : NonlinearPlants()) {
    if (plant.name == name) return &plant;
  }
  return nullptr;
}

}  // namespace mle::simulate
