// An output as a process model and explanations say it should have been:
// simulated from the recorded inputs, and its residual.
//
//   z(t) = Σ_j K_j c_j(t), c_j the response of element j for a gain of 1 to its
//          input, from rest at the first sample of each record,
//   e = measured − z,
//
// as means over rows of a few samples, each row at most a twentieth of the
// row's median T + L. Missing outputs are left out of the means; a row with no
// measured sample, and rows for a while after a gap in the inputs, do not
// count. Internal to mle/explain.

#ifndef MLE_EXPLAIN_EXPLAINED_OUTPUT_H_
#define MLE_EXPLAIN_EXPLAINED_OUTPUT_H_

#include <memory>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/base/random.h"
#include "mle/data/record.h"
#include "mle/explain/curves.h"
#include "mle/explain/explanation.h"
#include "mle/explain/response_cache.h"
#include "mle/model/element_response.h"
#include "mle/model/process_model.h"

namespace mle {

// A row of the residual: samples [first, first + samples) of a record.
struct ResidualRow {
  int record = 0;
  int first = 0;
  int samples = 0;
};

// The inputs of each record without gaps (samples × inputs).
using FilledInputs = std::vector<Eigen::MatrixXd>;
FilledInputs Fill(const std::vector<Record>& records);

class ExplainedOutput {
 public:
  // FailedPrecondition where no element of the row can be simulated or no row
  // counts. `records` must outlive it; `inputs` are theirs, filled here where
  // there are none.
  static absl::StatusOr<ExplainedOutput> Create(
      const ProcessModel& model, const std::vector<Record>& records, int output,
      std::shared_ptr<const FilledInputs> inputs = nullptr);

  const std::vector<ResidualRow>& rows() const { return rows_; }
  const std::vector<Record>& records() const { return *records_; }
  double sample_time() const { return sample_time_; }
  int samples_a_row() const { return samples_a_row_; }
  int output() const { return output_; }
  // τ, the median of T + L in the row, and the longest.
  double tau() const { return tau_; }
  double longest() const { return longest_; }
  bool is_integrating() const { return integrating_; }
  // The inputs that reach the output.
  const std::vector<int>& inputs() const { return inputs_; }
  // And those from which there may be a new path.
  std::vector<int> possible_inputs() const;
  const ElementValues& values(int input) const;
  bool has_lag(int input) const;
  // The time constants of the row.
  std::vector<double> time_constants() const;
  // The parts of an explanation that are tried (Explanation::part); 0 alone of
  // most. A load follows one of the set points that move, or their mean.
  std::vector<int> PartsOf(ExplanationKind kind) const;

  // The explanations that may be tried here beside those taken: a row of the
  // table for each element, input or the output that it applies to, θ = 0.
  std::vector<Explanation> Applicable(
      const std::vector<Explanation>& taken) const;
  // Bounds of θ: those of the table, and that no dead time is negative.
  std::pair<double, double> Bounds(const Explanation& explanation) const;

  // What is measured, as means of the rows.
  const Eigen::VectorXd& Measured() const { return measured_; }
  // z as a sum of responses; a curve of the output acts on the sum.
  std::vector<ResponsePart> Responses(
      const std::vector<Explanation>& explanations) const;
  bool IsCurved(const std::vector<Explanation>& explanations) const;
  // The response of a part for a gain of 1, as means of the rows.
  Eigen::VectorXd ResponseOf(const ResponsePart& part) const;
  // c of a curve, θ in its units.
  double CurvatureOf(const Explanation& explanation) const;
  // A curve that was taken, θ with its standard error, and shapes that explain
  // as much.
  FoundCurve CurveOf(const Explanation& explanation, double standard_error,
                     const std::vector<Explanation>& alternatives) const;
  // A curve of an input as an explanation here.
  Explanation InputCurve(const FoundCurve& curve) const;
  // e for these explanations (rows).
  Eigen::VectorXd Residual(const std::vector<Explanation>& explanations) const;
  // e for another model of the same channels, its row simulated as it is.
  absl::StatusOr<Eigen::VectorXd> ResidualOf(const ProcessModel& model) const;
  // What an input of the model adds to z, of the model as it is.
  Eigen::VectorXd ContributionOf(int input) const;
  // What a mean over a time around each sample takes from z, of the model as it
  // is.
  Eigen::VectorXd LostByAverage(double time) const;
  // What independent errors of the stamps, of this standard deviation, do to
  // the measurements, drawn so many times (rows × draws).
  Eigen::MatrixXd DrawStampErrors(double deviation, int draws,
                                  GaussianNoise& noise) const;
  // Values of the element from which explanations change K, T and L: those of
  // the model, or of a new path.
  ElementValues Before(int input,
                       const std::vector<Explanation>& explanations) const;
  // The same with these changes.
  ElementValues Aged(int input,
                     const std::vector<Explanation>& explanations) const;
  // The element with these values and the shape that the explanations say.
  // Fails where it has none that can be simulated.
  absl::StatusOr<TransferFunction> ElementOf(
      int input, const ElementValues& values,
      const std::vector<Explanation>& explanations) const;

