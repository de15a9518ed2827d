// mle_simulate: a record of a plant under predictive control.

#include <iostream>
#include <string>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"
#include "apps/simulate/request.h"
#include "mle/base/status.h"
#include "mle/data/record_csv.h"

namespace mle {
namespace {

constexpr char kUsage[] =
    "Simulates a plant under predictive control and writes the record that a "
    "historian would\nhave of it. The controller's model (--model) and the "
    "plant (--plant) may differ.\n\n"
    "  mle_simulate --model=configs/wood_berry.json "
    "--plant=configs/wood_berry_gain.json \\\n"
    "      --setpoints=overhead:500:1 --out=run.csv\n\n"
    "Times are in the model's time unit; inputs and outputs are deviations "
    "from the operating\npoint. Exit codes: 0 done, 1 ran but the loop is "
    "unstable, 2 bad input or flags.";

absl::StatusOr<int> Run(simulate::Request& request, OptionTable& table) {
  const absl::Status complete = simulate::Complete(request, table);
  if (!complete.ok()) return absl::InvalidArgumentError(complete.message());
  MLE_ASSIGN_OR_RETURN(const Record record, simulate::Run(request.simulation));
  const std::string& out = request.out;
  const absl::Status written =
      WriteRecordCsv(out, record, request.simulation.model);
  if (!written.ok()) {
    const std::string message = absl::StrCat("--out: ", written.message());
    // A full disk is no fault of the flag.
    const bool full =
        absl::IsResourceExhausted(written) || absl::IsOutOfRange(written);
    return full ? absl::ResourceExhaustedError(message)
                : absl::InvalidArgumentError(message);
  }
  const auto lost = record.outputs.array().isNaN().count() +
                    record.inputs.array().isNaN().count();
  std::cout << out << ": " << record.samples() << " samples of "
            << record.num_outputs() << " outputs and " << record.num_inputs()
            << " inputs, " << lost << " values lost, "
            << FindSetPointChanges(record).size() << " set-point changes\n";
  return kExitDone;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  return mle::RunCommand(mle::kUsage, mle::simulate::AddOptions, mle::Run, argc,
                         argv);
}
