// What models say of records: mle.predict, mle.compare, mle.resid, mle.lsim.

#include "mle/maintain/prediction.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "mle/base/double_limits.h"
#include "mle/base/status.h"
#include "mle/data/linearise.h"
#include "mle/data/sampling.h"
#include "mle/maintain/channel_scales.h"
#include "mle/maintain/validation.h"
#include "mle/maintain/whole_windows.h"
#include "mle/model/process_simulator.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/models.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

// A part of a record in which all inputs are known.
struct KnownPart {
  std::size_t record = 0;
  SampleRange range;
};

// A model and the parts of records that it can predict.
struct Predictions {
  ProcessModel model;
  std::vector<Record> records;
  std::vector<KnownPart> places;
  std::vector<Record> parts;
  Predictor predictor;
};

absl::Status CheckRecords(const std::vector<Record>& records,
                          const ProcessModel& model) {
  if (records.empty())
    return absl::InvalidArgumentError("there are no records");
  for (const Record& record : records) {
    if (record.num_outputs() != model.num_outputs() ||
        record.num_inputs() != model.num_inputs()) {
      return InvalidArgument("a record has ", record.num_outputs(),
                             " outputs and ", record.num_inputs(),
                             " inputs; the model has ", model.num_outputs(),
                             " and ", model.num_inputs());
    }
    if (record.sample_time != records.front().sample_time) {
      return InvalidArgument("records have the sample times ",
                             records.front().sample_time, " and ",
                             record.sample_time, "; they must have one");
    }
  }
  return absl::OkStatus();
}

// Returns the places of the parts that have `samples` samples or more with all
// inputs known: such a part is longer than the model's memory. Where no part
// is, the function returns the longest part of each record.
std::vector<KnownPart> PlacesIn(const std::vector<Record>& records,
                                int samples) {
  std::vector<KnownPart> places;
  for (std::size_t r = 0; r < records.size(); ++r) {
    for (const SampleRange& range : WholeParts(records[r], samples)) {
      places.push_back({r, range});
    }
  }
  if (!places.empty()) return places;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const SampleRange range = WholeInputs(records[r]);
    if (range.samples() > 1) places.push_back({r, range});
  }
  return places;
}

absl::StatusOr<Predictions> Prepare(ProcessModel model,
                                    std::vector<Record> records) {
  MLE_RETURN_IF_ERROR(CheckRecords(records, model));
  // Models with transforms are linear in other variables than the records'.
  for (Record& record : records) {
    MLE_RETURN_IF_ERROR(Linearise(model, record));
  }
  MLE_ASSIGN_OR_RETURN(const InputResponse response,
                       ResponseOf(model, records.front().sample_time));
  Predictions predictions;
  predictions.places = PlacesIn(records, response.forgetting + 2);
  if (predictions.places.empty()) {
    return absl::InvalidArgumentError(
        "no record has two samples in a row at which all inputs are known");
  }
  for (const KnownPart& place : predictions.places) {
    predictions.parts.push_back(PartOf(records[place.record], place.range.first,
                                       place.range.samples()));
  }
  MLE_ASSIGN_OR_RETURN(predictions.predictor,
                       PredictAsIn(predictions.parts, response));
  predictions.model = std::move(model);
  predictions.records = std::move(records);
  return predictions;
}

// p × N of each record, NaN where nothing is predicted.
absl::StatusOr<std::vector<Eigen::MatrixXd>> PredictRecords(
    const ProcessModel& model, const std::vector<Record>& records,
    int horizon) {
  MLE_ASSIGN_OR_RETURN(const Predictions made, Prepare(model, records));
  std::vector<Eigen::MatrixXd> predicted;
  for (const Record& record : made.records) {
    predicted.push_back(Eigen::MatrixXd::Constant(record.num_outputs(),
                                                  record.samples(), kNaN));
  }
  for (std::size_t k = 0; k < made.parts.size(); ++k) {
    const KnownPart& place = made.places[k];
    predicted[place.record].middleCols(place.range.first,
                                       place.range.samples()) =
        made.parts[k].outputs - made.predictor(made.parts[k], horizon);
  }
  for (Eigen::MatrixXd& outputs : predicted) {
    Record engineering{.outputs = std::move(outputs)};
    Delinearise(model, engineering);
    outputs = std::move(engineering.outputs);
  }
  return predicted;
}

