// Gains, time scales and dead times fitted to a record, without hold-out and
// decision: fit_by_output_error MODEL.json RECORD.csv

#include <iostream>

#include "mle/data/set_point_windows.h"
#include "mle/mle.h"
#include "mle/nonlinear/output_error_correction.h"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const auto model = mle::ReadProcessModel(argv[1]);
  if (!model.ok()) return 2;
  const auto import = mle::ImportHistorian({argv[2]}, *model, {});
  if (!import.ok()) return 2;
  const auto windows = mle::FindWindows(import->records, *model, {});
  if (!windows.ok()) return 2;
  const auto correction =
      mle::CorrectByOutputError(*model, windows->Records(), {});
  if (!correction.ok()) {
    std::cerr << correction.status() << "\n";
    return 2;
  }
  std::cout << correction->FullReport();
  return 0;
}
