#include "apps/correct/result_files.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/correct/figures.h"
#include "apps/correct/outputs.h"
#include "apps/correct/page.h"
#include "apps/correct/part_of_model.h"
#include "apps/report/drawing.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/exchange/mat_file.h"

namespace mle::correct {
namespace {

// Names that pictures may have and none of `files` has: there may be some of a
// former run.
std::vector<std::string> OtherPictures(
    const std::vector<std::pair<std::string, std::string>>& files) {
  std::vector<std::string> others;
  for (const std::string_view figure : kFigureNames) {
    for (const char* const extension : {".svg", ".png", ".pdf"}) {
      std::string name = std::string(figure).append(extension);
      const bool written =
          std::any_of(files.begin(), files.end(),
                      [&](const auto& file) { return file.first == name; });
      if (!written) others.push_back(std::move(name));
    }
  }
  return others;
}

}  // namespace

absl::Status WriteResult(const Result& result, const std::string& json,
                         const report::RunAgain& again) {
  std::vector<report::DrawnFigure> figures;
  if (result.request.figures) {
    figures = report::DrawFigures(MakeFigures(result), result.options.threads);
  }
  std::string page = FormatPage(result, figures, again);
  const ProcessModel& initial = result.initial;
  std::vector<std::pair<std::string, std::string>> files = {
      {"model.json", FormatProcessModel(result.model)},
      {"fopdt.json", FormatProcessModel(result.fopdt_model)},
      {"step_response.csv", FormatStepResponses(result)},
      {"report.html", std::move(page)},
      {"result.json", json}};
  const bool state_space = result.state_space.model.has_value();
  if (state_space) {
    files.emplace_back("state_space.json",
                       FormatStateSpace(*result.state_space.model));
  }
  const bool arx = result.corrected.has_arx();
  if (arx) {
    files.emplace_back("arx.json", FormatArx(result.corrected.arx, initial));
  }
  MLE_ASSIGN_OR_RETURN(std::string mat,
                       FormatMat(result.model, &result.corrected.response));
  files.emplace_back("model.mat", std::move(mat));
  const std::string given_name = CorrectedName(result.request.model_file);
  if (!given_name.empty()) {
    MLE_ASSIGN_OR_RETURN(
        FormattedModel as_given,
        FormatCorrected(result.request.model_file,
                        InWholeModel(result.request, result.model)));
    files.emplace_back(given_name, std::move(as_given.text));
  }
  report::AddPictures(figures, files);
  std::vector<std::string> obsolete = OtherPictures(files);
  // Those of a former run would be of another model.
  if (!arx) obsolete.emplace_back("arx.json");
  if (!state_space) obsolete.emplace_back("state_space.json");
  for (const char* name :
       {"model_corrected.csv", "model_corrected.json", "model_corrected.mat"}) {
    if (given_name != name) obsolete.emplace_back(name);
  }
  return WriteFilesTogether(result.request.out, files, obsolete);
}

}  // namespace mle::correct
