#include "apps/correct/page.h"

#include "absl/strings/str_cat.h"
#include "apps/correct/mismatch_map.h"
#include "apps/correct/record_tables.h"
#include "apps/correct/tables.h"
#include "apps/report/number.h"

namespace mle::correct {
namespace {

using report::DrawnFigure;
using report::HtmlPage;

using Figures = std::vector<DrawnFigure>;

void AddModel(const Result& result, const Figures& figures, HtmlPage& page) {
  page.AddHeading("The model");
  AddFigure(figures, "step_responses", page);
  AddFigure(figures, "mismatch_map", page);
  if (figures.empty()) page.AddTable(MismatchTable(result));
  page.AddParagraph(
      "“Weak”: from these records the gain would have a standard error above "
      "10 %, “not informed”: above 50 %. Such elements keep the initial model "
      "unless the records prove a change.");
  page.AddTable(ParameterTable(result));
  page.AddTable(FopdtTable(result));
  if (!result.corrected.process.has_value()) {
    page.AddParagraph(
        "The model is an ARX model here; its standard errors are not known. "
        "Those given say how well a first-order element describes its step "
        "response.");
  }
}

void AddRecords(const Result& result, const Figures& figures, HtmlPage& page) {
  page.AddHeading("The records");
  page.AddTable(FileTable(result.data, result.files, result.initial));
  page.AddTable(ChannelTable(result.data, result.initial));
  page.AddTable(WindowTable(result.data, result.initial));
  std::vector<std::string> notes;
  for (const Message& note : result.notes) notes.push_back(Shown(note));
  if (!notes.empty()) page.AddList(notes);
  AddFigure(figures, "records", page);
}

void AddTrust(const Result& result, const Figures& figures, HtmlPage& page) {
  page.AddHeading("Can it be trusted?");
  const Validation& validation = result.validation;
  if (validation.shown() != nullptr || !validation.initial.empty()) {
    page.AddTable(ValidationTable(result));
  }
  if (validation.windows.has_value() && validation.windows->available()) {
    page.AddParagraph(
        "Each window in turn was held out: the elements found to have aged "
        "were fitted to the others, and predict what that fit had not seen.");
  }
  if (validation.blocks.has_value() && validation.blocks->available()) {
    page.AddParagraph(absl::StrCat(
        "Ten blocks of every window, two at a time, were hidden from the fit "
        "as well: there the correction changes the log-likelihood of what it "
        "had not seen by ",
        report::FormatSignificant(validation.blocks->gain),
        ". Below zero it would be refused."));
  }
  AddFigure(figures, "predictions", page);
  AddFigure(figures, "loss_over_lambda", page);
  page.AddSubheading("Residuals");
  page.AddTable(ResidualTable(result));
  page.AddParagraph(
      "A p-value below 0.01 is a finding, one test in a hundred has one by "
      "chance. Errors that are not white hold slow "
      "disturbances or missing dynamics; errors that follow an input after it "
      "moved, missing dynamics. Quantised or filtered measurements are not "
      "white either.");
  AddFigure(figures, "autocorrelation", page);
  AddFigure(figures, "cross_correlation", page);
  page.AddTable(NoiseTable(result));
}

}  // namespace

std::string FormatPage(const Result& result, const Figures& figures,
                       const report::RunAgain& run_again) {
  HtmlPage page(absl::StrCat("Model correction: ", result.initial.name()));
  page.AddSummary(result.verdict);
  for (const Message& failure : result.failures) {
    page.AddWarning(absl::StrCat("The result is not usable: ", Shown(failure)));
  }
  for (const Message& warning : result.warnings)
    page.AddWarning(Shown(warning));
  page.AddList(Sentences(result.findings));
  page.AddHeading("What to do");
  page.AddList(result.advice);
  if (!result.tuning.heading.empty()) {
    page.AddParagraph(result.tuning.heading);
    page.AddList(result.tuning.reasons);
  }
  AddModel(result, figures, page);
  AddRecords(result, figures, page);
  AddTrust(result, figures, page);
  page.AddHeading("Certificate");
  page.AddTable(CertificateTable(result));
  page.AddParagraph(absl::StrCat(
      "Relative duality gap of every lasso fit used: at most ",
      report::FormatScientific(result.corrected.max_relative_gap, 2), "."));
  page.AddHeading("Files");
  page.AddFiles({{"result.json", "result.json"},
                 {"fopdt.json", "fopdt.json"},
                 {"arx.json", "arx.json"},
                 {"step_response.csv", "step_response.csv"}});
  page.AddRunAgain(run_again);
  return page.Render();
}

}  // namespace mle::correct
