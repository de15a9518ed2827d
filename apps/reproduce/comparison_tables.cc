// The tables of estimators and of ablations (summary.h).

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"
#include "apps/reproduce/summary.h"

namespace mle::reproduce {
namespace {

using experiment::Describe;
using experiment::Distribution;
using report::FormatScientific;
using report::FormatSignificant;

// An estimator's results over the runs of a case.
struct EstimatorRuns {
  std::vector<double> E;
  int proposed = 0;
  double seconds = 0.0;
  std::string failure;
};

EstimatorRuns RunsOf(const CaseResult& result, const std::string& name) {
  EstimatorRuns runs;
  for (const RunResult& run : result.runs) {
    for (const MethodRun& one : run.estimators) {
      if (one.name != name) continue;
      if (!one.status.ok()) {
        runs.failure = std::string(one.status.message());
        continue;
      }
      runs.E.push_back(one.E);
      runs.proposed += one.change_proposed ? 1 : 0;
      runs.seconds += one.seconds;
    }
  }
  return runs;
}

std::vector<std::string> AblationRow(const AblationResult& result) {
  std::vector<double> E;
  std::vector<double> lambda;
  double gap = 0.0;
  std::string failure;
  for (const MethodRun& run : result.runs) {
    if (!run.status.ok()) {
      failure = std::string(run.status.message());
      continue;
    }
    E.push_back(run.E);
    lambda.push_back(run.lambda);
    gap = std::max(gap, run.max_relative_gap);
  }
  const char* const what = result.ablation->what;
  if (E.empty()) return {what, absl::StrCat("failed: ", failure)};
  const Distribution error = Describe(E, 0);
  const Distribution chosen = Describe(lambda, 0);
  return {what, FormatSignificant(error.mean), FormatSignificant(error.max),
          chosen.min == chosen.max
              ? FormatScientific(chosen.min, 2)
              : absl::StrCat(FormatScientific(chosen.min, 2), " … ",
                             FormatScientific(chosen.max, 2)),
          FormatScientific(gap, 1)};
}

}  // namespace

report::Table EstimatorTable(const CaseResult& result, bool with_times) {
  report::Table table;
  table.caption =
      absl::StrCat("Case ", result.name, ": estimators side by side");
  table.columns = {{"estimator", report::Align::kLeft},
                   {"runs"},
                   {"E mean"},
                   {"E worst"},
                   {"change proposed"}};
  if (with_times) table.columns.push_back({"s a run"});
  // In the order of the first run, which has them all.
  for (const MethodRun& one : result.runs.front().estimators) {
    const EstimatorRuns runs = RunsOf(result, one.name);
    if (runs.E.empty()) {
      table.AddRow({one.name, "0", runs.failure});
      continue;
    }
    const Distribution E = Describe(runs.E, 0);
    std::vector<std::string> row = {
        one.name, absl::StrCat(E.count), FormatSignificant(E.mean),
        FormatSignificant(E.max), absl::StrCat(runs.proposed, " of ", E.count)};
    if (with_times) {
      row.push_back(FormatSignificant(runs.seconds / E.count, 2));
    }
    table.AddRow(std::move(row));
  }
  std::vector<double> limits;
  for (const RunResult& run : result.runs) {
    if (run.E_limit > 0.0) limits.push_back(run.E_limit);
  }
  if (!limits.empty()) {
    table.AddRow({"information bound, all elements free",
                  absl::StrCat(limits.size()),
                  FormatSignificant(Describe(limits, 0).mean)});
  }
  return table;
}

report::Table AblationTable(const CaseResult& result) {
  std::vector<double> E;
  for (std::size_t s = 0; s < result.ablations.front().runs.size(); ++s) {
    E.push_back(result.runs[s].E_star);
  }
  report::Table table;
  table.caption =
      absl::StrCat("Case ", result.name, ": one decision taken differently, ",
                   E.size(), E.size() == 1 ? " seed" : " seeds");
  table.columns = {{"what differs", report::Align::kLeft},
                   {"E mean"},
                   {"E worst"},
                   {"λ*"},
                   {"largest duality gap"}};
  const Distribution method = Describe(E, 0);
  table.AddRow({"nothing", FormatSignificant(method.mean),
                FormatSignificant(method.max)});
  for (const AblationResult& ablation : result.ablations) {
    table.AddRow(AblationRow(ablation));
  }
  return table;
}

}  // namespace mle::reproduce
