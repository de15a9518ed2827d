#include "apps/reproduce/study.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/common/progress.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle::reproduce {
namespace {

std::uint64_t SeedOf(const Study& study, int number) {
  return study.first_seed + static_cast<std::uint64_t>(number);
}

absl::Status During(const std::string& what, const absl::Status& status) {
  return absl::Status(status.code(),
                      absl::StrCat(what, ": ", status.message()));
}

absl::StatusOr<std::vector<ConversionSummary>> Convert(const Study& study) {
  std::vector<absl::StatusOr<ConversionSummary>> converted(
      study.seeds, absl::InternalError("not run"));
  Progress progress("conversions", study.seeds);
  ParallelFor(study.seeds, study.threads, [&](int s) {
    converted[s] =
        ConvertInitialModel(study.initial, SeedOf(study, s), study.experiment);
    progress.Done();
  });
  std::vector<ConversionSummary> conversions;
  for (int s = 0; s < study.seeds; ++s) {
    if (!converted[s].ok()) {
      return During(absl::StrCat("conversion, seed ", SeedOf(study, s)),
                    converted[s].status());
    }
    conversions.push_back(*std::move(converted[s]));
  }
  return conversions;
}

void DropCurves(RunResult& run) {
  run.squared_distance.resize(0);
  run.selection.loss.resize(0);
  run.selection.penalised_loss.resize(0);
  run.corrected = StepResponse();
  run.unregularised = StepResponse();
}

void RunAblations(const Study& study, std::vector<CaseResult>& results) {
  const int seeds = std::min(study.ablation_seeds, study.seeds);
  const auto kinds = static_cast<int>(study.ablations.size());
  if (kinds == 0) return;
  for (CaseResult& result : results) {
    for (const Ablation* ablation : study.ablations) {
      result.ablations.push_back({ablation, {}});
      result.ablations.back().runs.resize(seeds);
    }
  }
  const int each = kinds * seeds;
  Progress progress("ablations", static_cast<int>(results.size()) * each);
  ParallelFor(
      static_cast<int>(results.size()) * each, study.threads, [&](int i) {
        CaseResult& result = results[i / each];
        const int s = i % seeds;
        const int kind = i % each / seeds;
        result.ablations[kind].runs[s] =
            RunAblation(*study.ablations[kind], study.initial, result.plant,
                        SeedOf(study, s), study.experiment);
        progress.Done();
      });
}

CaseResult Describe(const Case& one, const Study& study) {
  CaseResult result;
  result.name = one.name;
  result.from_paper = one.from_paper;
  result.plant = one.plant;
  const int samples = study.experiment.response_samples();
  const double sample_time = study.experiment.sample_time;
  result.truth = one.plant.ComputeStepResponse(sample_time, samples);
  result.initial = study.initial.ComputeStepResponse(sample_time, samples);
  result.E_initial = SquaredDistance(result.truth, result.initial);
  return result;
}

}  // namespace

absl::StatusOr<std::vector<CaseResult>> RunStudy(const Study& study) {
  MLE_ASSIGN_OR_RETURN(const std::vector<ConversionSummary> conversions,
                       Convert(study));
  const int cases = static_cast<int>(study.cases.size());
  std::vector<absl::StatusOr<RunResult>> runs(
      static_cast<std::size_t>(study.seeds) * cases,
      absl::InternalError("not run"));
  Progress progress("runs", study.seeds * cases);
  ParallelFor(study.seeds * cases, study.threads, [&](int i) {
    const int s = i / cases;
    runs[i] = RunExperiment(study.initial, study.cases[i % cases].plant,
                            conversions[s], SeedOf(study, s),
                            /*in_full=*/s == 0, study.experiment);
    if (s > 0 && runs[i].ok()) DropCurves(*runs[i]);
    progress.Done();
  });

  std::vector<CaseResult> results;
  for (int c = 0; c < cases; ++c) {
    CaseResult& result = results.emplace_back(Describe(study.cases[c], study));
    for (int s = 0; s < study.seeds; ++s) {
      absl::StatusOr<RunResult>& run = runs[s * cases + c];
      if (!run.ok()) {
        return During(
            absl::StrCat("case ", result.name, ", seed ", SeedOf(study, s)),
            run.status());
      }
      result.runs.push_back(*std::move(run));
    }
    MLE_RETURN_IF_ERROR(SummariseCase(study.initial, result));
  }
  RunAblations(study, results);
  return results;
}

}  // namespace mle::reproduce
