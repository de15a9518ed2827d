#include "control/matrix_series.h"

#include <algorithm>
#include <complex>
#include <numbers>

#include "mle/base/fast_length.h"
#include "unsupported/Eigen/FFT"

namespace mle::control {
namespace {

using Complex = std::complex<double>;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double kNegligibleCoefficient = 1e-10;  // of the largest coefficient

// Σ_{a≥1} w^a.
Complex GeometricSum(Complex w) { return w / (1.0 - w); }

}  // namespace

MatrixSeries::MatrixSeries(const MatrixXd& end, Eigen::Index degree)
    : rows_(end.rows()),
      end_(end.reshaped()),
      ends_in_zero_(end.isZero(0.0)),
      coefficients_(MatrixXd::Zero(degree, end.size())) {}

void MatrixSeries::SetTerm(Eigen::Index a, const MatrixXd& value) {
  coefficients_.row(a - 1) = (value.reshaped() - end_).transpose();
}

void MatrixSeries::Trim() {
  const double least =
      kNegligibleCoefficient * coefficients_.cwiseAbs().maxCoeff();
  Eigen::Index n = degree();
  while (n > 1 && coefficients_.row(n - 1).cwiseAbs().maxCoeff() <= least) {
    --n;
  }
  coefficients_.conservativeResize(n, Eigen::NoChange);
}

MatrixXcd MatrixSeries::operator()(const VectorXcd& powers) const {
  return Column(AtAll(powers), 0);
}

MatrixXcd MatrixSeries::AtAll(const Eigen::Ref<const MatrixXcd>& powers) const {
  const auto needed = powers.topRows(degree());
  MatrixXcd values(coefficients_.cols(), powers.cols());
  values.real() = coefficients_.transpose() * needed.real();
  values.imag() = coefficients_.transpose() * needed.imag();
  for (Eigen::Index k = 0; !ends_in_zero_ && k < powers.cols(); ++k) {
    values.col(k) += GeometricSum(powers(0, k)) * end_;
  }
  return values;
}

MatrixXcd MatrixSeries::OnHalfCircle(double radius, int n) const {
  MatrixXcd values(coefficients_.cols(), n + 1);
  Eigen::FFT<double> transform;
  VectorXd folded(2 * n);
  VectorXcd spectrum;
  for (Eigen::Index entry = 0; entry < coefficients_.cols(); ++entry) {
    if (coefficients_.col(entry).isZero(0.0)) {
      values.row(entry).setZero();
      continue;
    }
    folded.setZero();
    double power = 1.0;
    for (Eigen::Index a = 1; a <= degree(); ++a) {
      power *= radius;
      folded(a % (2 * n)) += power * coefficients_(a - 1, entry);
    }
    transform.fwd(spectrum, folded);
    values.row(entry) = spectrum.head(n + 1).adjoint();
  }
  for (int k = 0; !ends_in_zero_ && k <= n; ++k) {
    values.col(k) +=
        GeometricSum(std::polar(radius, std::numbers::pi * k / n)) * end_;
  }
  return values;
}

MatrixXcd MatrixSeries::Column(const MatrixXcd& values, Eigen::Index k) const {
  return values.col(k).reshaped(rows_, values.rows() / rows_);
}

MatrixSeries MatrixSeries::Ahead(const MatrixXd& gain) const {
  const Eigen::Index p = rows_;
  const Eigen::Index m = entries() / p;
  const Eigen::Index h = gain.cols() / p;
  const int length = 2 * FastLength(static_cast<int>((degree() + h + 1) / 2));
  Eigen::FFT<double> transform;
  transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  VectorXd padded = VectorXd::Zero(length);
  VectorXcd spectrum;
  MatrixXcd of_gain(length / 2 + 1, gain.rows());
  MatrixXcd sums = MatrixXcd::Zero(length / 2 + 1, gain.rows() * m);
  for (Eigen::Index o = 0; o < p; ++o) {
    for (Eigen::Index r = 0; r < gain.rows(); ++r) {
      for (Eigen::Index i = 0; i < h; ++i) padded(i) = gain(r, o + p * i);
      padded.tail(length - h).setZero();
      transform.fwd(spectrum, padded);
      of_gain.col(r) = spectrum.conjugate();
    }
    for (Eigen::Index j = 0; j < m; ++j) {
      const auto coefficients = coefficients_.col(o + p * j);
      if (coefficients.isZero(0.0)) continue;
      padded.head(degree()) = coefficients;
      padded.tail(length - degree()).setZero();
      transform.fwd(spectrum, padded);
      for (Eigen::Index r = 0; r < gain.rows(); ++r) {
        sums.col(r + gain.rows() * j).array() +=
            of_gain.col(r).array() * spectrum.array();
      }
    }
  }
  MatrixSeries result(gain * end_.reshaped(p, m).replicate(h, 1),
                      std::max<Eigen::Index>(degree() - 1, 1));
  for (Eigen::Index entry = 0; entry < sums.cols(); ++entry) {
    spectrum = sums.col(entry);
    transform.inv(padded, spectrum, length);
    result.coefficients_.col(entry) =
        padded.segment(1, result.coefficients_.rows());
  }
  return result;
}

}  // namespace mle::control
