#include "python/src/records.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/correct/request.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"
#include "mle/maintain/modes.h"
#include "pybind11/numpy.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/models.h"
#include "python/src/options.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

using Strided = py::array_t<double, 0>;

// (name, seconds or times (N), has dates, zone, [(name, values or what the
// column holds in place of numbers)]).
Table TableOf(const py::tuple& parts) {
  Table table;
  table.name = parts[0].cast<std::string>();
  const auto times = parts[1].cast<Array>();
  table.times = {times.data(), static_cast<std::size_t>(times.size())};
  table.has_dates = parts[2].cast<bool>();
  table.time_zone = parts[3].cast<std::string>();
  for (const py::handle column : parts[4]) {
    const auto pair = column.cast<py::tuple>();
    TableColumn& added = table.columns.emplace_back();
    added.name = pair[0].cast<std::string>();
    if (py::isinstance<py::str>(pair[1])) {
      added.holds = pair[1].cast<std::string>();
      continue;
    }
    const auto values = pair[1].cast<Strided>();
    if (values.ndim() != 1 || values.size() != times.size()) {
      throw py::value_error(absl::StrCat("column '", added.name,
                                         "' is not as long as the times"));
    }
    if (values.strides(0) % static_cast<py::ssize_t>(sizeof(double)) != 0) {
      throw py::value_error(absl::StrCat("column '", added.name,
                                         "' does not step in whole numbers"));
    }
    added.values = values.data();
    added.stride = values.strides(0) / static_cast<py::ssize_t>(sizeof(double));
  }
  return table;
}

Record MakeRecord(const py::object& outputs, const py::object& inputs,
                  const py::object& set_points, double sample_time,
                  double start_time) {
  Record record;
  record.sample_time = sample_time;
  record.start_time = start_time;
  record.outputs = MatrixOf(SamplesOf(outputs, "outputs"), "outputs");
  record.inputs = MatrixOf(SamplesOf(inputs, "inputs"), "inputs");
  if (!set_points.is_none()) {
    record.set_points =
        MatrixOf(SamplesOf(set_points, "set_points"), "set_points");
  }
  ThrowUnlessOk(record.Validate());
  return record;
}

py::object SetPointsOf(const py::object& self) {
  const auto& record = self.cast<const Record&>();
  if (record.set_points.size() == 0) return py::none();
  return ViewOf(record.set_points, self);
}

py::tuple Pickled(const Record& record) {
  const auto copied = [](const Eigen::MatrixXd& matrix) -> py::object {
    if (matrix.size() == 0) return py::none();
    return CopyOf(Eigen::MatrixXd(matrix.transpose()));
  };
  return py::make_tuple(copied(record.outputs), copied(record.inputs),
                        copied(record.set_points), record.sample_time,
                        record.start_time);
}

Record UnpickledRecord(const py::tuple& state) {
  return MakeRecord(state[0].cast<Array>(), state[1].cast<Array>(), state[2],
                    state[3].cast<double>(), state[4].cast<double>());
}

absl::StatusOr<HistorianImport> Import(const RecordSource& source,
                                       const ProcessModel& model,
                                       const HistorianOptions& options,
                                       const DatabaseOptions& database) {
  if (!source.records.empty()) {
    return HistorianImport{.records = source.records, .report = {}};
  }
  if (!source.tables.empty()) {
    return ImportTables(source.tables, model, options);
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<HistorianSource> sources,
                       RecordSources(source.paths, database, options));
  return ImportHistorianSources(sources, model, options);
}

// (records, seconds since 1970 at time 0 or None, time zone).
py::tuple ReadRecords(const py::tuple& from, const py::object& argument,
                      const OptionTexts& options) {
  const ProcessModel model = ProcessOf(argument);
  const RecordSource source = SourceOf(from);
  HistorianOptions import;
  DatabaseOptions database;
  std::vector<std::string> tags;
  std::string tag_file;
  OptionTable table;
  table.Add("Reading the records", correct::OptionsOf(import, tags, &tag_file));
  table.Add("Reading a database", correct::OptionsOf(database));
  SetOptions(options, table);
  ThrowUnlessOk(correct::ParseTags(tags, tag_file, model, import.columns));
  absl::StatusOr<HistorianImport> imported;
  {
    const py::gil_scoped_release release;
    imported = Import(source, model, import, database);
  }
  HistorianImport read = ValueOrThrow(std::move(imported));
  return py::make_tuple(std::move(read.records), read.report.time_origin,
                        read.report.time_zone);
}

py::list OptionsOfReading() {
  HistorianOptions import;
  DatabaseOptions database;
  std::vector<std::string> tags;
  std::string tag_file;
  OptionTable table;
  table.Add("", correct::OptionsOf(import, tags, &tag_file));
  table.Add("", correct::OptionsOf(database));
  return TextsOf(table);
}

}  // namespace

RecordSource SourceOf(const py::tuple& source) {
  RecordSource result;
  const auto kind = source[0].cast<std::string>();
  if (kind == "files") {
    result.paths = source[1].cast<std::vector<std::string>>();
  } else if (kind == "records") {
    result.records = source[1].cast<std::vector<Record>>();
  } else {
    for (const py::handle table : source[1]) {
      result.tables.push_back(TableOf(table.cast<py::tuple>()));
    }
    result.keep = std::shared_ptr<py::object>(
        new py::object(source), [](py::object* object) {
          const py::gil_scoped_acquire acquire;
          delete object;
        });
  }
  return result;
}

void AddRecords(py::module_& module) {
  py::class_<Record>(
      module, "Record",
      "A record sampled every `sample_time`: outputs (N, p), inputs (N, m), "
      "set_points (N, p) or None. Inputs act from their sample to the next; "
      "outputs are measured just before the inputs change. NaN marks a bad "
      "sample, as does a mask. Channels stand in the order of the process "
      "model, times are in its unit.")
      .def(py::init(&MakeRecord), py::arg("outputs"), py::arg("inputs"),
           py::arg("set_points") = py::none(), py::kw_only(),
           py::arg("sample_time"), py::arg("start_time") = 0.0,
           "Copies the arrays. Raises ValueError for shapes that do not agree.")
      .def_readonly("sample_time", &Record::sample_time)
      .def_readonly("start_time", &Record::start_time)
      .def_property_readonly(
          "outputs",
          [](const py::object& self) {
            return ViewOf(self.cast<const Record&>().outputs, self);
          },
          "(N, p), a read-only view.")
      .def_property_readonly(
          "inputs",
          [](const py::object& self) {
            return ViewOf(self.cast<const Record&>().inputs, self);
          },
          "(N, m), a read-only view.")
      .def_property_readonly("set_points", &SetPointsOf,
                             "(N, p), a read-only view, or None.")
      .def("__len__", &Record::samples)
      .def(py::pickle(&Pickled, &UnpickledRecord));
  module.def("_read_records", &ReadRecords);
  module.def("_read_options", &OptionsOfReading);
  module.def("_mode_code", [](const std::string& word) {
    return ValueOrThrow(ModeCode(word));
  });
}

}  // namespace mle::python
