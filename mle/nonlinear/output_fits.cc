#include "mle/nonlinear/output_fits.h"

#include <atomic>
#include <cstddef>
#include <mutex>
#include <utility>

#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/nonlinear/disturbance_search.h"

namespace mle {
namespace {

bool MayChange(const OutputErrorOptions& options, int i) {
  return options.outputs.empty() || options.outputs[i];
}

}  // namespace

absl::Status FitEach(int count, const OutputErrorOptions& options,
                     const std::function<void(int)>& fit) {
  std::mutex mutex;
  std::atomic<bool> cancelled = false;
  ParallelFor(count, options.threads, [&](int i) {
    if (cancelled) return;
    fit(i);
    const std::lock_guard<std::mutex> lock(mutex);
    if (options.after_fit && !options.after_fit()) cancelled = true;
  });
  return cancelled ? absl::CancelledError("stopped by the caller")
                   : absl::OkStatus();
}

absl::StatusOr<std::vector<OutputFit>> FitOutputs(
    const std::vector<OutputSetup>& setups, const OutputErrorOptions& options) {
  const int p = static_cast<int>(setups.size());
  std::vector<OutputFit> fits(p);
  MLE_RETURN_IF_ERROR(FitEach(p, options, [&](int i) {
    const OutputSetup& setup = setups[i];
    const bool may_change = MayChange(options, i);
    const std::vector<bool> free =
        may_change ? setup.informed
                   : std::vector<bool>(setup.informed.size(), false);
    fits[i] = options.start != nullptr
                  ? FitOutputFrom(setup.start, free, setup.bounds, options, i,
                                  *setup.problem)
                  : FitOutput(*setup.problem, setup.start, free, setup.bounds,
                              options);
    if (!may_change) return;
    FitWithStampNoise(setup.bounds, options, *setup.problem, fits[i]);
    if (options.start == nullptr) {
      FitDisturbances(setup.start, setup.bounds, options, *setup.problem,
                      fits[i]);
    }
    if (options.robust_loss != RobustLoss::kNone) {
      FitRobustly(setup.bounds, options, *setup.problem, fits[i]);
    }
  }));
  return fits;
}

OutputFit FitAged(const OutputSetup& setup, const OutputFit& fit,
                  const std::vector<bool>& free,
                  const OutputErrorOptions& options) {
  OutputPoint start = setup.start;
  bool any = false;
  for (std::size_t j = 0; j < free.size(); ++j) {
    if (free[j]) start.values[j] = fit.point.values[j];
    any = any || free[j];
  }
  if (!any)
    return FitOutput(*setup.problem, start, free, setup.bounds, options);
  OutputFit aged = fit;
  aged.free = free;
  aged.point = std::move(start);
  aged.point.SetCells(setup.problem->sample_time());
  // The AR component was sought with all free that may have changed.
  return Refit(*setup.problem, aged, setup.bounds, options,
               /*search_ar=*/false);
}

}  // namespace mle
