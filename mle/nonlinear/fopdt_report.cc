#include <string>

#include "absl/strings/str_cat.h"
#include "mle/nonlinear/fopdt_fit.h"

namespace mle {
namespace {

std::string ShapeName(FopdtShape shape) {
  switch (shape) {
    case FopdtShape::kFits:
      return "fits";
    case FopdtShape::kNoResponse:
      return "no response";
    case FopdtShape::kPoorFit:
      return "poor fit";
  }
  return "unknown";
}

std::string TerminationName(FopdtTermination termination) {
  switch (termination) {
    case FopdtTermination::kNotRun:
      return "not run";
    case FopdtTermination::kConverged:
      return "converged";
    case FopdtTermination::kIterationLimit:
      return "stopped at the iteration limit";
    case FopdtTermination::kFailed:
      return "failed";
  }
  return "unknown";
}

}  // namespace

std::string FopdtFit::BriefReport() const {
  if (shape == FopdtShape::kNoResponse) return "FOPDT fit: no response";
  return absl::StrCat("FOPDT fit: K ", gain, ", T ", time_constant, ", L ",
                      delay, ", residual ", 100.0 * relative_rms,
                      " % of the range, ", ShapeName(shape), ", ",
                      TerminationName(termination));
}

std::string FopdtFit::FullReport() const {
  return absl::StrCat(
      "First-order-plus-dead-time fit\n",                                //
      "  shape               ", ShapeName(shape), "\n",                  //
      "  gain                ", gain, " ± ", gain_standard_error, "\n",  //
      "  time constant       ", time_constant, " ± ",
      time_constant_standard_error, "\n",  //
      "  dead time           ", delay, " ± ", delay_standard_error, "\n",
      "  RMS residual        ", 100.0 * relative_rms, " % of the range\n",
      "  largest residual    ", 100.0 * relative_max_residual,
      " % of the range\n",  //
      "  termination         ", TerminationName(termination), "\n",
      "  iterations          ", iterations, "\n");
}

}  // namespace mle
