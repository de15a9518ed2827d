// Steps 1, 2 and 5 of an output's fit (output_fit.h): the search for dead times
// on a grid, and the refinement of its best, under a given noise shape.
// Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_OUTPUT_FITTER_H_
#define MLE_NONLINEAR_OUTPUT_FITTER_H_

#include <array>
#include <utility>
#include <vector>

#include "mle/nonlinear/box_least_squares.h"
#include "mle/nonlinear/delay_search.h"
#include "mle/nonlinear/output_error_correction.h"
#include "mle/nonlinear/output_error_problem.h"
#include "mle/nonlinear/output_fit.h"

namespace ceres {
class Problem;
}  // namespace ceres

namespace mle {

// The steps of one output's fit. The constructor's arguments must outlive it.
class Fitter {
 public:
  Fitter(const OutputErrorProblem& problem, const std::vector<bool>& free,
         const OutputFitBounds& bounds, const OutputErrorOptions& options)
      : problem_(problem), free_(free), bounds_(bounds), options_(options) {}

  const FitCertificate& certificate() const { return certificate_; }
  // Whether the last search found nothing better.
  void SetConfirmed(bool confirmed) {
    certificate_.search_confirmed = confirmed;
  }

  // Steps 1 and 2: from the best of several searches.
  OutputPoint Start(const OutputPoint& start, const NoiseShape& shape);

  DelaySearchResult Search(const OutputPoint& point, const NoiseShape& shape);
  // The objective of the solves. That of the search is less by what free
  // responses explain of noise that these take for one.
  double CostOf(const OutputPoint& point, const NoiseShape& shape) const;

  // Step 2, to about a hundredth of a standard deviation: all dead times,
  // unless `point` is near the optimum, then sample by sample. Returns the
  // cost.
  double RefineRoughly(OutputPoint& point, const NoiseShape& shape, bool near);
  // Step 5, from there.
  double RefineExactly(OutputPoint& point, const NoiseShape& shape);

  // Sets the certificate's gradient: derivatives at the end, in standard
  // deviations.
  void CertifyGradient(const OutputPoint& point, const NoiseEstimate& noise);

 private:
  // Bounds of K, ln T and L of an element.
  struct Box {
    std::array<double, 3> lower;
    std::array<double, 3> upper;
    std::array<double, 3> start;  // within them
    std::array<bool, 3> constant;
  };

  // Within the samples that the dead times lie in.
  double SolveWithinCells(OutputPoint& point, const NoiseShape& shape,
                          bool exact);
  // From a rough solve until Ceres finds no better point. Dead times whose cost
  // falls beyond an end of their sample stay there: Ceres' steps, projected on
  // bounds, would only creep towards the optimum of the others.
  double SolveExactly(OutputPoint& point, const NoiseShape& shape, double cost);
  // From sample to sample as long as the cost falls; returns it.
  double Move(OutputPoint& point, const NoiseShape& shape, bool exact,
              double cost);
  // The quadratic model of the squares at `point`, by K, ln T and L of the
  // elements of `by`.
  QuadraticModel ModelAt(const OutputPoint& point, const NoiseShape& shape,
                         const std::vector<bool>& by) const;
  // The dead times at an end of their sample beyond which the cost falls.
  std::vector<bool> AtEnds(const OutputPoint& point,
                           const NoiseShape& shape) const;
  // The ends of the sample that the dead time lies in, within its bounds.
  std::pair<double, double> DelaysOf(const OutputPoint& point, int j) const;
  // The end of that sample which the dead time is at: −1 or 1; 0: none.
  int EndOf(const OutputPoint& point, int j) const;
  std::vector<int> Moved() const;  // the elements that are free
  Box BoxOf(const OutputPoint& point, int j, bool within_cells,
            bool held) const;
  // Gauss and Newton's steps within bounds (box_least_squares.h), and
  // Levenberg–Marquardt by Ceres with those dead times held, from and to
  // `point`; they return the cost.
  double SolveRoughly(OutputPoint& point, const NoiseShape& shape,
                      bool within_cells);
  double SolveByCeres(OutputPoint& point, const NoiseShape& shape,
                      const std::vector<bool>& held);
  static void SetBounds(const Box& box, double* block, ceres::Problem& problem);
  // Takes each dead time at an end of its sample into the next one if the cost
  // falls there; false if none does.
  bool MoveCells(OutputPoint& point, const NoiseShape& shape) const;

  const OutputErrorProblem& problem_;
  const std::vector<bool>& free_;
  const OutputFitBounds& bounds_;
  const OutputErrorOptions& options_;
  FitCertificate certificate_;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_OUTPUT_FITTER_H_
