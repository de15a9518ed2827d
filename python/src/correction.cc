// mle.correct: mle_correct's request, run and results, from Python's arguments.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_join.h"
#include "apps/common/command_line.h"
#include "apps/common/sha256.h"
#include "apps/correct/data_sources.h"
#include "apps/correct/prospects.h"
#include "apps/correct/report.h"
#include "apps/correct/request.h"
#include "apps/correct/result.h"
#include "apps/report/drawing.h"
#include "apps/report/svg.h"
#include "mle/base/status.h"
#include "mle/exchange/mat_file.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/stage.h"
#include "mle/model/state_space_json.h"
#include "pybind11/stl.h"
#include "python/src/arrays.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/models.h"
#include "python/src/options.h"
#include "python/src/records.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

// The command's options that Python gives in another way, or that have no
// meaning here.
const std::vector<std::string>& NotCorrectKeywords() {
  static const std::vector<std::string>& names = *new std::vector<std::string>{
      "model",        "data",    "out",  "truth",  "dry_run",
      "propose_tags", "figures", "json", "verbose"};
  return names;
}

// One call. The table points into the request, so that neither moves.
struct CorrectCall {
  correct::Request request;
  OptionTable table;
  RecordSource source;
  std::string text;  // as it may be typed again

  CorrectCall() { correct::AddOptions(request, table); }
};

// A result and how it was asked for.
struct Correction {
  correct::Result result;
  std::string call;
  std::vector<std::pair<std::string, std::string>> options;
};

// Records without a file are told by the SHA-256 of their samples, time after
// time, as 64-bit numbers: outputs, set points, inputs.
correct::DataFile DescribeMemory(const std::string& name,
                                 const std::vector<Record>& records) {
  Sha256 hash;
  correct::DataFile file;
  file.path = name;
  for (const Record& record : records) {
    for (const Eigen::MatrixXd* const matrix :
         {&record.outputs, &record.set_points, &record.inputs}) {
      const auto bytes =
          static_cast<std::size_t>(matrix->size()) * sizeof(double);
      hash.Add({reinterpret_cast<const char*>(matrix->data()), bytes});
      file.bytes += static_cast<std::int64_t>(bytes);
    }
  }
  file.sha256 = hash.HexDigest();
  return file;
}

std::string NameOfTables(const std::vector<Table>& tables) {
  std::vector<std::string> names;
  for (const Table& table : tables) names.push_back(table.name);
  return absl::StrJoin(names, ", ");
}

absl::StatusOr<RecordData> Load(const CorrectCall& call,
                                const ProgressCallback& report,
                                std::vector<correct::DataFile>& files) {
  const correct::Request& request = call.request;
  const RecordSource& source = call.source;
  const RecordOptions& options = request.options.records;
  if (!source.paths.empty()) {
    MLE_ASSIGN_OR_RETURN(const correct::DataSources data,
                         correct::DataSources::Create(
                             source.paths, request.database, request.import));
    MLE_ASSIGN_OR_RETURN(RecordData loaded,
                         LoadSources(data.sources(), request.model,
                                     request.import, options, report));
    files = data.Files();
    return loaded;
  }
  if (source.tables.empty()) {
    files = {DescribeMemory("memory", source.records)};
    return PrepareRecords(source.records, request.model, options);
  }
  const auto import =
      [&](const ProcessModel& channels,
          const HistorianOptions& how) -> absl::StatusOr<HistorianImport> {
    MLE_ASSIGN_OR_RETURN(HistorianImport imported,
                         ImportTables(source.tables, channels, how));
    if (&channels == &request.model) {
      files = {DescribeMemory(NameOfTables(source.tables), imported.records)};
    }
    return imported;
  };
  return ImportAndPrepare(import, request.model, request.import, options);
}

absl::StatusOr<std::shared_ptr<const Correction>> CorrectRecords(
    CorrectCall& call, const ProgressCallback& report) {
  call.request.options.progress = report;
  auto correction = std::make_shared<Correction>();
  correction->call = call.text;
  correction->options = ShapingResults(call.table.Values());
  {
    const Stage reading(report, "reading the records");
    MLE_RETURN_IF_ERROR(reading.status());
  }
  std::vector<correct::DataFile> files;
  MLE_ASSIGN_OR_RETURN(RecordData data, Load(call, report, files));
  call.source = {};
  MLE_ASSIGN_OR_RETURN(
      correction->result,
      correct::RunCorrection(call.request, std::move(data), std::move(files)));
  // They refer to what lives as long as the call.
  correction->result.request.options.progress = nullptr;
  correction->result.options.progress = nullptr;
  return correction;
}

