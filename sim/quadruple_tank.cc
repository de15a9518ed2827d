#include "sim/quadruple_tank.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "absl/status/status.h"
#include "mle/base/status.h"
#include "sim/check_options.h"

namespace mle::sim {
namespace {

using Eigen::Array4d;
using Eigen::VectorXd;

constexpr double kGravity = 981.0;                   // g [cm/s²]
const Array4d kAreas(28.0, 32.0, 28.0, 32.0);        // A [cm²]
const Array4d kOutlets(0.071, 0.057, 0.071, 0.057);  // a [cm²]

Array4d OutletsAt(const QuadrupleTankOptions& options, double time) {
  return kOutlets * Array4d(options.outlet1_factor.At(time),
                            options.outlet2_factor.At(time),
                            options.outlet3_factor.At(time),
                            options.outlet4_factor.At(time));
}

// What the pumps lift into every tank [cm³/s].
Array4d Inflows(const QuadrupleTankOptions& options, double time,
                const VectorXd& w) {
  const double flow1 =
      options.pump1 * options.pump1_factor.At(time) * std::max(w[0], 0.0);
  const double flow2 =
      options.pump2 * options.pump2_factor.At(time) * std::max(w[1], 0.0);
  const double split1 = options.split1 * options.split1_factor.At(time);
  const double split2 = options.split2 * options.split2_factor.At(time);
  return {split1 * flow1, split2 * flow2, (1.0 - split2) * flow2,
          (1.0 - split1) * flow1};
}

void TankDerivative(const QuadrupleTankOptions& options, double time,
                    const VectorXd& x, const VectorXd& w, VectorXd& dx) {
  // Torricelli's law; nothing runs out of an empty tank.
  const Array4d outflows =
      OutletsAt(options, time) * (2.0 * kGravity * x.array().max(0.0)).sqrt();
  Array4d net = Inflows(options, time, w) - outflows;
  net.head<2>() += outflows.tail<2>();
  dx = net / kAreas;
}

// Where as much runs out of every tank as into it.
VectorXd RestingLevels(const QuadrupleTankOptions& options, double time,
                       const VectorXd& w) {
  Array4d flows = Inflows(options, time, w);
  flows.head<2>() += flows.tail<2>();
  return (flows / OutletsAt(options, time)).square() / (2.0 * kGravity);
}

absl::Status CheckSplit(const char* name, double split,
                        const Schedule& factor) {
  MLE_RETURN_IF_ERROR(CheckPositive(name, split));
  const double largest = split * factor.Max();
  if (largest < 1.0) return absl::OkStatus();
  return InvalidArgument(name, " = ", split, " becomes ", largest,
                         ", but it must stay below 1");
}

absl::Status ValidateTanks(QuadrupleTankOptions options) {
  MLE_RETURN_IF_ERROR(CheckPositive("voltage1", options.voltage1));
  MLE_RETURN_IF_ERROR(CheckPositive("voltage2", options.voltage2));
  MLE_RETURN_IF_ERROR(CheckPositive("pump1", options.pump1));
  MLE_RETURN_IF_ERROR(CheckPositive("pump2", options.pump2));
  MLE_RETURN_IF_ERROR(CheckFactors(AgeingFactors(options)));
  MLE_RETURN_IF_ERROR(
      CheckSplit("split1", options.split1, options.split1_factor));
  return CheckSplit("split2", options.split2, options.split2_factor);
}

}  // namespace

std::vector<AgeingFactor> AgeingFactors(QuadrupleTankOptions& options) {
  return {{"pump1", &options.pump1_factor},
          {"pump2", &options.pump2_factor},
          {"split1", &options.split1_factor},
          {"split2", &options.split2_factor},
          {"outlet1", &options.outlet1_factor},
          {"outlet2", &options.outlet2_factor},
          {"outlet3", &options.outlet3_factor},
          {"outlet4", &options.outlet4_factor}};
}

absl::StatusOr<ContinuousSystem> MakeQuadrupleTank(QuadrupleTankOptions options,
                                                   double start_time) {
  MLE_RETURN_IF_ERROR(ValidateTanks(options));
  const Eigen::Vector2d voltages(options.voltage1, options.voltage2);
  return MakePlantAtRest(
      {.derivative = std::bind_front(TankDerivative, options),
       .outputs = {0, 1},
       .inputs = voltages,
       .guess = RestingLevels(options, start_time, voltages),
       .delays = {}},
      AgeingFactors(options), start_time);
}

}  // namespace mle::sim
