// mle.lifecycle: mle_lifecycle's request, lives and results.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/report.h"
#include "apps/lifecycle/request.h"
#include "mle/base/status.h"
#include "pybind11/stl.h"
#include "python/src/bindings.h"
#include "python/src/long_call.h"
#include "python/src/models.h"
#include "python/src/options.h"
#include "python/src/result_files.h"
#include "python/src/status.h"

namespace mle::python {
namespace {

namespace py = pybind11;

const std::vector<std::string>& NotLifecycleKeywords() {
  static const std::vector<std::string>& names =
      *new std::vector<std::string>{"model", "plant", "ageing", "out", "part"};
  return names;
}

// The table points into the request, so that neither moves.
struct LifecycleCall {
  lifecycle::Request request;
  OptionTable table;
  std::string out;   // "": a folder that goes with the call
  std::string text;  // as it may be typed again

  LifecycleCall() { lifecycle::AddOptions(request, table); }
};

absl::StatusOr<ResultFiles> RunLifecycleCall(LifecycleCall& call,
                                             const ProgressCallback& report) {
  MLE_ASSIGN_OR_RETURN(const ResultFolder out, ResultFolder::Make(call.out));
  lifecycle::Campaign& campaign = call.request.campaign;
  campaign.folder = out.path();
  const experiment::Work work = lifecycle::WorkOf(campaign);
  MLE_ASSIGN_OR_RETURN(
      experiment::RunFolder folder,
      experiment::RunFolder::Open(work, campaign.folder, campaign.part,
                                  /*resume=*/true));
  MLE_ASSIGN_OR_RETURN(const bool done, RunRemaining(work, campaign.threads,
                                                     "lives", report, folder));
  if (!done) return absl::CancelledError("stopped");
  MLE_ASSIGN_OR_RETURN(lifecycle::Lives lives,
                       lifecycle::ReadLives(campaign, folder));
  const lifecycle::Results results =
      lifecycle::Evaluate(call.request, std::move(lives));
  NamesAndValues options = ShapingResults(call.table.Values());
  std::erase_if(options, [](const auto& option) {
    return option.first == "model" || option.first == "plant" ||
           option.first == "ageing";
  });
  MLE_RETURN_IF_ERROR(lifecycle::WriteResults(
      call.request, results,
      {call.text, options, HowToCallAgain(call.text, options, {})}));
  return out.Read({"result.json", "lifecycle.csv", "report.html"});
}

py::dict RunLifecycle(const py::object& model, const std::string& ageing,
                      const py::object& plant, const std::string& out,
                      const OptionTexts& options, const std::string& text,
                      const py::object& progress) {
  const auto call = std::make_shared<LifecycleCall>();
  call->out = out;
  call->text = text;
  lifecycle::GivenModels given;
  given.model = ProcessOf(model);
  if (!plant.is_none()) given.plant = ProcessOf(plant);
  given.ageing = ageing;
  call->request.given = std::move(given);
  SetOptions(options, call->table);
  ThrowUnlessOk(lifecycle::Complete(call->request, call->table));
  return TextsOf(ValueOrThrow(RunLongFor<ResultFiles>(
      [call](const ProgressCallback& report) {
        return RunLifecycleCall(*call, report);
      },
      progress)));
}

py::list OptionsOfLifecycle() {
  LifecycleCall call;
  return TextsOf(call.table, NotLifecycleKeywords());
}

}  // namespace

void AddLifecycles(py::module_& module) {
  module.def("_lifecycle", &RunLifecycle, py::arg("model"), py::arg("ageing"),
             py::arg("plant"), py::arg("out"), py::arg("options"),
             py::arg("text"), py::arg("progress"));
  module.def("_lifecycle_options", &OptionsOfLifecycle);
}

}  // namespace mle::python
