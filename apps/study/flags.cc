#include "apps/study/flags.h"

#include "absl/strings/str_cat.h"
#include "gflags/gflags.h"

DEFINE_string(
    campaign, "",
    "The campaign (JSON): a grid of seeds, plants, mismatches, noise, "
    "controllers, set-point changes and estimators; "
    "configs/campaign_*.json are examples.");
DEFINE_string(out, "study",
              "Folder for journal.csv, runs.csv, timings.csv, summary.csv, "
              "summary.json and report.html.");
DEFINE_bool(resume, false,
            "Resume the campaign in --out, if there is one. It must be the "
            "same campaign and version.");
DEFINE_bool(dry_run, false,
            "Only print how many runs there are, and the first few.");
DEFINE_bool(figures, true,
            "Draw the figures of the report (PNG and PDF need rsvg-convert).");
DEFINE_int32(threads, 0,
             "Threads of each process, 0: a share of the processors. The "
             "results do not depend on it.");

namespace mle::study {

absl::StatusOr<Request> RequestFromFlags() {
  constexpr int kMaxThreads = 4096;
  if (FLAGS_campaign.empty()) {
    return absl::InvalidArgumentError(
        "--campaign: the campaign's file is needed, as in "
        "--campaign=configs/campaign_reproduction.json");
  }
  if (FLAGS_out.empty()) {
    return absl::InvalidArgumentError("--out: a folder is needed");
  }
  if (FLAGS_threads < 0 || FLAGS_threads > kMaxThreads) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--threads=", FLAGS_threads, ": from 0 (a share of the processors) to ",
        kMaxThreads, " are possible"));
  }
  return Request{.campaign = FLAGS_campaign,
                 .out = FLAGS_out,
                 .resume = FLAGS_resume,
                 .dry_run = FLAGS_dry_run,
                 .figures = FLAGS_figures,
                 .threads = FLAGS_threads};
}

}  // namespace mle::study
