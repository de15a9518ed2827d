// The report of mle_correct on a result: advice, verdict, headline, tables,
// figures, the page and the files.

#ifndef APPS_CORRECT_REPORT_H_
#define APPS_CORRECT_REPORT_H_

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/correct/result.h"
#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/report/table.h"
#include "mle/model/process_model.h"

namespace mle::correct {

// Advice about a result: the controller's tuning, where more records are
// needed, and which inputs alone a step test would have to move.

std::string_view NameOf(PairState state);

// The controller's horizons, weights and stability; empty where nothing was
// corrected or its tuning was not told.
Tuning AdviseTuning(const Result& result);

// Items, most urgent first. `result` is complete but for advice.
std::vector<std::string> Advise(const Result& result);

// The result in sentences.

// Whether the initial value lies outside the estimate's interval.
bool HasMoved(const ParameterEstimate& estimate);

// Whether the proposed model has another element there than the initial one.
bool HasChanged(const Result& result, int output, int input);

// The reason of the decision to read first.
std::string MainReason(const Result& result);

// "8.5 min ahead": of the predictions over several samples.
std::string Ahead(const Result& result);

// The worth of the result: how well records that the fit had not seen are
// predicted or, without a correction, how small a change would have been seen.
// May be empty.
std::string WhatItIsWorth(const Result& result);

// Sentences on what to do and why: how sure and where; then what that is worth
// on records that the fit had not seen.
std::vector<std::string> DescribeVerdict(const Result& result);

// Grounds of the verdict: every change of an element, fits of every output, the
// distance to the truth where it is known.
std::vector<Finding> Findings(const Result& result);

// The result in a line for those who only read one: on the terminal, and at the
// top of the page.

// "Gain of TIC101 ← FC201 fell by 36 %": an element that is corrected.
struct ElementChange {
  int output = 0;
  int input = 0;
  double size = 0.0;  // of its step response, relative
  std::string text;
};

// Changes of the elements of the proposed model, the largest first; none where
// nothing was corrected.
std::vector<ElementChange> ElementChanges(const Result& result);

// The mistake of an operator for which nothing was estimated; null: none.
const Message* Mistake(const Result& result);

// One sentence on the model: the largest change and which others there are,
// that it is unchanged, that this cannot be told, or the configuration error to
// be corrected.
std::string Headline(const Result& result);

// The main reason where nothing is corrected, without what the headline says.
std::string ReasonBesideHeadline(const Result& result);

// Where a gain has turned its sign: what that may be. Otherwise empty.
std::string SignNote(const Result& result);

// One sentence on how to proceed with the controller's model.
std::string Instruction(const Result& result);

// Headline, instruction and the main reason: at most five lines, the first of
// which says what to do.
std::vector<std::string> ShortVerdict(const Result& result);

// The path of the page, and how many warnings there are.
std::string WhereTheRestIs(const Result& result);

// What the verdict rests on, the tables and the advice: --verbose, and
// summary() in Python.
std::string Details(const Result& result);

// The change of each element in a few words: for the table on the terminal, the
// page and its map.

// Lines such as "gain × 0.644", "dead time +2.92 min", "p < 10⁻⁹".
std::vector<std::string> DescribeMismatch(const Result& result, int output,
                                          int input);

// Whether a table has room for a column of each input.
bool FitsInColumns(const ProcessModel& model);

// The same, a cell for each pair, with how much of the step response changes;
// where that has no room, a row for each element.
report::Table MismatchTable(const Result& result);

// The same for readers who want no statistics: what has changed of each pair,
// the ground the darker the larger the change of the step response. Where that
// has no room, a row for each element that has changed or was to change, the
// largest change first.
report::Table ChangeMap(const Result& result);

// Below such rows, what is known of the elements that have none; empty where
// there is no such element, and below a map.
std::string WhatOthersShow(const Result& result);

// Below the map, why its cells are not estimated; empty where they are.
std::string WhyNotEstimated(const Result& result);

// Tables of what the records hold.

report::Table FileTable(const RecordData& data,
                        const std::vector<DataFile>& files,
                        const ProcessModel& model);
// A row for each channel over all records.
report::Table ChannelTable(const RecordData& data, const ProcessModel& model);
report::Table WindowTable(const RecordData& data, const ProcessModel& model);

// The unit of times in tables: the model's, the zone of dates, or "as recorded"
// where dates have no zone.
std::string TimeUnit(const RecordData& data, const ProcessModel& model);

// The tables of the console and the page.

// Gain, time constant and dead time of every element: as it was, as fitted
// with all elements free with its interval, as written.
report::Table ParameterTable(const Result& result);
// The corrected model as first-order elements with standard errors.
report::Table FopdtTable(const Result& result);
report::Table ValidationTable(const Result& result);
report::Table ResidualTable(const Result& result);
report::Table NoiseTable(const Result& result);
report::Table CertificateTable(const Result& result);

// The values that an engineer types into a controller: first-order elements of
// the model written, those that have changed with intervals if asked for, and
// what they were before.
report::Table ControllerTable(const Result& result, bool with_intervals);
// Where these differ from the responses of the model written by more than 2 %,
// and what to use then; empty: nowhere.
std::string WhereFirstOrderIsNotNear(const Result& result);
// Fits of both models, several steps ahead.
report::Table FitTable(const Result& result);

// The meaning of ± in all tables and sentences.
std::string IntervalNote(const Result& result);

// The filters of disturbances (mle/filter/output_filter.h).

// Those of the request, with the controller's period, horizon and gains where
// it is told.
FilterOptions FilterOptionsOf(const Request& request);
// What to give the controller; empty where no filter is better than the one in
// use.
std::string FilterAdvice(const Result& result);
// A row for each output, and how to read it; result.filters is not empty.
report::Table FilterTable(const Result& result);
std::string FilterNote(const Result& result);

// The next move (next_move.h).

// What to do first, what it costs, what is known then and when it may begin;
// or one sentence. Empty where it was not asked for.
std::vector<std::string> DescribeNextMove(const Result& result);
// A row for each value of the set points; there is a plan with steps.
report::Table NextMoveTable(const Result& result);

// The figures of the page, each also a file of its own.

// By their names:
//
//   step_responses     a panel for each pair that is not zero: the
//                      controller's model, the corrected one with its band,
//                      true where it is known
//   changed_responses  the same of the pairs that have changed most; only where
//                      something was corrected
//   curves             how gains follow positions and levels; only where the
//                      records showed it
//   control            a panel for each output: its set point followed with the
//                      initial and the corrected model in the controller
//   next_move          a panel for each channel: what is expected of the plan
//   mismatch_map       what has changed of each pair, and how surely
//   records            a panel for each channel: samples, bad ones, set points,
//                      the windows used
//   predictions        a panel for each output: measured, and simulated by both
//                      models in every window
//   loss_over_lambda   what the rule for λ minimises; only where ΔR was used
//   autocorrelation    a panel for each output, of the one-step errors
//   cross_correlation  a panel for each pair: errors against inputs over the
//   lag
std::vector<report::NamedFigure> MakeFigures(const Result& result);

// All names that a figure may have.
inline constexpr std::array<std::string_view, 11> kFigureNames = {
    "step_responses",   "changed_responses", "curves",           "control",
    "next_move",        "mismatch_map",      "records",          "predictions",
    "loss_over_lambda", "autocorrelation",   "cross_correlation"};

// report.html.

// Its sections on what the result means for the controller: predictions, loops
// and tuning; the filter of disturbances.
void AddControl(const Result& result,
                const std::vector<report::DrawnFigure>& figures,
                report::HtmlPage& page);
void AddFilter(const Result& result, report::HtmlPage& page);
// On the next move, where it was asked for (next_move_text.cc).
void AddNextMove(const Result& result,
                 const std::vector<report::DrawnFigure>& figures,
                 report::HtmlPage& page);

// With the figures of MakeFigures, drawn, or without any.
std::string FormatPage(const Result& result,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again);

// result.json, arx.json and step_response.csv (docs/formats.md).

// Half the width of an interval of the asked-for confidence, in standard
// errors.
double BandFactor(const Result& result);

// `flags`: every flag's name and value; `command` as it was given.
absl::StatusOr<std::string> FormatResult(
    const Result& result, const std::string& command,
    const std::vector<std::pair<std::string, std::string>>& flags);

std::string FormatArx(const ArxModel& model, const ProcessModel& channels);

std::string FormatStepResponses(const Result& result);

// Into request.out. All contents are made before the first file is written;
// what a former run has left there of another result is removed. `json` is the
// text of result.json; `again` is for the page.
absl::Status WriteResult(const Result& result, const std::string& json,
                         const report::RunAgain& again);

}  // namespace mle::correct

#endif  // APPS_CORRECT_REPORT_H_
