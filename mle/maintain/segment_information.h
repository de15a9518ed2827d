// The information of segments of records about a model's gains, as expected
// from their inputs, and the segments that have most of it. Internal to
// mle/maintain.
//
// The information of segment w about the gain of element (i, j) is, but for the
// noise of output i,
//
//   I_wij = a_wi Σ_k (x_ij(k)~)²,   S_ij = Σ_w I_wij over the segments used,
//
// for the model's response x_ij to the segment's inputs, whether set points
// move them or control, whitened (~) under an offset and noise that drifts;
// a_wi is the share of samples in which output i was measured.

#ifndef MLE_MAINTAIN_SEGMENT_INFORMATION_H_
#define MLE_MAINTAIN_SEGMENT_INFORMATION_H_

#include <string>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/model/process_model.h"

namespace mle {

// q/r of the drift that is expected where the noise is not known yet.
inline constexpr double kExpectedDriftRatio = 1e-3;

// Four settling times of the model, in samples: what the inputs did before it
// is unknown of a segment, which is not to matter. At least 2.
int ShortestSegment(const ProcessModel& model, double sample_time);

struct SegmentInformation {
  // I_w of all elements that are present, input by input.
  Eigen::VectorXd information;
  int samples = 0;
};

// InvalidArgument for a model that cannot be simulated. Operations: samples
// times elements.
absl::StatusOr<SegmentInformation> InformationIn(const Record& segment,
                                                 const ProcessModel& model);

// Which segments to take, one after the other, each time the one by which
// Σ_ij ln(S_ij + a thousandth of `all`_ij) grows most for each of its samples,
// until `most_samples` are used up: what says something of elements that others
// do not inform comes first. The first is taken whatever its length. (The
// D-criterion with parameters apart: Fedorov, Theory of Optimal Experiments,
// 1972.) Operations: segments squared times elements.
std::vector<bool> ChooseSegments(
    const std::vector<SegmentInformation>& segments, const Eigen::VectorXd& all,
    int most_samples);

// "With all of them standard errors of gains would be expected to be smaller by
// 3 % in the median, by 9 % at most": of S, and of the sum over all segments.
std::string DescribeLoss(const Eigen::VectorXd& used,
                         const Eigen::VectorXd& all);

}  // namespace mle

#endif  // MLE_MAINTAIN_SEGMENT_INFORMATION_H_
