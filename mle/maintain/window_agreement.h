// Whether the windows of a record want the same gains, and if not, what the
// differences follow.
//
// With c_w the responses of a model's elements in window w (whitened_fit.h),
// one output is
//
//   y_w = c_w g_w + noise,   g_w = g             all windows alike
//                            g_w = g + α τ_w     they follow time
//                            g_w = g + Σ_o β_o x_ow   the operating point
//                            g_w free,
//
// τ_w the time of the window, x_ow the mean of output o in it (all outputs with
// p + 3 windows, else the output itself). Windows are first joined to the next
// ones of their stretch until they are five times as long as the model's
// longest dead time and lag, and 1.5 times for each element of its fullest row:
// in shorter ones the inputs are mostly what a controller makes of noise that
// is not forgotten, and gains of their own are biased by it. The noise is a
// random walk in white noise, of the ratio that is likeliest
// (innovations_filter.h; beginning with common gains), and an autoregression of
// what that leaves (whitened_fit.h). The windows disagree where free gains are
// better than common ones by an F test at 1e-6 and differ by 5 % of a response,
// less what noise makes of the difference. What the differences follow is told
// from four windows on, where it explains half of them and is better than the
// other by 10 nats less half the logarithm of the samples for each of its
// parameters (BIC).
//
// A plant that has changed its gains in between follows time; one that is not
// linear, or a valve, the operating point. One that has moved steadily with
// time is not told from one that has aged.

#ifndef MLE_MAINTAIN_WINDOW_AGREEMENT_H_
#define MLE_MAINTAIN_WINDOW_AGREEMENT_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

struct WindowAgreement {
  enum class Cause { kUnknown, kTime, kOperatingPoint };

  int windows = 0;
  double p_value = 1.0;
  // The largest, relative to the response: less what noise makes of it, and as
  // it is, which it may be.
  double difference = 0.0;
  double possible = 0.0;
  Cause cause = Cause::kUnknown;

  bool agree() const;
  // "The gains of level differ from window to window by 12 %: …"
  std::string Describe(const std::string& output) const;
};

// "unknown", "time", "operating_point".
std::string_view NameOf(WindowAgreement::Cause cause);

// p: of each output; windows agree where there is one, or too few samples.
// Errors as of SimulateResponse().
absl::StatusOr<std::vector<WindowAgreement>> TestWindowAgreement(
    const ProcessModel& model, const std::vector<Record>& windows);

}  // namespace mle

#endif  // MLE_MAINTAIN_WINDOW_AGREEMENT_H_
