// The responses of several elements of one output and their derivatives, row by
// row: elements of first order, which most are, side by side in vectors
// (kernels.h), others one after the other. Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_RESPONSE_ROWS_H_
#define MLE_NONLINEAR_RESPONSE_ROWS_H_

#include <vector>

#include "Eigen/Core"
#include "mle/nonlinear/output_error_problem.h"

namespace mle {

class ResponseRows {
 public:
  // `elements` are numbers of the problem's, in order; `problem` must outlive
  // it.
  ResponseRows(const OutputErrorProblem& problem, std::vector<int> elements);

  Eigen::Index count() const { return std::ssize(elements_); }

  // Begins at the first sample of a segment's inputs.
  void Start(const OutputErrorProblem::Segment& segment,
             const OutputPoint& point, bool derivatives);
  // At `count` samples, of which `times` are the numbers, later ones at each
  // call: rest (count) −= Σ K y. With derivatives in each of as many rows,
  // `stride` numbers from one to the next, −y, −∂Ky/∂ln T and −∂Ky/∂L of all
  // elements, in the order of places().
  void Next(const int* times, Eigen::Index count, double* rest, double* rows,
            Eigen::Index stride);

  // The places of each element's three columns in a row of 3 count(): those by
  // K, ln T and L in turn.
  const std::vector<Eigen::Index>& places() const { return places_; }

 private:
  // The next `samples`, without a gap.
  void Run(Eigen::Index samples, double* rest, double* rows,
           Eigen::Index stride);

  const OutputErrorProblem& problem_;
  std::vector<int> elements_;
  std::vector<ElementRun> runs_;  // of each element
  std::vector<double> gains_;
  bool derivatives_ = false;
  int next_ = 0;  // sample
  // Where each element is among those side by side, then the others.
  std::vector<Eigen::Index> order_;
  std::vector<Eigen::Index> places_;
  Eigen::Index num_side_by_side_ = 0;
  RowMajorMatrix numbers_;
  Eigen::VectorXd state_;
  RowMajorMatrix inputs_;
  Eigen::MatrixXd piece_;   // of one of the others
  RowMajorMatrix scratch_;  // rows with gaps between them
  Eigen::VectorXd scratch_rest_;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_RESPONSE_ROWS_H_
