// One output of a plant fitted to raw records: the residuals of the whole model
// and their derivatives. Internal to mle/nonlinear.
//
// In every segment (a run of samples whose inputs are all known)
//
//   y_k = c + Σ_j (K_j x_j(k; T_j, L_j) + φ_j(k; T_j) a_j) + n_k,
//
// with x_j the response of element j to the segment's inputs
// (element_response.h), an offset c, and n white noise plus a random walk
// (innovations_filter.h). What the inputs did before the segment is unknown.
// Once the longest dead time that the search allows has passed, all of it is
// the state of each element: a_j, one free amplitude for each mode φ_j. So the
// residuals begin there; the inputs from the segment's begin on are used.
//
// For an integrating element x_j is the response to the inputs less their first
// values, K_j a slope. Those values, and loads, balance the output or they do
// not: where an element integrates, the segment has one more free amplitude, of
// a ramp. What it has integrated before is part of the offset.
//
// c goes with the diffuse start of the filter (or is zero, if the noise has no
// offset), and a_j, linear, is projected
// out of the whitened residuals (variable projection in Kaufman's form, whose
// Gauss–Newton matrix is the full problem's with a_j eliminated: Kaufman, BIT
// 15, 1975). What remains are K, ln T and L of every element.

#ifndef MLE_NONLINEAR_OUTPUT_ERROR_PROBLEM_H_
#define MLE_NONLINEAR_OUTPUT_ERROR_PROBLEM_H_

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "mle/data/record.h"
#include "mle/model/element_response.h"
#include "mle/nonlinear/innovations_filter.h"
#include "mle/nonlinear/output_error_correction.h"

namespace mle {

// A step of a segment's level, from the sample with this number on; behind a
// lag with this time constant in samples, or at once (0).
struct SegmentStep {
  int segment = 0;
  int sample = 0;
  double lag = 0.0;
};

// Appends the cosine and the sine of `period` (in samples) at `times`, a step
// of size one, and a ramp from 0 to 1.
void AppendLine(const std::vector<int>& times, double period,
                Eigen::MatrixXd& columns);
void AppendStep(const std::vector<int>& times, const SegmentStep& step,
                Eigen::MatrixXd& columns);
void AppendRamp(const std::vector<int>& times, Eigen::MatrixXd& columns);

// Values of all elements of the output, and the sample that each dead time is
// taken to lie in (whole); an absent element's are unused.
struct OutputPoint {
  std::vector<ElementValues> values;
  std::vector<int> cells;

  // Each dead time in the sample it begins.
  void SetCells(double sample_time);
};

// Unwhitened columns of one segment.
struct SegmentColumns {
  Eigen::VectorXd residuals;  // rows
  // rows × 3f: by K, ln T, L of each of f free elements in turn.
  Eigen::MatrixXd jacobian;
  Eigen::MatrixXd amplitudes;  // rows × (Σ r_j + 2 lines + steps + ramp)
};

// Whitened, without what the amplitudes explain; all segments.
struct WhitenedColumns {
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;      // as above; 0 columns if not asked for
  double log_determinant = 0.0;  // Σ ln F
  double log_amplitudes = 0.0;   // ln det of the amplitudes' normal matrix
  int num_amplitudes = 0;        // its rank
};

// Numbers 3j, 3j + 1 and 3j + 2 for each free element in turn: where its K, T
// and L are among those of all elements.
std::vector<int> FreeParameters(const std::vector<bool>& free);

// First lags of ranges for LagSums(), and the end of the last: 1, 2, 4, …,
// until `longest` is in one.
std::vector<int> LagRanges(int longest);

class OutputErrorProblem {
 public:
  using Elements = std::vector<std::optional<ElementResponse>>;  // m

  struct Segment {
    int record = 0;
    double start_time = 0.0;
    Eigen::MatrixXd inputs;  // N × m
    std::vector<int> times;  // samples that count
    Eigen::VectorXd outputs;
    Eigen::VectorXd weights;  // empty: ones
  };

