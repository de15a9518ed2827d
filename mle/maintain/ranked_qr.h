// Orthonormal columns that span those of a tall matrix, as many as its rank:
//
//   C = Q₁ R,   R P = Q₂ R₂,   basis: the first rank columns of Q₁ Q₂,
//
// the first factor in blocks, the second of the triangle alone and with column
// pivots, from which the rank is read: Eigen's QR with pivots goes through the
// tall matrix once for each column. O(N n²) operations for N × n.

#ifndef MLE_MAINTAIN_RANKED_QR_H_
#define MLE_MAINTAIN_RANKED_QR_H_

#include "Eigen/Core"
#include "Eigen/QR"

namespace mle {

class RankedQr {
 public:
  // Pivots below `threshold` times the largest do not count.
  RankedQr(const Eigen::MatrixXd& columns, double threshold);

  Eigen::Index rank() const { return of_triangle_.rank(); }
  // N × rank.
  Eigen::MatrixXd Basis() const;
  // Squares that the columns leave of a vector (N).
  double SquaresLeft(Eigen::VectorXd of) const;

 private:
  Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> of_triangle_;
};

}  // namespace mle

#endif  // MLE_MAINTAIN_RANKED_QR_H_
