// mle.Mpc: the predictive controller.

#include "apps/common/shared_options.h"
#include "control/mpc.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/models.h"
#include "python/src/options.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

void AddOptions(control::MpcOptions& options, OptionTable& table) {
  table.Add("Controller", mle::OptionsOf(options));
  table.Add("Limits in the controller", mle::OptionsOf(options.limits));
}

// Weights and limits for the channels of `model`.
control::MpcOptions TuningFor(const ProcessModel& model,
                              const OptionTexts& texts) {
  control::MpcOptions options;
  OptionTable table;
  AddOptions(options, table);
  SetOptions(texts, table);
  ThrowUnlessOk(table.FitTo(model));
  if (options.limits.min_output.size() == 0 &&
      options.limits.max_output.size() == 0) {
    options.limits.output_limit_cost.resize(0);
  }
  return options;
}

control::Mpc MakeMpc(const py::object& argument, const OptionTexts& texts) {
  const ProcessModel model = ProcessOf(argument);
  return ValueOrThrow(control::Mpc::Create(model, TuningFor(model, texts)));
}

Eigen::Index NumOutputs(const control::Mpc& mpc) {
  return mpc.model().num_outputs;
}

py::array Step(control::Mpc& mpc, const Array& measured,
               const Array& set_points) {
  Eigen::VectorXd next(mpc.model().num_inputs());
  mpc.Step(VectorOf(measured, NumOutputs(mpc), "measured"),
           VectorOf(set_points, NumOutputs(mpc), "set_points"), next);
  return CopyOf(next);
}

py::array StepWithPreview(control::Mpc& mpc, const Array& measured,
                          const Array& set_points) {
  const Eigen::MatrixXd ahead = MatrixOf(set_points, "set_points");
  if (ahead.rows() != NumOutputs(mpc) ||
      ahead.cols() != mpc.options().prediction_horizon) {
    throw py::value_error(
        "set_points must have the shape (prediction_horizon, outputs)");
  }
  Eigen::VectorXd next(mpc.model().num_inputs());
  mpc.StepWithPreview(VectorOf(measured, NumOutputs(mpc), "measured"), ahead,
                      next);
  return CopyOf(next);
}

void Exchange(control::Mpc& mpc, const py::object& argument,
              const OptionTexts& texts) {
  const ProcessModel model = ProcessOf(argument);
  const control::MpcOptions tuning = TuningFor(model, texts);
  ThrowUnlessOk(mpc.ExchangeModel(
      ValueOrThrow(control::PredictFromProcess(model, tuning.control_period)),
      tuning));
}

void Restart(control::Mpc& mpc, const Array& inputs, const Array& outputs) {
  mpc.Restart(VectorOf(inputs, mpc.model().num_inputs(), "inputs"),
              VectorOf(outputs, NumOutputs(mpc), "outputs"));
}

void MeasureDisturbances(control::Mpc& mpc, const Array& disturbances) {
  const auto count = static_cast<Eigen::Index>(
      mpc.model().InputsOf(InputRole::kDisturbance).size());
  mpc.MeasureDisturbances(VectorOf(disturbances, count, "disturbances"));
}

py::list OptionsOfMpc() {
  control::MpcOptions options;
  OptionTable table;
  AddOptions(options, table);
  return TextsOf(table);
}

}  // namespace

void AddController(py::module_& module) {
  py::class_<control::Mpc>(module, "_Mpc")
      .def(py::init(&MakeMpc))
      .def("step", &Step, py::arg("measured"), py::arg("set_points"))
      .def("step_with_preview", &StepWithPreview, py::arg("measured"),
           py::arg("set_points"))
      .def("measure_disturbances", &MeasureDisturbances,
           py::arg("disturbances"))
      .def("restart", &Restart, py::arg("inputs"), py::arg("outputs"))
      .def("exchange", &Exchange)
      .def_property_readonly("predicted_outputs",
                             [](const control::Mpc& mpc) {
                               return CopyOf(mpc.PredictedOutputs());
                             })
      .def_property_readonly(
          "gain", [](const control::Mpc& mpc) { return CopyOf(mpc.gain()); });
  module.def("_mpc_options", &OptionsOfMpc);
}

}  // namespace mle::python
