#include "mle/nonlinear/extended_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace mle {
namespace {

using Eigen::MatrixXd;

constexpr int kLongestLag = 512;  // samples, of responses to the inputs
// Times an element's own: with it, lags in series, and a slow part besides.
constexpr std::array<double, 2> kFasterScales = {0.3, 0.6};
constexpr std::array<double, 1> kSlowerScales = {2.5};

// For each segment, each element's responses with `factors` times its time
// scale at `point`.
std::vector<MatrixXd> OtherShapes(const OutputErrorProblem& problem,
                                  const OutputPoint& point,
                                  std::span<const double> factors) {
  std::vector<MatrixXd> all;
  MatrixXd response;
  for (int s = 0; s < problem.num_segments(); ++s) {
    const OutputErrorProblem::Segment& segment = problem.segment(s);
    MatrixXd& columns = all.emplace_back(
        segment.outputs.size(), static_cast<Eigen::Index>(factors.size()) *
                                    problem.num_elements_present());
    Eigen::Index column = 0;
    for (int j = 0; j < problem.num_elements(); ++j) {
      if (!problem.elements()[j].has_value()) continue;
      for (const double factor : factors) {
        OutputPoint other = point;
        other.values[j].time_scale *= factor;
        problem.Respond(segment, other, j, response);
        columns.col(column++) = response(segment.times, 0);
      }
    }
  }
  return all;
}

}  // namespace

ExtendedFit::ExtendedFit(const OutputErrorProblem& problem,
                         const OutputFit& fit, bool estimate_drift)
    : problem_(problem),
      fit_(fit),
      estimate_drift_(estimate_drift),
      columns_(problem.Linearise(fit.point, ShapeOf(fit.noise), fit.free)) {}

ShapeLikelihood ExtendedFit::With(const std::vector<MatrixXd>& more) const {
  if (!likelihood_.has_value()) {
    likelihood_.emplace(problem_, columns_, fit_.free, /*restricted=*/false);
  }
  return likelihood_->With(more);
}

Profile ExtendedFit::Best(const std::vector<MatrixXd>& more,
                          const NoiseShape& start, bool search_ar) const {
  return FindBestShape(With(more), start, estimate_drift_, search_ar);
}

const Profile& ExtendedFit::Without() const {
  if (!without_.has_value()) {
    without_ = Best({}, ShapeOf(fit_.noise), /*search_ar=*/true);
  }
  return *without_;
}

bool ExtendedFit::InputsGain(double gain) const {
  const double log_samples = std::log(problem_.num_innovations(NoiseShape()));
  for (int set = 0; set < kInputColumns; ++set) {
    if (!gains_[set].has_value()) {
      const Profile with = Best(InputColumns(set), ShapeOf(fit_.noise),
                                /*search_ar=*/true);
      gains_[set] = Without().value - with.value -
                    (with.rank - Without().rank) * log_samples;
    }
    if (*gains_[set] >= gain) return true;
  }
  return false;
}

std::vector<MatrixXd> ExtendedFit::InputColumns(int set) const {
  if (set == 1) return OtherShapes(problem_, fit_.point, kFasterScales);
  if (set == 2) return OtherShapes(problem_, fit_.point, kSlowerScales);
  const int longest =
      std::max(std::min(kLongestLag, problem_.shortest_segment() / 4) - 1, 1);
  return problem_.LagSums(LagRanges(longest));
}

}  // namespace mle
