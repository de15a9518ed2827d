#include "sim/check_options.h"

#include <cmath>

#include "mle/base/status.h"

namespace mle::sim {
namespace {

absl::Status Wrong(const char* field, double value, const char* constraint) {
  return InvalidArgument(field, " = ", value, ", but it must be ", constraint);
}

}  // namespace

absl::Status CheckPositive(const char* field, double value) {
  if (value > 0.0 && std::isfinite(value)) return absl::OkStatus();
  return Wrong(field, value, "finite and > 0");
}

absl::Status CheckNotNegative(const char* field, double value) {
  if (value >= 0.0 && std::isfinite(value)) return absl::OkStatus();
  return Wrong(field, value, "finite and ≥ 0");
}

absl::Status CheckProbability(const char* field, double value) {
  if (value >= 0.0 && value <= 1.0) return absl::OkStatus();
  return Wrong(field, value, "a probability, in [0, 1]");
}

absl::Status CheckNoneOrNotNegative(const char* field,
                                    const Eigen::VectorXd& values, int size) {
  if (values.size() != 0 && values.size() != size) {
    return InvalidArgument(field, " has ", values.size(),
                           " values, but it needs ", size, " or none");
  }
  for (const double value : values) {
    if (!(value >= 0.0) || !std::isfinite(value)) {
      return Wrong(field, value, "finite and ≥ 0");
    }
  }
  return absl::OkStatus();
}

}  // namespace mle::sim
