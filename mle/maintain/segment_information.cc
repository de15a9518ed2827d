#include "mle/maintain/segment_information.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "absl/strings/str_format.h"
#include "mle/base/status.h"
#include "mle/maintain/element_responses.h"
#include "mle/nonlinear/innovations_filter.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Where an element has more than this share of all information on it, more of
// it counts less.
constexpr double kLittle = 1e-3;
constexpr double kSettlingTimes = 4.0;  // of the shortest segment

}  // namespace

int ShortestSegment(const ProcessModel& model, double sample_time) {
  const double samples = kSettlingTimes * SettlingTime(model) / sample_time;
  return static_cast<int>(std::clamp(std::ceil(samples), 2.0, 1e9));
}

absl::StatusOr<SegmentInformation> InformationIn(const Record& segment,
                                                 const ProcessModel& model) {
  const std::vector<Record> whole = {WithoutGaps(segment)};
  MLE_ASSIGN_OR_RETURN(const ElementResponses responses,
                       ElementResponses::Create(model, whole));
  std::vector<int> times(segment.samples());
  std::iota(times.begin(), times.end(), 0);
  const InnovationsFilter filter(times, {.ratio = kExpectedDriftRatio});
  const VectorXd measured =  // a_wi
      segment.outputs.array().isFinite().cast<double>().rowwise().mean();
  std::vector<double> information;
  for (int j = 0; j < model.num_inputs(); ++j) {
    MatrixXd whitened = responses.Of(j)[0];
    filter.Apply(whitened);
    for (int i = 0; i < model.num_outputs(); ++i) {
      const int column = responses.ColumnOf(i, j);
      if (column < 0) continue;
      const double squares = measured(i) * whitened.col(column).squaredNorm();
      information.push_back(std::isfinite(squares) ? squares : 0.0);
    }
  }
  return SegmentInformation{
      Eigen::Map<const VectorXd>(information.data(),
                                 static_cast<Index>(information.size())),
      segment.samples()};
}

std::vector<bool> ChooseSegments(
    const std::vector<SegmentInformation>& segments, const VectorXd& all,
    int most_samples) {
  VectorXd sum = (kLittle * all).cwiseMax(1e-300);
  std::vector<bool> taken(segments.size(), false);
  for (int left = most_samples; left > 0;) {
    double best = -1.0;
    std::size_t next = segments.size();
    for (std::size_t s = 0; s < segments.size(); ++s) {
      const SegmentInformation& segment = segments[s];
      if (taken[s] || (segment.samples > left && left < most_samples)) continue;
      const double gain =
          (segment.information.array() / sum.array()).log1p().sum() /
          segment.samples;
      if (gain > best) {
        best = gain;
        next = s;
      }
    }
    if (next == segments.size()) break;
    taken[next] = true;
    sum += segments[next].information;
    left -= segments[next].samples;
  }
  return taken;
}

std::string DescribeLoss(const VectorXd& used, const VectorXd& all) {
  std::vector<double> losses;
  for (Index e = 0; e < all.size(); ++e) {
    if (all(e) > 0.0) losses.push_back(1.0 - std::sqrt(used(e) / all(e)));
  }
  std::sort(losses.begin(), losses.end());
  return absl::StrFormat(
      "With all of them standard errors of gains would be expected to be "
      "smaller by %.0f %% in the median, by %.0f %% at most.",
      losses.empty() ? 0.0 : 100.0 * losses[losses.size() / 2],
      losses.empty() ? 0.0 : 100.0 * losses.back());
}

}  // namespace mle
