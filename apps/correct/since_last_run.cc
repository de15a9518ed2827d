#include "apps/correct/since_last_run.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/report/number.h"
#include "apps/report/table.h"

namespace mle::correct {
namespace {

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

}  // namespace

void AddSinceLastRun(const Result& result, report::HtmlPage& page) {
  const PreviousRun& last = *result.request.last;
  const ProcessModel& model = result.initial;
  report::Table table;
  table.caption = "Estimates that differ by more than both intervals";
  table.columns = {{"element", Align::kLeft},
                   {"value", Align::kLeft},
                   {"last run"},
                   {"now"}};
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

}  // namespace mle::correct
