// mle_lifecycle: what keeping a model up to date is worth, over years.

#include <iostream>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/command_line.h"
#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/report.h"
#include "apps/lifecycle/request.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/html.h"
#include "apps/report/table.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr char kUsage[] =
    R"(Lets a plant age over years under predictive control, and compares policies of
keeping the controller's model up to date: never, corrections from routine
records, step tests, and the perfect model. Same plant, set points and noise for
all.

  mle_lifecycle --model=configs/wood_berry.json --out=lifecycle \
      --ageing=configs/wood_berry_ageing.json --years=5 --change_every=30d
  mle_lifecycle … --ageing_rates=0.25,0.5,1,2 \
      --policies=never,output_error:1,output_error:6,test:6,test:24,perfect

An interrupted run resumes when it is started again with the same flags. Parts
(--part=1/2, --part=2/2) may run at once; the run without --part brings them
together. Other prices need no new simulation. Exit codes: 0 done, 1 stopped, or
ran but the result is not usable, 2 bad input or flags.)";

void PrintFindings(const lifecycle::Campaign& campaign,
                   const std::vector<lifecycle::RateSummary>& summaries,
                   const lifecycle::Valuation& valuation) {
  for (const lifecycle::RateSummary& rate : summaries) {
    std::cout << report::RenderText(lifecycle::ComparisonTable(
                     rate, campaign.seeds.size(), valuation.currency))
              << "\n"
              << report::RenderText(lifecycle::ActivityTable(rate)) << "\n";
  }
  std::cout << lifecycle::VerdictOf(campaign, summaries, valuation).Text();
}

absl::StatusOr<int> Run(lifecycle::Request& request, OptionTable& table) {
  MLE_RETURN_IF_ERROR(lifecycle::Complete(request, table));
  const lifecycle::Campaign& campaign = request.campaign;
  const experiment::Work work = lifecycle::WorkOf(campaign);
  MLE_ASSIGN_OR_RETURN(
      experiment::RunFolder folder,
      experiment::RunFolder::Open(work, campaign.folder, campaign.part,
                                  /*resume=*/true));
  MLE_ASSIGN_OR_RETURN(const bool whole, folder.RunAsCommand(work, "lives", "",
                                                             campaign.threads));
  if (!whole) return folder.is_done() ? kExitDone : kExitNotUsable;
  MLE_ASSIGN_OR_RETURN(lifecycle::Lives lives,
                       lifecycle::ReadLives(campaign, folder));
  const lifecycle::Results results =
      lifecycle::Evaluate(request, std::move(lives));
  PrintFindings(campaign, results.summaries, results.valuation);
  const absl::Status written = lifecycle::WriteResults(
      request, results,
      {CommandLine(), ResultFlags(), HowToRunAgain(campaign.seeds)});
  if (!written.ok() && !absl::IsResourceExhausted(written)) {
    return absl::InternalError(written.message());
  }
  MLE_RETURN_IF_ERROR(written);
  std::cout << "Report and results: " << campaign.folder << "/report.html\n";
  return kExitDone;
}

}  // namespace
}  // namespace mle

int main(int argc, char** argv) {
  return mle::RunCommand(mle::kUsage, mle::lifecycle::AddOptions, mle::Run,
                         argc, argv);
}
