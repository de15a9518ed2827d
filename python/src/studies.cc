// mle.study: mle_study's campaign on the threads of this process.

#include <memory>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/experiment/study.h"
#include "mle/base/status.h"
#include "pybind11/stl.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/result_files.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

struct StudyCall {
  experiment::Study work;
  std::string out;  // "": a folder that goes with the call
  bool resume = false;
  bool figures = true;
  int threads = 0;
  std::string text;  // as it may be typed again
};

const std::vector<std::string>& FilesOfStudy() {
  static const std::vector<std::string>& names = *new std::vector<std::string>{
      "campaign.json", "runs.csv",     "timings.csv",
      "summary.csv",   "summary.json", "report.html"};
  return names;
}

absl::StatusOr<ResultFiles> RunStudyCall(const StudyCall& call,
                                         const ProgressCallback& report) {
  MLE_ASSIGN_OR_RETURN(const ResultFolder out, ResultFolder::Make(call.out));
  const experiment::Work runs = experiment::WorkOf(call.work);
  MLE_ASSIGN_OR_RETURN(
      experiment::RunFolder folder,
      experiment::OpenFolder(call.work, runs, out.path(), Part(), call.resume));
  MLE_ASSIGN_OR_RETURN(const bool done, RunRemaining(runs, call.threads, "runs",
                                                     report, folder));
  if (!done) {
    return absl::CancelledError(absl::StrCat(
        "stopped after ", folder.num_done(), " of ", folder.runs(), " runs",
        call.out.empty() ? std::string()
                         : absl::StrCat(", which are kept in ", call.out,
                                        "; resume=True resumes from there")));
  }
  report::RunAgain again = HowToCallAgain(call.text, {}, {});
  MLE_RETURN_IF_ERROR(
      Conclude(call.work, folder, call.figures, again).status());
  return out.Read(FilesOfStudy());
}

py::dict RunStudy(const std::string& text, const std::string& source,
                  const std::string& folder, const std::string& out,
                  bool resume, bool figures, int threads,
                  const std::string& call_text, const py::object& progress) {
  const auto call = std::make_shared<StudyCall>();
  call->work = ValueOrThrow(experiment::ReadStudy(text, source, folder));
  call->out = out;
  call->resume = resume;
  call->figures = figures;
  call->threads = threads;
  call->text = call_text;
  return TextsOf(ValueOrThrow(RunLongFor<ResultFiles>(
      [call](const ProgressCallback& report) {
        return RunStudyCall(*call, report);
      },
      progress)));
}

}  // namespace

void AddStudies(py::module_& module) {
  module.def("_study", &RunStudy, py::arg("text"), py::arg("source"),
             py::arg("folder"), py::arg("out"), py::arg("resume"),
             py::arg("figures"), py::arg("threads"), py::arg("call"),
             py::arg("progress"));
}

}  // namespace mle::python
