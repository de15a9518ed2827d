// Amplitudes that each segment has for itself, of modes, lines and steps: least
// squares by columns, and what they leave of others. Columns are whitened and
// scaled to one norm.
// Internal to mle/nonlinear.

#ifndef MLE_NONLINEAR_AMPLITUDE_FIT_H_
#define MLE_NONLINEAR_AMPLITUDE_FIT_H_

#include "Eigen/Core"
#include "Eigen/QR"

namespace mle {

// Columns of one norm that are nearer to each other than this are one: the
// relative threshold of a rank.
inline constexpr double kAmplitudeTolerance = 1e-9;

class AmplitudeFit {
 public:
  // `columns` (N × a); a may be 0, of an output without elements where nothing
  // else disturbs the segment.
  explicit AmplitudeFit(Eigen::MatrixXd columns);

  Eigen::Index rank() const { return scaled_.cols() > 0 ? qr_.rank() : 0; }
  // ln det of the normal matrix of as many columns as the rank.
  double LogDeterminant() const;
  // The shortest amplitudes (a) that fit best: columns that are one (equal time
  // constants) share, where a solve by pivots would blow them up against each
  // other.
  Eigen::VectorXd Solve(const Eigen::VectorXd& residuals) const;
  // Takes the amplitudes' part from `columns`, in place.
  void TakeOut(Eigen::Ref<Eigen::MatrixXd> columns) const;

 private:
  Eigen::VectorXd norms_;
  Eigen::MatrixXd scaled_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

}  // namespace mle

#endif  // MLE_NONLINEAR_AMPLITUDE_FIT_H_