  // `skip`: samples left out at the begin of a segment. Segments of fewer than
  // `min_rows` usable samples are not used.
  OutputErrorProblem(Elements elements, const std::vector<Record>& records,
                     int output, int skip, int min_rows);

  const Elements& elements() const { return elements_; }
  int num_elements() const { return static_cast<int>(elements_.size()); }  // m
  int num_elements_present() const {
    return static_cast<int>(
        std::count_if(elements_.begin(), elements_.end(),
                      [](const auto& element) { return element.has_value(); }));
  }
  // An element that is present integrates.
  bool is_integrating() const { return integrating_; }
  // The numbers of K, T and L, among those of each element (0 … 3m − 1), of the
  // elements that are `free` (m); not of the T of an integrator without lag,
  // which has none.
  std::vector<int> FreeParameters(const std::vector<bool>& free) const;
  // Their columns among the 3f of a Jacobian.
  std::vector<int> FreeColumns(const std::vector<bool>& free) const;
  int num_segments() const { return static_cast<int>(segments_.size()); }
  double sample_time() const { return sample_time_; }
  int num_samples() const { return num_samples_; }
  const std::vector<int>& times(int segment) const {
    return segments_[segment].times;
  }
  const Segment& segment(int s) const { return segments_[s]; }
  int shortest_segment() const;  // its samples that count; 0 without segments

  // Weights ω_k > 0 of the samples of all segments in turn: the variance of
  // their white noise is r/ω_k. `variance_factor` is what makes the variances
  // of estimates out of that fit's (robust_loss.h).
  void SetWeights(const Eigen::VectorXd& weights, double variance_factor);
  const Eigen::VectorXd& weights() const { return weights_; }  // empty: ones
  double variance_factor() const { return variance_factor_; }
  // The weights by random errors of stamps, and their standard deviation
  // (stamp_noise.h), which weights of a robust loss are times. Empty: ones.
  void SetStampNoise(const Eigen::VectorXd& weights, double deviation);
  const Eigen::VectorXd& stamp_weights() const { return stamp_weights_; }
  double stamp_deviation() const { return stamp_deviation_; }

  // Periodic disturbances with these periods, in samples, whose amplitude and
  // phase are each segment's own: two more free amplitudes of each.
  void SetLines(const std::vector<double>& periods);
  const std::vector<double>& lines() const { return lines_; }
  // Steps of segments' levels: a free amplitude of its segment for each.
  void SetSteps(std::vector<SegmentStep> steps) { steps_ = std::move(steps); }
  const std::vector<SegmentStep>& steps() const { return steps_; }
  // At `point`: amplitudes of lines, root mean square over the segments, and
  // sizes of steps.
  struct Sizes {
    std::vector<double> lines;
    std::vector<double> steps;
  };
  Sizes DisturbanceSizes(const OutputPoint& point,
                         const NoiseShape& shape) const;
  // A step by record and time, and back: none where its segment is not used.
  LevelStep ToLevelStep(const SegmentStep& step, double size) const;
  std::optional<SegmentStep> Locate(const LevelStep& step) const;

  // The same output in records at rest, with the same lines; or null.
  void SetAtRest(std::unique_ptr<OutputErrorProblem> problem);
  const OutputErrorProblem* at_rest() const { return at_rest_.get(); }

  // Without one of each segment where that sets its offset.
  int num_innovations(const NoiseShape& shape) const {
    return num_samples_ - (shape.offset ? num_segments() : 0);
  }
  // Σ (y − mean)², the mean of each segment.
  double total_squares() const { return total_squares_; }
  // The input moves in a segment.
  bool IsExcited(int input) const;

