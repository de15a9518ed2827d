#include "benchmarks/watch/informed_cusum.h"

#include <algorithm>

#include "glog/logging.h"
#include "mle/monitor/output_scores.h"

namespace mle::benchmarks {
namespace {

double Squares(const std::vector<WhitenedRun>& runs) {
  double sum = 0.0;
  for (const WhitenedRun& run : runs) sum += run.innovations.squaredNorm();
  return sum;
}

}  // namespace

std::vector<WhitenedRun> ClippedInnovations(const ProcessModel& model,
                                            int output, int skip,
                                            const OutputReference& reference,
                                            const Record& record, double clip) {
  absl::StatusOr<RowResponse> row =
      RowResponse::Create(model, output, record.sample_time, skip);
  CHECK(row.ok()) << row.status();
  std::vector<WhitenedRun> runs = row->Whiten(record, reference.noise);
  ClipInnovations(clip * reference.deviation, runs);
  return runs;
}

InformedCusum::InformedCusum(const PlantLife& life, const ModelWatch& watch,
                             int skip, Ageing ageing, AgeingElement element)
    : ageing_(ageing),
      element_(element),
      skip_(skip),
      clip_(watch.options().clip),
      after_(life.PlantAfter(ageing, element, 1)) {}

void InformedCusum::Add(int day, const WatchReference& reference,
                        const Record& record,
                        const std::vector<std::vector<WhitenedRun>>& before) {
  const OutputReference& output = reference.outputs[element_.output];
  const std::vector<WhitenedRun>& old = before[element_.output];
  if (ageing_ != Ageing::kGain) {
    const double gained =
        0.5 * (Squares(old) -
               Squares(ClippedInnovations(after_, element_.output, skip_,
                                          output, record, clip_)));
    value_ = std::max(0.0, value_ + gained);
    return;
  }
  GainDay gain{.day = day};
  // Every element of this plant is present.
  const Eigen::Index column = 3 * element_.input;
  for (const WhitenedRun& run : old) {
    gain.score += run.sensitivities.col(column).dot(run.innovations);
    gain.information += run.sensitivities.col(column).squaredNorm();
  }
  days_.push_back(gain);
  value_ = 0.0;
  for (std::size_t begin = 0; begin < days_.size(); ++begin) {
    double sum = 0.0;
    for (std::size_t d = begin; d < days_.size(); ++d) {
      const double change =
          -0.3 * std::min((days_[d].day - days_[begin].day + 1) / 365.0, 1.0);
      sum += change * days_[d].score -
             0.5 * change * change * days_[d].information;
    }
    value_ = std::max(value_, sum);
  }
}

}  // namespace mle::benchmarks
