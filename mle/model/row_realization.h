// One output of a process model as an exact discrete system, with factors of
// its gramians, for balanced_reduction.h.
//
// Element j of the row, its dead time d_j samples longer than those taken out
// of inputs and outputs, is x_j(k+1) = A_j x_j(k) + b_j v_j(k)
// (held_response.h, with one state more for the input of the sample before,
// where a dead time is not a whole number of samples or the element has
// feedthrough). One line of D = max_j d_j samples delays the outputs of all:
//
//   s_i(k+1) = s_{i+1}(k) + Σ_{j: d_j = i} c_j x_j(k),   i = 1 … D,
//
//   y(k) = s_1(k) + Σ_{j: d_j = 0} c_j x_j(k),
//
// with s_{D+1} = 0.
// States are s_1 … s_D, then the x_j: n in all. With W = Σ_t (C A^t)ᵀ(C A^t)
// and P = Σ_t (A^t B)(A^t B)ᵀ,
//
//   W = Rᵀ R,   P = L Lᵀ,
//
// where R and L follow from those of the elements (n × n at most), found by
// doubling: Σ_{t<2T} from Σ_{t<T} and A^T (Smith, SIAM J. Appl. Math. 16,
// 1968), with factors in place of sums, so that no digits are lost to squares.
// Internal to the project.

#ifndef MLE_MODEL_ROW_REALIZATION_H_
#define MLE_MODEL_ROW_REALIZATION_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/model/held_response.h"

namespace mle {

// An element of the row: its system and the samples of dead time that remain.
struct RowElement {
  Eigen::MatrixXd A;     // r × r
  Eigen::VectorXd b;     // r
  Eigen::RowVectorXd c;  // r
  int delay = 0;         // d_j ≥ 0

  // Without any dead time.
  static RowElement Of(const HeldResponse& response);
};

struct RowRealization {
  Eigen::MatrixXd A;                       // n × n
  Eigen::MatrixXd B;                       // n × number of elements
  Eigen::RowVectorXd C;                    // n
  Eigen::MatrixXd observability_factor;    // R, n columns
  Eigen::MatrixXd controllability_factor;  // L, n rows

  // `elements`: at least one, each stable.
  static RowRealization Of(const std::vector<RowElement>& elements);
};

}  // namespace mle

#endif  // MLE_MODEL_ROW_REALIZATION_H_