  // At `point`, with derivatives by the elements that are `free` (m; empty:
  // none); amplitudes are those of least squares under noise of `shape`.
  std::vector<SegmentColumns> Linearise(const OutputPoint& point,
                                        const NoiseShape& shape,
                                        const std::vector<bool>& free) const;
  // The columns of ElementResponse::Simulate() for element j at `point`, a row
  // for each sample of the segment's inputs.
  void Respond(const Segment& segment, const OutputPoint& point, int j,
               Eigen::MatrixXd& response, bool derivatives = true) const;
  // The same in pieces.
  ElementRun Run(const Segment& segment, const OutputPoint& point, int j,
                 bool derivatives) const;
  // The free responses of element j and their derivatives by its ln T (each
  // n × r_j), at every sample from the first that counts until they are zero;
  // at those that count (rows × r_j); the columns of lines, steps and a ramp,
  // appended. Free responses return the number of samples that count before
  // they are zero.
  Eigen::Index FreeResponses(const Segment& segment, const OutputPoint& point,
                             int j, Eigen::MatrixXd& columns,
                             Eigen::MatrixXd& derivatives) const;
  Eigen::Index Modes(const Segment& segment, const OutputPoint& point, int j,
                     Eigen::Ref<Eigen::MatrixXd> columns,
                     Eigen::Ref<Eigen::MatrixXd> derivatives) const;
  void AppendDisturbances(int segment, Eigen::MatrixXd& columns) const;
  // In place of the derivative by each free dead time L, the secant over L ±
  // steps (of every element; 0: unchanged).
  void TakeSecants(const OutputPoint& point, const std::vector<bool>& free,
                   const std::vector<double>& steps,
                   std::vector<SegmentColumns>& columns) const;
  // Rows are samples.
  WhitenedColumns Whiten(const std::vector<SegmentColumns>& columns,
                         const NoiseShape& shape) const;
  WhitenedColumns WhitenSegment(int s, const SegmentColumns& columns,
                                const NoiseShape& shape) const;

  // The residuals of the whole model at `point`, sample by sample: less the
  // amplitudes' part, the offset and the smoothed random walk.
  Eigen::VectorXd WhiteResiduals(const OutputPoint& point,
                                 const NoiseShape& shape) const;
  Eigen::VectorXd WhiteResiduals(const std::vector<SegmentColumns>& columns,
                                 const NoiseShape& shape) const;

  // For each segment rows × (m · ranges): sums of each input over the lags
  // first_lags[b] … first_lags[b + 1] − 1 (in samples, ≥ 0, ascending), by
  // input and range; before the segment it stands at its first value. Zero
  // where an input of an absent element is not known throughout.
  std::vector<Eigen::MatrixXd> LagSums(
      const std::vector<int>& first_lags) const;

  // Whitened responses (K = 1) of each element with the time scale of `point`,
  // at each of `delays`[j] (in samples); the last column is y less the
  // responses at `point` of the elements without such delays. Without what the
  // amplitudes explain.
  Eigen::MatrixXd Dictionary(const OutputPoint& point, const NoiseShape& shape,
                             const std::vector<std::vector<int>>& delays) const;

 private:
  // rows × (Σ r_j + 2 lines + steps + ramp), and the derivatives of the first
  // Σ r_j by the ln T of their element.
  void Amplitudes(int segment, const OutputPoint& point,
                  Eigen::MatrixXd& columns, Eigen::MatrixXd& derivatives) const;
  // Amplitudes by least squares under noise of `shape`.
  Eigen::VectorXd AmplitudesOf(int segment, const SegmentColumns& columns,
                               const NoiseShape& shape) const;

  Elements elements_;
  std::vector<Segment> segments_;
  double sample_time_ = 0.0;
  int num_samples_ = 0;
  int num_modes_ = 0;  // Σ r_j
  bool integrating_ = false;
  double total_squares_ = 0.0;
  std::vector<double> lines_;
  std::unique_ptr<OutputErrorProblem> at_rest_;
  std::vector<SegmentStep> steps_;
  Eigen::VectorXd weights_;
  double variance_factor_ = 1.0;
  Eigen::VectorXd stamp_weights_;
  double stamp_deviation_ = 0.0;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_ERROR_PROBLEM_H_