void PrepareCorrection(const py::object& model, const py::object& truth,
                       const OptionTexts& options, CorrectCall& call) {
  correct::Request& request = call.request;
  ModelArgument controller = ModelOf(model);
  OptionTexts texts = options;
  texts.emplace_back("model", controller.path);
  texts.emplace_back("data", absl::StrJoin(call.source.paths, ","));
  if (!truth.is_none()) {
    ModelArgument plant = ModelOf(truth);
    texts.emplace_back("truth", plant.path);
    ThrowUnlessOk(CheckSameChannels(controller.file.process, "model",
                                    plant.file.process, "truth"));
    request.truth = std::move(plant.file.process);
  }
  request.model_file = std::move(controller.file);
  request.model = request.model_file.process;
  SetOptions(texts, call.table);
  // Paths with commas in them too.
  request.data_paths = call.source.paths;
  ThrowUnlessOk(correct::CompleteForModel(request, call.table));
}

std::shared_ptr<const Correction> Correct(const py::object& model,
                                          const py::tuple& source,
                                          const OptionTexts& options,
                                          const py::object& truth,
                                          const std::string& text,
                                          const py::object& progress) {
  const auto call = std::make_shared<CorrectCall>();
  call->text = text;
  call->source = SourceOf(source);
  PrepareCorrection(model, truth, options, *call);
  return ValueOrThrow(RunLongFor<std::shared_ptr<const Correction>>(
      [call](const ProgressCallback& report) {
        return CorrectRecords(*call, report);
      },
      progress));
}

// What the records tell before anything is fitted.
struct Advice {
  ProcessModel model;
  std::string text;
  std::vector<Message> notes;
  std::vector<Message> warnings;
  absl::StatusOr<correct::Prospects> prospects;
};

absl::StatusOr<Advice> AdviseOn(const CorrectCall& call,
                                const ProgressCallback& report) {
  std::vector<correct::DataFile> files;
  MLE_ASSIGN_OR_RETURN(const RecordData data, Load(call, report, files));
  const ProcessModel& model = call.request.model;
  Advice advice = {.model = model,
                   .notes = data.notes,
                   .warnings = data.warnings,
                   .prospects = correct::FindProspects(
                       data, model, call.request.options.threads)};
  advice.text = correct::DescribeRecords(data, files, model, advice.prospects);
  return advice;
}

// A row for each element that is not zero: (output, input, state, errors of
// gain, time scale and dead time).
py::list RowsOf(const Advice& advice) {
  py::list rows;
  if (!advice.prospects.ok()) return rows;
  for (const auto& [i, j] : Pairs(advice.model)) {
    const PairErrors& pair = advice.prospects->information.pair(i, j);
    if (pair.state == PairState::kAbsent) continue;
    rows.append(py::make_tuple(advice.model.outputs()[i].name,
                               advice.model.inputs()[j].name,
                               std::string(correct::NameOf(pair.state)),
                               pair.gain, pair.time_scale, pair.delay));
  }
  return rows;
}

std::string JsonOfCorrection(const Correction& correction) {
  return ValueOrThrow(correct::FormatResult(correction.result, correction.call,
                                            correction.options));
}

std::string PageOf(const Correction& correction) {
  const correct::Result& result = correction.result;
  return correct::FormatPage(
      result,
      report::DrawFigures(correct::MakeFigures(result), result.options.threads),
      HowToCallAgain(correction.call, correction.options,
                     correct::Checksums(result)));
}

// The map of pairs and the responses that have changed, as SVG.
std::vector<std::string> PicturesOf(const Correction& correction) {
  std::vector<report::NamedFigure> chosen;
  for (report::NamedFigure& figure : correct::MakeFigures(correction.result)) {
    if (figure.name == "mismatch_map" || figure.name == "changed_responses") {
      chosen.push_back(std::move(figure));
    }
  }
  std::vector<std::string> pictures;
  for (const report::NamedFigure& figure : chosen) {
    if (absl::StatusOr<std::string> svg =
            report::SvgFile(figure.figure, figure.caption, figure.alt);
        svg.ok()) {
      pictures.push_back(*std::move(svg));
    }
  }
  return pictures;
}

// (time (N,), initial, corrected, lower or None, upper or None: (N, p, m)).
py::tuple ResponsesOf(const py::object& self) {
  const correct::Result& result = self.cast<const Correction&>().result;
  const StepResponse& initial = result.initial_response;
  const StepResponse& corrected = result.corrected.response;
  const Eigen::VectorXd times =
      Eigen::VectorXd::LinSpaced(initial.samples(), 0.0,
                                 initial.samples() - 1.0) *
      initial.sample_time;
  py::object lower = py::none();
  py::object upper = py::none();
  if (result.corrected.errors.has_value()) {
    const auto band = [&](double factor) {
      auto* const response = new StepResponse(corrected);
      response->values += factor * correct::BandFactor(result) *
                          result.corrected.errors->values;
      const py::capsule owner(response, [](void* pointer) {
        delete static_cast<StepResponse*>(pointer);
      });
      return ViewOf(*response, owner);
    };
    lower = band(-1.0);
    upper = band(1.0);
  }
  return py::make_tuple(CopyOf(times), ViewOf(initial, self),
                        ViewOf(corrected, self), lower, upper);
}

