#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "apps/correct/report.h"
#include "apps/report/table.h"
#include "apps/report/text.h"

namespace mle::correct {
namespace {

// The result compared with that of an earlier run, for the page.

using report::Align;
using report::FormatSignificant;

template <typename Channels>
int NumberOf(const Channels& channels, const std::string& name) {
  int number = 0;
  while (channels[number].name != name) ++number;
  return number;
}

const ParameterEstimate& ParameterOf(const ElementEstimate& element,
                                     const std::string& name) {
  if (name == "gain") return element.gain;
  return name == "delay" ? element.delay : element.time_scale;
}

std::string Spelled(const std::string& name) {
  if (name == "delay") return "dead time";
  return absl::StrReplaceAll(name, {{"_", " "}});
}

std::string WithLimits(double value, double lower, double upper) {
  return absl::StrCat(FormatSignificant(value, 4), " ± ",
                      FormatSignificant(0.5 * (upper - lower), 2));
}

// Adds the decision of the last run, and the parameters whose intervals then
// and now do not overlap. result.request.last must be there.
void AddSinceLastRun(const Result& result, report::HtmlPage& page) {
  const PreviousRun& last = *result.request.last;
  const ProcessModel& model = result.initial;
  report::Table table{
      .caption = "Estimates that differ by more than both intervals",
      .columns = {{"element", Align::kLeft},
                  {"value", Align::kLeft},
                  {"last run"},
                  {"now"}}};
  for (const PreviousEstimate& then : last.estimates) {
    const int output = NumberOf(model.outputs(), then.output);
    const int input = NumberOf(model.inputs(), then.input);
    const ElementEstimate& element =
        result.estimate.fit.output_error.full.element(output, input);
    if (element.state != ElementState::kFitted) continue;
    const ParameterEstimate& now = ParameterOf(element, then.name);
    if (now.lower <= then.upper && then.lower <= now.upper) continue;
    table.AddRow({PairName(model, output, input), Spelled(then.name),
                  WithLimits(then.value, then.lower, then.upper),
                  WithLimits(now.value, now.lower, now.upper)});
  }
  page.AddSubheading("Since the last run");
  page.AddParagraph(absl::StrCat(
      "The last run", last.until.empty() ? "" : " (records until ", last.until,
      last.until.empty() ? "" : ")", " said “",
      absl::StrReplaceAll(last.decision, {{"_", " "}}), "”. ",
      table.rows.empty()
          ? "No estimate differs from it by more than both intervals."
          : ""));
  if (!table.rows.empty()) page.AddTable(table);
}

using report::DrawnFigure;
using report::HtmlPage;

using Figures = std::vector<DrawnFigure>;

// Tables with more rows are folded.
constexpr std::size_t kMostOpenRows = 8;
// A figure with a panel for each of more outputs is folded.
constexpr int kMostOpenOutputs = 3;

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

// Badge and headline.
report::Verdict OpeningOf(const Result& result) {
  using report::Badge;
  const std::string headline = Headline(result);
  if (!result.usable()) return {Badge::kUnknown, "not usable", headline, {}};
  switch (result.decision) {
    case Decision::kNoChange:
      return {Badge::kGood, "unchanged", headline, {}};
    case Decision::kCorrected:
      return {Badge::kChanged, "corrected", headline, {}};
    case Decision::kCannotTell:
      break;
  }
  return {Badge::kUnknown, "cannot tell", headline, {}};
}

void SetVerdict(const Result& result, HtmlPage& page) {
  report::Verdict verdict = OpeningOf(result);
  verdict.sentences = {
      Instruction(result), ReasonBesideHeadline(result), SignNote(result),
      WhatItIsWorth(result),
      absl::StrCat(WhenMade(result), " ", IntervalNote(result))};
  std::erase(verdict.sentences, "");
  page.SetVerdict(std::move(verdict));
}

void AddWarnings(const Result& result, HtmlPage& page) {
  for (const Message& failure : result.failures) {
    page.AddWarning(absl::StrCat("The result is not usable: ", Shown(failure)));
  }
  page.AddWarnings(ShownTogether(result.warnings));
}

const char* HeadingOfChanges(const Result& result) {
  switch (result.decision) {
    case Decision::kNoChange:
      return "Nothing has changed";
    case Decision::kCorrected:
      return "What has changed";
    case Decision::kCannotTell:
      break;
  }
  return "What the records show";
}

void AddChanges(const Result& result, const Figures& figures, HtmlPage& page) {
  page.AddHeading(HeadingOfChanges(result));
  if (const report::Table changes = ChangeMap(result); !changes.rows.empty()) {
    page.AddTable(changes);
  }
  page.AddParagraph(WhatOthersShow(result));
  page.AddParagraph(WhyNotEstimated(result));
  if (result.request.last.has_value()) AddSinceLastRun(result, page);
  const bool many = result.initial.num_outputs() > kMostOpenOutputs;
  if (many) page.OpenFold("Measured and simulated outputs");
  AddFigure(figures, "predictions", page);
  if (many) page.CloseFold();
  AddFigure(figures, "curves", page);
  AddFigure(figures, "changed_responses", page);
  if (HasFigure(figures, "step_responses")) {
    page.OpenFold("Step responses of all pairs");
    AddFigure(figures, "step_responses", page);
    page.CloseFold();
  }
}

std::vector<std::pair<std::string, std::string>> FilesOf(const Result& result) {
  std::vector<std::pair<std::string, std::string>> files = {
      {"model.json: the transfer functions", "model.json"},
      {"fopdt.json: first-order elements with dead time", "fopdt.json"},
      {"model.mat: the transfer functions for MATLAB and Octave", "model.mat"},
      {"step_response.csv: step responses", "step_response.csv"},
      {"result.json: every number of this page", "result.json"}};
  if (const std::string name = CorrectedName(result.request.model_file);
      !name.empty()) {
    files.emplace(files.begin(),
                  absl::StrCat(name, ": the model as it was given, corrected"),
                  name);
  }
  if (result.corrected.has_arx()) {
    files.emplace_back("arx.json: the ARX model", "arx.json");
  }
  if (result.state_space.model.has_value()) {
    files.emplace_back("state_space.json: the discrete state-space model",
                       "state_space.json");
  }
  return files;
}

// Where gains hold, and how they follow the channels that have transforms.
std::string TransformNote(const Result& result) {
  std::vector<std::string> transforms;
  std::string at;
  const auto add = [&](const auto& channels) {
    for (const auto& channel : channels) {
      if (channel.transform.IsNone()) continue;
      transforms.push_back(
          absl::StrCat(channel.name, " (", channel.transform.Description(),
                       ", 1 at ", FormatSignificant(channel.transform.at, 4),
                       channel.unit == "-" ? "" : " ",
                       channel.unit == "-" ? "" : channel.unit, ")"));
      if (at.empty()) at = channel.name;
    }
  };
  add(result.model.inputs());
  add(result.model.outputs());
  if (transforms.empty()) return "";
  return absl::StrCat(
      "Gains follow the transforms of ", absl::StrJoin(transforms, ", "),
      "; model.json has them, for a controller that has transforms. For one "
      "that has none, ",
      report::QuoteCommandLine({"mle_convert", "--model=model.json",
                                absl::StrCat("--at=", at, ":VALUE"),
                                "--out=linear.json"}),
      " gives the linear model where it is to work.");
}

void AddForTheController(const Result& result, HtmlPage& page) {
  if (!result.accepted()) {
    page.OpenFold("The model as first-order elements, and files");
  } else {
    page.AddHeading("What to type into the controller");
  }
  page.AddTableToCopy(ControllerTable(result, true),
                      ControllerTable(result, false));
  page.AddParagraph(TransformNote(result));
  page.AddParagraph(WhereFirstOrderIsNotNear(result));
  if (result.accepted()) page.OpenFold("The same as files");
  page.AddFiles(FilesOf(result));
  page.CloseFold();
}

// "--leave_out='2024-03-04 09:20' leaves out window 1."
std::string HowToLeaveOut(const Result& result) {
  const std::vector<SetPointWindow>& windows = result.data.windows;
  if (windows.size() < 2) return "";
  const SetPointWindow& first = windows.front();
  const double time = first.changes.empty()
                          ? BeginOf(first)
                          : first.record.time(first.changes.front().sample);
  return absl::StrCat(
      "To leave a window out, add --leave_out with a time in it to the "
      "command; several are separated by commas. ",
      report::QuoteCommandLine({absl::StrCat(
          "--leave_out=", result.data.Times(result.initial).Short(time))}),
      " leaves out window 1.");
}

void AddRecords(const Result& result, const Figures& figures, HtmlPage& page) {
  page.AddHeading("Which records were used");
  const bool many = result.data.windows.size() > kMostOpenRows;
  if (many) {
    page.OpenFold(absl::StrCat(result.data.windows.size(),
                               " windows around set-point changes"));
  }
  page.AddTable(WindowTable(result.data, result.initial));
  if (many) page.CloseFold();
  page.AddParagraph(HowToLeaveOut(result));
  page.OpenFold("Files, channels and what was found in them");
  page.AddTable(FileTable(result.data, result.files, result.initial));
  page.AddTable(ChannelTable(result.data, result.initial));
  if (!result.notes.empty()) page.AddList(ShownTogether(result.notes));
  AddFigure(figures, "records", page);
  page.CloseFold();
}

void AddElements(const Result& result, HtmlPage& page) {
  page.OpenFold("Every element with its interval");
  report::Table elements = ParameterTable(result);
  elements.searchable = !FitsInColumns(result.initial);
  page.AddTable(elements);
  page.AddParagraph(
      "“Weak”: the expected standard error of the gain is above 10 %, “not "
      "informed”: above 50 %. Such elements keep the controller's model unless "
      "a change is significant.");
  page.AddTable(FopdtTable(result));
  if (!result.corrected.process.has_value()) {
    page.AddParagraph(
        "The model is an ARX model; its standard errors are not known. The "
        "intervals given are those of the first-order fit to its step "
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
  page.CloseFold();
}

void AddValidation(const Result& result, const Figures& figures,
                   HtmlPage& page) {
  page.OpenFold("Validation in full");
  page.AddTable(ValidationTable(result));
  if (result.validation.held_out) {
    page.AddParagraph(
        "Each part in turn was held out: a correction estimated anew from the "
        "others, with its own choice of elements, noise and penalty, predicts "
        "it. The gain is the share of the squared error that the correction "
        "removes. A correction is used where no score falls and at least one "
        "gains by more than chance.");
  }
  AddFigure(figures, "loss_over_lambda", page);
  page.CloseFold();
  page.OpenFold("Residuals and disturbances");
  page.AddTable(ResidualTable(result));
  page.AddParagraph(
      "A p-value below 0.01 is significant; one test in a hundred is so by "
      "chance. Residuals that are not white indicate slow disturbances or "
      "missing dynamics; residuals correlated with past inputs, missing "
      "dynamics. Quantised or filtered measurements are not white either.");
  AddFigure(figures, "autocorrelation", page);
  AddFigure(figures, "cross_correlation", page);
  page.AddTable(NoiseTable(result));
  page.CloseFold();
}

void AddTrust(const Result& result, const Figures& figures, HtmlPage& page) {
  page.AddHeading("How far it can be trusted");
  page.AddTable(FitTable(result));
  // The first says what to do, which the page has said, as the main reason.
  std::vector<std::string> advice = result.advice;
  if (!advice.empty()) advice.erase(advice.begin());
  std::erase(advice, MainReason(result));
  std::erase(advice, FilterAdvice(result));
  if (!advice.empty()) page.AddList(advice);
  page.OpenFold("What the verdict rests on");
  page.AddList(result.verdict);
  page.AddList(Sentences(result.findings));
  page.CloseFold();
  AddElements(result, page);
  AddValidation(result, figures, page);
  page.OpenFold("Certificate of the fits");
  page.AddTable(CertificateTable(result));
  page.AddParagraph(absl::StrCat(
      "Relative duality gap of every lasso fit used: at most ",
      report::FormatScientific(result.corrected.max_relative_gap, 2), "."));
  page.CloseFold();
}

}  // namespace

std::string FormatPage(const Result& result, const Figures& figures,
                       const report::RunAgain& run_again) {
  HtmlPage page(absl::StrCat("Model correction: ", result.initial.name()));
  SetVerdict(result, page);
  AddWarnings(result, page);
  AddChanges(result, figures, page);
  AddNextMove(result, figures, page);
  if (result.accepted()) AddForTheController(result, page);
  AddControl(result, figures, page);
  AddFilter(result, page);
  AddRecords(result, figures, page);
  AddTrust(result, figures, page);
  if (!result.accepted()) AddForTheController(result, page);
  page.AddLastFolds({}, run_again);
  return page.Render();
}

}  // namespace mle::correct
