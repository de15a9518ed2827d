#include "mle/trial/trial_verdict.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "mle/base/status.h"
#include "mle/trial/trial_evidence.h"

namespace mle {
namespace {

double SumOf(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// What set points drive of the residuals in a response.
struct Left {
  double in_use = 0.0;
  double proposed = 0.0;
  int shapes = 0;
};

// Without the eighth of the responses in which the proposed model leaves most:
// a disturbance that comes in one by chance is not the model's.
void TakeShare(std::vector<Left> left, double& share, double& error) {
  std::sort(left.begin(), left.end(), [](const Left& a, const Left& b) {
    return a.proposed < b.proposed;
  });
  left.resize(left.size() - left.size() / 8);
  Left sum;
  for (const Left& response : left) {
    sum.in_use += response.in_use;
    sum.proposed += response.proposed;
    sum.shapes += response.shapes;
  }
  if (!(sum.in_use > 0.0)) return;
  share = std::max(sum.proposed, 0.0) / sum.in_use;
  // Of χ² with as many degrees of freedom.
  error = std::sqrt(2.0 * sum.shapes) / sum.in_use;
}

Left LeftIn(const TrialResponse& response) {
  return {.in_use = SumOf(response.in_use),
          .proposed = SumOf(response.proposed),
          .shapes = response.shapes};
}

// What follows from the last evidence, the advice before it, and the rest.
TrialAdvice Advise(const TrialVerdict& verdict, bool adopted,
                   const TrialOptions& options) {
  const int judged = verdict.responses - verdict.not_judged;
  const double limit = -std::log(options.level);
  const TrialEvidencePoint& last = verdict.evidence.back();
  if (judged < options.least_changes) return verdict.advice;
  if (adopted) {
    return last.log_for >= limit ? TrialAdvice::kRollBack : verdict.advice;
  }
  if (verdict.advice == TrialAdvice::kDrop) return verdict.advice;
  if (last.log_against >= limit) return TrialAdvice::kDrop;
  if (last.log_for >= limit &&
      verdict.left_share <=
          options.left_share +
              std::min(verdict.left_error, 2.0 * options.left_share) &&
      verdict.left_before <= options.left_share + verdict.left_before_error) {
    return TrialAdvice::kAdopt;
  }
  return verdict.advice == TrialAdvice::kWait && judged >= options.most_changes
             ? TrialAdvice::kDrop
             : verdict.advice;
}

}  // namespace

absl::Status TrialOptions::Validate() const {
  if (!(level > 0.0 && level < 1.0)) {
    return InvalidArgument("trial: level is ", level, "; it must be in (0, 1)");
  }
  if (!(left_share > 0.0)) {
    return InvalidArgument("trial: left_share is ", left_share,
                           "; it must be > 0");
  }
  if (least_changes < 2) {
    return InvalidArgument("trial: least_changes is ", least_changes,
                           "; it must be ≥ 2");
  }
  if (most_changes < least_changes) {
    return InvalidArgument("trial: most_changes is ", most_changes,
                           "; it must be ≥ least_changes (", least_changes,
                           ")");
  }
  return absl::OkStatus();
}

bool TrialResponse::judged() const {
  return std::any_of(deviations.begin(), deviations.end(),
                     [](double deviation) { return deviation > 0.0; });
}

double TrialResponse::difference() const {
  return judged() ? SumOf(gains) / SumOf(deviations) : 0.0;
}

double TrialResponse::size() const {
  return judged() ? SumOf(sizes) / SumOf(deviations) : 0.0;
}

std::string_view NameOf(TrialAdvice advice) {
  switch (advice) {
    case TrialAdvice::kWait:
      return "wait";
    case TrialAdvice::kAdopt:
      return "adopt";
    case TrialAdvice::kDrop:
      return "drop";
    case TrialAdvice::kKeep:
      return "keep";
    case TrialAdvice::kRollBack:
      return "roll_back";
  }
  return "";
}

TrialVerdict JudgeResponses(const std::vector<TrialResponse>& responses,
                            const std::vector<TrialResponse>& learned,
                            bool adopted, const TrialOptions& options) {
  TrialVerdict verdict;
  std::vector<Left> before;
  for (const TrialResponse& response : learned) {
    if (response.shapes > 0) before.push_back(LeftIn(response));
  }
  TakeShare(before, verdict.left_before, verdict.left_before_error);
  TrialEvidence better;
  TrialEvidence worse;
  std::vector<TrialEvidence> worse_outputs;
  std::vector<Left> left;
  verdict.advice = adopted ? TrialAdvice::kKeep : TrialAdvice::kWait;
  for (const TrialResponse& response : responses) {
    verdict.changes += response.changes;
    ++verdict.responses;
    if (!response.judged()) {
      ++verdict.not_judged;
      continue;
    }
    better.Add(response.difference(), 0.5 * response.size());
    worse.Add(-response.difference(), 0.5 * response.size());
    const std::size_t r = response.gains.size();
    worse_outputs.resize(r);
    double against = 0.0;
    for (std::size_t i = 0; i < r; ++i) {
      if (response.deviations[i] > 0.0) {
        worse_outputs[i].Add(-response.gains[i] / response.deviations[i],
                             0.5 * response.sizes[i] / response.deviations[i]);
      }
      against += std::exp(worse_outputs[i].log()) / static_cast<double>(r);
    }
    against = 0.5 * (against + std::exp(worse.log()));
    left.push_back(LeftIn(response));
    TakeShare(left, verdict.left_share, verdict.left_error);
    verdict.evidence.push_back(
        {response.time, better.log(), std::log(against)});
    verdict.advice = Advise(verdict, adopted, options);
  }
  return verdict;
}

}  // namespace mle
