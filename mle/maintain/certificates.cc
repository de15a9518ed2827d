#include "mle/maintain/certificates.h"

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "mle/maintain/correct.h"

namespace mle {
namespace {

// A step response beyond it has no bound.
constexpr double kUnbounded = 1e50;

bool AnyFitted(const OutputErrorFit& fit, int output) {
  for (int j = 0; j < fit.model.num_inputs(); ++j) {
    if (fit.element(output, j).state == ElementState::kFitted) return true;
  }
  return false;
}

void CheckOutput(const std::string& output, const FitCertificate& certificate,
                 CorrectionResult& result) {
  const std::string name = absl::StrCat("the fit of ", output);
  if (certificate.termination == FitTermination::kFailed) {
    result.failures.push_back(
        {MessageCode::kFitFailed,
         output,
         absl::StrCat(name, " failed: ", certificate.message),
         {}});
  } else if (certificate.gradient > result.options.accepted_gradient) {
    result.warnings.push_back(
        {MessageCode::kOptimumLoose,
         output,
         absl::StrFormat("In %s the optimum is reached only within %.1g "
                         "standard deviations.",
                         name, certificate.gradient),
         {}});
  }
  if (certificate.at_bound) {
    result.warnings.push_back(
        {MessageCode::kAtBound,
         output,
         absl::StrCat("In ", name,
                      " a time constant or dead time is at its search bound: "
                      "the optimum may be beyond the bound."),
         {"max_time_constant_factor", "max_delay"}});
  }
  if (certificate.rank < certificate.num_parameters) {
    result.warnings.push_back(
        {MessageCode::kRankDeficient,
         output,
         absl::StrCat(
             "In ", name, " the records determine only ", certificate.rank,
             " of ", certificate.num_parameters,
             " parameters: inputs that move together cannot be separated."),
         {}});
  }
}

void CheckShapes(CorrectionResult& result) {
  const ProcessModel& model = result.initial;
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; j < model.num_inputs(); ++j) {
      if (result.fopdt[i * model.num_inputs() + j].shape !=
          FopdtShape::kPoorFit) {
        continue;
      }
      const std::string pair = PairName(model, i, j);
      result.warnings.push_back(
          {MessageCode::kPoorFopdt,
           pair,
           absl::StrCat(pair,
                        " is not well described by a gain, a time constant and "
                        "a dead time: use its step response instead."),
           {}});
    }
  }
}

void CheckArx(CorrectionResult& result) {
  const CorrectedModel& corrected = result.corrected;
  if (corrected.arx.R.size() == 0 || corrected.has_arx()) return;
  result.warnings.push_back(
      {MessageCode::kArxInexact,
       "",
       absl::StrFormat("No ARX model is written: of order %d it differs from "
                       "the process model by %.2g %% of a step response, more "
                       "than %.2g %%; another order may do.",
                       corrected.arx.order, 100.0 * corrected.arx_error,
                       100.0 * kAcceptedArxError),
       {"order"}});
}

void CheckStateSpace(CorrectionResult& result) {
  const StateSpaceForm& form = result.state_space;
  if (form.model.has_value() || form.reason.empty()) return;
  result.warnings.push_back(
      {MessageCode::kNoStateSpace,
       "",
       absl::StrCat("No state-space model is written: ", form.reason, "."),
       {}});
}

}  // namespace

absl::Status CheckResponse(const StepResponse& response) {
  if (response.values.allFinite() &&
      response.values.cwiseAbs().maxCoeff() <= kUnbounded) {
    return absl::OkStatus();
  }
  return absl::FailedPreconditionError("the corrected model is unstable");
}

void CheckCertificates(CorrectionResult& result) {
  const OutputErrorFit& fit = result.estimate.fit.output_error.corrected;
  for (int i = 0; i < result.initial.num_outputs(); ++i) {
    if (AnyFitted(fit, i)) {
      CheckOutput(result.initial.outputs()[i].name, fit.certificates[i],
                  result);
    }
  }
  const double gap = result.corrected.max_relative_gap;
  if (!(gap <= result.options.accepted_gap)) {
    result.failures.push_back(
        {MessageCode::kNotExact,
         "",
         absl::StrFormat("a lasso fit is not exact: its relative duality gap "
                         "is %.1g, more than %.1g",
                         gap, result.options.accepted_gap),
         {}});
  }
  CheckShapes(result);
  CheckArx(result);
  CheckStateSpace(result);
}

}  // namespace mle