py::list MessagesOf(const std::vector<Message>& messages) {
  py::list list;
  for (const Message& message : messages) {
    list.append(py::make_tuple(std::string(NameOf(message.code)),
                               TextOf(message.place), TextOf(message.text),
                               message.options));
  }
  return list;
}

// (text, rows, whether inputs answer to each output, obstacle, warnings,
// notes).
py::tuple Advise(const py::object& model, const py::tuple& source,
                 const OptionTexts& options) {
  const auto call = std::make_shared<CorrectCall>();
  call->source = SourceOf(source);
  PrepareCorrection(model, py::none(), options, *call);
  const Advice advice = ValueOrThrow(RunLongFor<Advice>(
      [call](const ProgressCallback& report) {
        return AdviseOn(*call, report);
      },
      py::none()));
  return py::make_tuple(
      TextOf(WithoutDashes(advice.text)), RowsOf(advice),
      advice.prospects.ok() ? advice.prospects->feedback : std::vector<bool>(),
      TextOf(WithoutDashes(std::string(advice.prospects.status().message()))),
      MessagesOf(advice.warnings), MessagesOf(advice.notes));
}

// Names and texts of the models that a result may have.
py::dict ModelFilesOf(const Correction& correction) {
  const correct::Result& result = correction.result;
  py::dict files;
  files["model.json"] = FormatProcessModel(result.model);
  files["fopdt.json"] = FormatProcessModel(result.fopdt_model);
  files["model.mat"] = py::bytes(
      ValueOrThrow(FormatMat(result.model, &result.corrected.response)));
  const ModelFile& given = result.request.model_file;
  if (const std::string name = CorrectedName(given); !name.empty()) {
    const std::string text =
        ValueOrThrow(FormatCorrected(given, result.model)).text;
    if (given.type == ModelFileType::kMat) {
      files[py::str(name)] = py::bytes(text);
    } else {
      files[py::str(name)] = text;
    }
  }
  if (result.state_space.model.has_value()) {
    files["state_space.json"] = FormatStateSpace(*result.state_space.model);
  }
  if (result.corrected.has_arx()) {
    files["arx.json"] =
        correct::FormatArx(result.corrected.arx, result.initial);
  }
  files["step_response.csv"] = correct::FormatStepResponses(result);
  return files;
}

// The corrected model in the form that was given, if that was step responses or
// a state space; else None.
py::object CorrectedAsGiven(const Correction& correction) {
  const correct::Result& result = correction.result;
  const ModelFile& given = result.request.model_file;
  if (given.form == ModelForm::kStateSpace) {
    return py::cast(ValueOrThrow(CorrectedStateSpace(given, result.model)));
  }
  if (given.form != ModelForm::kStepResponses) return py::none();
  ModelFile corrected = given;
  corrected.step_responses = CorrectedStepResponses(given, result.model);
  corrected.process = result.model;
  corrected.type = ModelFileType::kJson;
  return py::cast(std::move(corrected));
}

py::list OptionsOfCorrect() {
  CorrectCall call;
  return TextsOf(call.table, NotCorrectKeywords());
}

}  // namespace

void AddCorrection(py::module_& module) {
  py::class_<Correction, std::shared_ptr<Correction>>(module, "_Correction")
      .def("json", &JsonOfCorrection)
      .def("page", &PageOf, py::call_guard<py::gil_scoped_release>())
      .def("responses", &ResponsesOf)
      .def(
          "short_verdict",
          [](const Correction& c) {
            return TextOf(absl::StrJoin(correct::ShortVerdict(c.result), "\n"));
          })
      .def("details",
           [](const Correction& c) {
             return TextOf(WithoutDashes(correct::Details(c.result)));
           })
      .def("figures", &PicturesOf, py::call_guard<py::gil_scoped_release>())
      .def("model_files", &ModelFilesOf)
      .def("corrected_as_given", &CorrectedAsGiven)
      .def_property_readonly(
          "initial", [](const Correction& c) { return c.result.initial; })
      .def_property_readonly(
          "usable", [](const Correction& c) { return c.result.usable(); })
      .def_property_readonly(
          "reasons",
          [](const Correction& c) { return MessagesOf(c.result.reasons); })
      .def_property_readonly(
          "notes",
          [](const Correction& c) { return MessagesOf(c.result.notes); })
      .def_property_readonly(
          "warnings",
          [](const Correction& c) { return MessagesOf(c.result.warnings); })
      .def_property_readonly("failures", [](const Correction& c) {
        return MessagesOf(c.result.failures);
      });
  module.def("_correct", &Correct, py::arg("model"), py::arg("source"),
             py::arg("options"), py::arg("truth"), py::arg("text"),
             py::arg("progress"));
  module.def("_correct_options", &OptionsOfCorrect);
  module.def("_advice", &Advise);
}

}  // namespace mle::python
