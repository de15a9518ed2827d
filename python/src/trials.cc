// mle.Trial: a proposed model beside the one in use.

#include <string>
#include <vector>

#include "mle/trial/model_trial.h"
#include "pybind11/stl.h"
#include "python/src/bindings.h"
#include "python/src/models.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

ModelTrial MakeTrial(const py::object& in_use, const py::object& proposed,
                     double sample_time, double level) {
  return ValueOrThrow(ModelTrial::Create(ProcessOf(in_use), ProcessOf(proposed),
                                         sample_time, {.level = level}));
}

py::dict VerdictOf(const ModelTrial& trial) {
  const TrialVerdict verdict = trial.verdict();
  py::list evidence;
  for (const TrialEvidencePoint& point : verdict.evidence) {
    evidence.append(
        py::make_tuple(point.time, point.log_for, point.log_against));
  }
  py::dict values;
  values["advice"] = std::string(NameOf(verdict.advice));
  values["changes"] = verdict.changes;
  values["responses"] = verdict.responses;
  values["not_judged"] = verdict.not_judged;
  values["left_share"] = verdict.left_share;
  values["loss_ratio"] = LossRatio(trial.state().losses);
  values["evidence"] = evidence;
  return values;
}

}  // namespace

void AddTrials(py::module_& module) {
  py::class_<ModelTrial>(module, "_Trial")
      .def(py::init(&MakeTrial))
      .def("learn",
           [](ModelTrial& trial, const Record& record) {
             ThrowUnlessOk(trial.Learn(record));
           })
      .def("look",
           [](ModelTrial& trial, const Record& record) {
             ThrowUnlessOk(trial.Look(record));
           })
      .def("adopt", &ModelTrial::Adopt)
      .def_property_readonly("verdict", &VerdictOf);
}

}  // namespace mle::python
