#include "apps/study/request.h"

namespace mle::study {

absl::Status Request::Validate() const {
  if (campaign.empty()) {
    return absl::InvalidArgumentError(
        "--campaign: the campaign's file is needed, as in "
        "--campaign=configs/campaign_reproduction.json");
  }
  if (out.empty()) {
    return absl::InvalidArgumentError("--out: a folder is needed");
  }
  return absl::OkStatus();
}

void AddOptions(Request& request, OptionTable& table) {
  table.Add(
      "Campaign",
      {{"campaign", &request.campaign,
        "The campaign (JSON): a grid of seeds, plants, mismatches, noise, "
        "controllers, set-point changes and estimators; "
        "configs/campaign_*.json are examples."},
       {"out", &request.out,
        "Folder for journal.csv, runs.csv, timings.csv, summary.csv, "
        "summary.json and report.html."},
       {"part", PartOfWork(&request.part),
        "Part of the runs, such as 3/16: the third of 16. Its journal is in "
        "parts/3-of-16 below --out. A run without --part takes over what parts "
        "have done, does what is left, and writes the results. Empty: all."},
       {"resume", &request.resume,
        "Resume the campaign in --out, if there is one. It must be the same "
        "campaign and version."},
       {"dry_run", &request.dry_run,
        "Only print how many runs there are, and the first few."},
       {"figures", &request.figures,
        "Draw the figures of the report (PNG and PDF need rsvg-convert)."},
       {"threads", &request.threads,
        "Threads; 0: one for each processor. The results do not depend on the "
        "number.",
        "", kNotNegative}});
  table.PutFirst(
      {"campaign", "out", "part", "resume", "dry_run", "figures", "threads"});
}

}  // namespace mle::study
