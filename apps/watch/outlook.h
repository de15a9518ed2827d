// The outlook of a watch on the months to come, computed from its state: the
// course of each output's ageing (ageing_course.h in mle/monitor), and the
// change of a set point that would tell most where evidence is short
// (next_change.h).

#ifndef APPS_WATCH_OUTLOOK_H_
#define APPS_WATCH_OUTLOOK_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/model/process_model.h"
#include "mle/monitor/ageing_course.h"
#include "mle/monitor/next_change.h"

namespace mle::watch {

// The course of one output's ageing. All its values are relative changes of a
// gain or of a time constant, or changes of a dead time in the model's time
// unit.
struct OutputTrend {
  AgeingCourse course;
  int input = 0;  // of the most probable element
};

// The element in question by number of its input; changes as in OutputTrend.
struct ProposedChange {
  NextChange next;
  int input = 0;
};

struct Outlook {
  std::vector<OutputTrend> trends;     // p; empty until there is a reference
  std::optional<ProposedChange> next;  // nothing until there is a reference
};

// Some milliseconds for each output.
Outlook MakeOutlook(const Controller& controller, const ProcessModel& model,
                    const Watch& watch);

// "trend", "steady", "cannot_tell".
std::string_view NameOf(AgeingCourse::State state);
// "proposed", "not_needed", "none_tells".
std::string_view NameOf(NextChange::State state);

// "−1.9 % a month", of the output's most probable parameter.
std::string RateText(const ProcessModel& model, const OutputTrend& trend);
// A sentence: by how much the output's most probable parameter has changed.
// Empty where a single one is not known.
std::string ChangedText(const ProcessModel& model, int output,
                        const OutputTrend& trend);
// Whole sentences: the trend, or why none can be told.
std::string TrendText(const ProcessModel& model, int output,
                      const OutputTrend& trend);
// Sentences that propose a change of a set point, with its purpose and the
// evidence expected of it; or say why none is proposed.
std::string NextChangeText(const ProcessModel& model,
                           const ProposedChange& proposed);

// Parameters of an element: 0 its gain, 1 its time constant, and this.
inline constexpr int kDeadTime = 2;

// "gain", "time constant", "dead time"; with underscores for programs.
const char* ParameterName(int parameter);
const char* ParameterKey(int parameter);

// "+0.42", "−1.90".
std::string Signed(double value, int decimals);

}  // namespace mle::watch

#endif  // APPS_WATCH_OUTLOOK_H_
