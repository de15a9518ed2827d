// mle.simulate: mle_simulate's request and run; plants stepped by hand.

#include <memory>
#include <string>

#include "apps/simulate/request.h"
#include "mle/data/sampling.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/models.h"
#include "python/src/options.h"
#include "python/src/status.h"
#include "sim/closed_loop.h"
#include "sim/plant.h"

namespace mle::python {
namespace {

namespace py = pybind11;

const std::vector<std::string>& NotSimulateKeywords() {
  static const std::vector<std::string>& names =
      *new std::vector<std::string>{"model", "plant", "out"};
  return names;
}

struct SimulateCall {
  simulate::Request request;
  OptionTable table;

  SimulateCall() { simulate::AddOptions(request, table); }
};

// A plant by name is a non-linear one of mle_simulate, or a file.
std::shared_ptr<SimulateCall> PrepareSimulation(const py::object& model,
                                                const py::object& plant,
                                                const OptionTexts& options) {
  auto call = std::make_shared<SimulateCall>();
  simulate::Request& request = call->request;
  SetOptions(options, call->table);
  request.simulation.model = ProcessOf(model);
  if (py::isinstance<py::str>(plant)) {
    request.plant = plant.cast<std::string>();
  } else if (!plant.is_none()) {
    request.plant_model = ProcessOf(plant);
  }
  ThrowUnlessOk(simulate::CompleteForModel(request, call->table));
  return call;
}

Record Simulate(const py::object& model, const py::object& plant,
                const OptionTexts& options) {
  const auto call = PrepareSimulation(model, plant, options);
  return ValueOrThrow(RunLongFor<Record>(
      [call](const ProgressCallback& /*report*/) {
        return simulate::Run(call->request.simulation);
      },
      py::none()));
}

// controller(measured (p,), set_points (p,), last_inputs (m,)) -> inputs (m,).
Record SimulateWith(const py::object& model, const py::object& plant,
                    const OptionTexts& options, const py::object& controller) {
  const auto call = PrepareSimulation(model, plant, options);
  simulate::Simulation& simulation = call->request.simulation;
  ThrowUnlessOk(simulation.set_points.Validate(simulation.model.num_outputs()));
  const sim::Controller step =
      [&controller](const Eigen::Ref<const Eigen::VectorXd>& measured,
                    const Eigen::Ref<const Eigen::VectorXd>& set_points,
                    Eigen::Ref<Eigen::VectorXd> next) {
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        const py::object inputs = controller(
            CopyOf(Eigen::VectorXd(measured)),
            CopyOf(Eigen::VectorXd(set_points)), CopyOf(Eigen::VectorXd(next)));
        next = VectorOf(inputs.cast<Array>(), next.size(),
                        "what the controller returns");
      };
  return ValueOrThrow(sim::SimulateClosedLoop(
      *simulation.plant, simulation.model, step, simulation.set_points,
      simulation.loop, simulation.conditions));
}

py::list OptionsOfSimulate() {
  SimulateCall call;
  return TextsOf(call.table, NotSimulateKeywords());
}

sim::Plant MakePlant(const py::object& model, double sample_time) {
  ThrowUnlessOk(ValidateSampling(sample_time, sample_time));
  return ValueOrThrow(
      sim::Plant::Create(ProcessOf(model), {.sample_time = sample_time}));
}

}  // namespace

void AddSimulation(py::module_& module) {
  py::class_<sim::Plant>(
      module, "Plant",
      "A process model simulated exactly, from rest, under inputs that are "
      "held from sample to sample.")
      .def(py::init(&MakePlant), py::arg("model"), py::kw_only(),
           py::arg("sample_time"))
      .def_property_readonly(
          "outputs",
          [](const sim::Plant& plant) { return CopyOf(plant.outputs()); },
          "y (p,) at the present sample, without noise.")
      .def(
          "advance",
          [](sim::Plant& plant, const Array& inputs) {
            plant.Advance(VectorOf(inputs, plant.num_inputs(), "inputs"));
            return CopyOf(plant.outputs());
          },
          py::arg("inputs"),
          "Holds inputs (m,) to the next sample and returns the outputs (p,) "
          "there.");
  module.def("_simulate", &Simulate);
  module.def("_simulate_with", &SimulateWith);
  module.def("_simulate_options", &OptionsOfSimulate);
}

}  // namespace mle::python