py::list Predict(const py::object& model, const std::vector<Record>& records,
                 int horizon) {
  if (horizon < 0) {
    throw py::value_error(absl::StrCat(
        "horizon = ", horizon,
        ": it must be a number of samples, or None for a simulation"));
  }
  const ProcessModel process = ProcessOf(model);
  const auto predicted = ValueOrThrow(RunLongFor<std::vector<Eigen::MatrixXd>>(
      [=](const ProgressCallback& /*report*/) {
        return PredictRecords(process, records, horizon);
      },
      py::none()));
  py::list arrays;
  for (const Eigen::MatrixXd& one : predicted) {
    arrays.append(CopyOf(Eigen::MatrixXd(one.transpose())));
  }
  return arrays;
}

// (lags (L,), autocorrelation (L,), limit, p-value, of each input: (lags (K,),
// correlations (K,), limit, p-value)).
py::tuple TupleOf(const ResidualReport& report) {
  py::list inputs;
  for (const InputCorrelation& input : report.inputs) {
    const double lag = input.max_lag;
    inputs.append(
        py::make_tuple(CopyOf(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(
                           input.values.size(), -lag, lag))),
                       CopyOf(input.values), input.limit, input.p_value));
  }
  const auto lags = static_cast<double>(report.autocorrelation.size());
  return py::make_tuple(CopyOf(Eigen::VectorXd(Eigen::VectorXd::LinSpaced(
                            report.autocorrelation.size(), 1.0, lags))),
                        CopyOf(report.autocorrelation), report.limit,
                        report.p_value, inputs);
}

// `max_lag` 0: as of a correction's diagnostics.
py::list Residuals(const py::object& model, const std::vector<Record>& records,
                   int max_lag) {
  if (max_lag < 0) {
    throw py::value_error(
        absl::StrCat("max_lag = ", max_lag, ": it must be at least 1"));
  }
  const ProcessModel process = ProcessOf(model);
  const auto reports = ValueOrThrow(RunLongFor<std::vector<ResidualReport>>(
      [=](const ProgressCallback& /*report*/)
          -> absl::StatusOr<std::vector<ResidualReport>> {
        MLE_ASSIGN_OR_RETURN(const Predictions made, Prepare(process, records));
        const int lags = max_lag > 0
                             ? max_lag
                             : ConversionSettings().OrderFor(
                                   process, records.front().sample_time);
        return ExamineResiduals(made.predictor, made.parts, lags);
      },
      py::none()));
  py::list tuples;
  for (const ResidualReport& report : reports) tuples.append(TupleOf(report));
  return tuples;
}

// From rest at zero inputs.
py::array Simulated(const py::object& model, const py::object& inputs,
                    double sample_time) {
  const ProcessModel process = ProcessOf(model);
  const Eigen::MatrixXd given = MatrixOf(SamplesOf(inputs, "U"), "U");
  if (given.rows() != process.num_inputs() || !given.allFinite()) {
    throw py::value_error(absl::StrCat(
        "U has ", given.rows(), " columns, the model ", process.num_inputs(),
        " inputs; there must be one for each, without NaN"));
  }
  ThrowUnlessOk(ValidateSampling(
      sample_time, sample_time * static_cast<double>(given.cols())));
  Eigen::MatrixXd from_rest(given.rows(), given.cols() + 1);
  from_rest << Eigen::VectorXd::Zero(given.rows()), given;
  const Eigen::MatrixXd outputs =
      ValueOrThrow(SimulateResponse(process, sample_time, from_rest));
  return CopyOf(Eigen::MatrixXd(outputs.rightCols(given.cols()).transpose()));
}

}  // namespace

void AddPrediction(py::module_& module) {
  module.def("_predict", &Predict);
  module.def("_residuals", &Residuals);
  module.def("_lsim", &Simulated);
}

}  // namespace mle::python
