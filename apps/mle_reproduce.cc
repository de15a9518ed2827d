// mle_reproduce: the paper's experiments, or the same on another plant.

#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "apps/common/command_line.h"
#include "apps/report/drawing.h"
#include "apps/report/text.h"
#include "apps/reproduce/report.h"
#include "apps/reproduce/request.h"
#include "apps/reproduce/summary.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle {
namespace {

using reproduce::CaseResult;

constexpr char kUsage[] =
    R"(Corrects a process model from closed-loop records around set-point changes alone,
in simulation, where the true plant is known and the correction can be judged.

  mle_reproduce --cases=gain,delay --seeds=20 --out=results
  mle_reproduce --model=column.json --plants=aged:column_aged.json

Times are in the model's time unit: min by default. Exit codes: 0 done, 1 ran but
the result is not usable, 2 bad input or flags.)";

absl::Status WriteAll(const std::vector<CaseResult>& results,
                      const reproduce::Request& request) {
  const reproduce::Reproduction& reproduction = request.reproduction;
  const Eigen::VectorXd& lambdas =
      reproduction.campaign.settings.correction.lambdas;
  std::vector<std::pair<std::string, std::string>> files =
      reproduce::FormatCurves(results, lambdas);
  files.emplace_back("results.json", reproduce::FormatResults(results));
  std::vector<report::NamedFigure> figures;
  if (request.figures) figures = reproduce::MakeFigures(results, lambdas);
  return report::WriteReport(
      request.folder, std::move(figures), reproduction.threads,
      std::move(files), [&](const std::vector<report::DrawnFigure>& drawn) {
        return reproduce::FormatPage(
            results, drawn, HowToRunAgain(reproduction.campaign.seeds));
      });
}

void PrintTables(const CaseResult& result) {
  std::cout << report::RenderText(reproduce::DistanceTable(result)) << "\n"
            << report::RenderText(reproduce::GainTable(result)) << "\n"
            << report::RenderText(reproduce::DelayTable(result)) << "\n";
  if (!result.runs.front().estimators.empty()) {
    std::cout << report::RenderText(
                     reproduce::EstimatorTable(result, /*with_times=*/true))
              << "\n";
  }
  if (!result.ablations.empty()) {
    std::cout << report::RenderText(reproduce::AblationTable(result)) << "\n";
  }
  std::cout << report::RenderText(reproduce::ClosedLoopTable(
                   result.name, result.plant, result.ClosedLoops()))
            << "\nRelative duality gap, every fit and every λ: at most "
            << report::FormatScientific(result.max_relative_gap, 2) << "\n\n";
}

absl::StatusOr<int> Run(reproduce::Request& request, OptionTable& table) {
  MLE_RETURN_IF_ERROR(reproduce::Complete(request, table));
  MLE_ASSIGN_OR_RETURN(const FolderLock lock,
                       ClaimOutputFolder(request.folder));
  MLE_ASSIGN_OR_RETURN(const std::vector<CaseResult> results,
                       reproduce::RunReproduction(request.reproduction));
  int exit_code = kExitDone;
  for (const CaseResult& result : results) {
    PrintTables(result);
    if (!(result.max_relative_gap <= reproduce::kAcceptedGap)) {
      std::cerr << "warning: case " << result.name
                << ": a fit is not exact (relative duality gap above "
                << report::FormatScientific(reproduce::kAcceptedGap, 1)
                << ")\n";
      exit_code = kExitNotUsable;
    }
  }
  if (const absl::Status status = WriteAll(results, request); !status.ok()) {
    return absl::InternalError(status.message());
  }
  std::cout << "Report and results: " << request.folder << "/report.html\n";
  return exit_code;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  return mle::RunCommand(mle::kUsage, mle::reproduce::AddOptions, mle::Run,
                         argc, argv);
}