  // The set points that move, where every record has set points.
  int num_moving_set_points() const {
    return static_cast<int>(moving_set_points_.size());
  }
  // One of them in a record, from its first value and by its range. Computed at
  // each call: p set points kept by each of p outputs would be many times the
  // records.
  Eigen::VectorXd SetPointMoves(int which, int record) const;
  // Responses that are kept for the next look are given back.
  void ForgetResponses() const { cache_.Clear(); }
  // An input as means of the rows.
  Eigen::VectorXd InputRows(int input) const;
  // A signal of all samples as means of the rows.
  Eigen::VectorXd RowMeans(const std::vector<Eigen::VectorXd>& signal) const;

 private:
  struct Element {
    int input = 0;
    ElementResponse response;
    bool in_model = true;  // if not, what a new path would be
  };
  // T and L of an element with another shape, and what it has besides.
  struct Shape {
    ElementValues values;
    double second = 0.0;  // lag
    double lead = 0.0;
  };
  struct MovingSetPoint {
    int number = 0;      // its row in Record::set_points
    double range = 0.0;  // the largest within a record
  };
  ExplainedOutput() = default;
  const Element* FindElement(int input) const;
  bool Applies(ExplanationKind kind, const Element& element,
               const std::vector<Explanation>& taken) const;
  void AddNewPaths(const ProcessModel& model);
  static Shape ShapeOf(const ElementValues& values, int input,
                       const std::vector<Explanation>& explanations);
  static absl::StatusOr<TransferFunction> Shaped(const Element& element,
                                                 const Shape& shape);
  void ChooseRows();
  void FindFirstValues();
  void BendOutput(const Explanation& curve, Eigen::VectorXd& z) const;
  void FindMovingSetPoints(int set_points);
  // The set point that a load of this part follows, or the mean of all.
  Eigen::VectorXd LoadOf(int part, int record) const;
  // The response for a gain of 1 at each sample of each record, and Σ K c of
  // elements as they are.
  std::vector<Eigen::VectorXd> Simulate(const Element& element,
                                        const ResponseKey& key) const;
  std::vector<Eigen::VectorXd> SimulatedBy(
      const std::vector<Element>& elements) const;
  Eigen::VectorXd InputOf(int input, int record, const ResponseKey& key) const;
  // Means of the samples of each row at which the output was measured.
  Eigen::VectorXd MeasuredMeans(const std::vector<Eigen::VectorXd>& z) const;

  const std::vector<Record>* records_ = nullptr;
  int output_ = 0;
  double sample_time_ = 0.0;
  double tau_ = 0.0;
  double longest_ = 0.0;
  bool integrating_ = false;
  int samples_a_row_ = 1;
  std::vector<int> inputs_;
  std::vector<Element> elements_;
  std::vector<ResidualRow> rows_;
  std::vector<Eigen::VectorXd> outputs_;  // of each record
  Eigen::VectorXd measured_;              // rows
  // Where output and inputs began in the first record.
  double first_level_ = 0.0;
  Eigen::VectorXd first_inputs_;
  // Inputs without gaps, their ranges, and largest distances from the first.
  std::shared_ptr<const FilledInputs> filled_;
  Eigen::VectorXd ranges_;
  Eigen::VectorXd distances_;
  std::vector<MovingSetPoint> moving_set_points_;
  double output_range_ = 1.0;
  double total_samples_ = 1.0;
  mutable ResponseCache cache_;  // rows of responses
};

}  // namespace mle

#endif  // MLE_EXPLAIN_EXPLAINED_OUTPUT_H_
