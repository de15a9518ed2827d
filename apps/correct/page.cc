#include "apps/correct/page.h"

#include <cstdint>
#include <cstdlib>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
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
      "“Weak”: the expected standard error of the gain is above 10 %, “not "
      "informed”: above 50 %. Such elements keep the initial model unless a "
      "change is significant.");
  page.AddTable(ParameterTable(result));
  page.AddTable(FopdtTable(result));
  if (!result.corrected.process.has_value()) {
    page.AddParagraph(
        "The model is an ARX model; its standard errors are not known. The "
        "standard errors given are those of the first-order fit to its step "
        "response.");
  }
  if (result.state_space.model.has_value()) {
    const StateSpaceForm& form = result.state_space;
    page.AddParagraph(absl::StrCat(
        "As a discrete state-space model (state_space.json) it has ",
        form.model->system.order(),
        " states beside dead times of inputs and outputs. No element is off by "
        "more than ",
        report::FormatSignificant(100.0 * form.error_bound(), 2),
        " % of its largest step response at any frequency; the step responses "
        "differ by at most ",
        report::FormatSignificant(100.0 * form.largest_difference(), 2),
        " %."));
  }
}

// The time of the report, or SOURCE_DATE_EPOCH (seconds since 1970) where the
// same bytes are wanted again (reproducible-builds.org); and what it is about.
std::string WhenMade(const Result& result) {
  std::int64_t seconds = 0;
  const char* const given = std::getenv("SOURCE_DATE_EPOCH");
  if (given == nullptr || !absl::SimpleAtoi(given, &seconds)) {
    seconds = absl::ToUnixSeconds(absl::Now());
  }
  std::string text =
      absl::FormatTime("Made on %Y-%m-%d at %H:%M UTC",
                       absl::FromUnixSeconds(seconds), absl::UTCTimeZone());
  const TimeNames times = result.data.Times(result.initial);
  if (times.has_dates() && !result.data.records.empty()) {
    const Record& last = result.data.records.back();
    absl::StrAppend(&text, " from records of ",
                    times.Span(result.data.records.front().start_time,
                               last.time(last.samples() - 1)),
                    " (", TimeUnit(result.data, result.initial), ")");
  }
  return text + ".";
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
  page.AddHeading("Validation");
  page.AddTable(ValidationTable(result));
  if (result.validation.held_out) {
    page.AddParagraph(
        "Each part in turn was held out: a correction estimated anew from the "
        "others, with its own choice of elements, noise and penalty, predicts "
        "it. The gain is the share of the squared error that the correction "
        "removes, with its standard error. A correction is used where no score "
        "falls and at least one gains by more than chance.");
  }
  AddFigure(figures, "predictions", page);
  AddFigure(figures, "loss_over_lambda", page);
  page.AddSubheading("Residuals");
  page.AddTable(ResidualTable(result));
  page.AddParagraph(
      "A p-value below 0.01 is significant; one test in a hundred is so by "
      "chance. Residuals that are not white indicate slow disturbances or "
      "missing dynamics; residuals correlated with past inputs, missing "
      "dynamics. Quantised or filtered measurements are not white either.");
  AddFigure(figures, "autocorrelation", page);
  AddFigure(figures, "cross_correlation", page);
  page.AddTable(NoiseTable(result));
}

}  // namespace

std::string FormatPage(const Result& result, const Figures& figures,
                       const report::RunAgain& run_again) {
  HtmlPage page(absl::StrCat("Model correction: ", result.initial.name()));
  page.AddSummary(result.verdict);
  page.AddParagraph(WhenMade(result));
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
  std::vector<std::pair<std::string, std::string>> files = {
      {"result.json", "result.json"},
      {"model.json", "model.json"},
      {"fopdt.json", "fopdt.json"},
      {"step_response.csv", "step_response.csv"}};
  if (result.corrected.has_arx()) files.emplace_back("arx.json", "arx.json");
  if (result.state_space.model.has_value()) {
    files.emplace_back("state_space.json", "state_space.json");
  }
  page.AddFiles(files);
  page.AddRunAgain(run_again);
  return page.Render();
}

}  // namespace mle::correct
