#include "control/matrix_series.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "mle/base/fast_length.h"
#include "unsupported/Eigen/FFT"

namespace mle::control {
namespace {

using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXcd;
using Eigen::VectorXd;

constexpr double kNegligibleCoefficient = 1e-10;  // of the largest coefficient

}  // namespace

MatrixSeries::MatrixSeries(Eigen::Index rows, Eigen::Index columns,
                           Eigen::Index degree)
    : rows_(rows),
      columns_(columns),
      places_(rows * columns),
      coefficients_(MatrixXd::Zero(degree, rows * columns)) {
  std::iota(places_.begin(), places_.end(), 0);
}

void MatrixSeries::SetTerm(Eigen::Index a, const MatrixXd& value) {
  coefficients_.row(a - 1) = value.reshaped().transpose();
}

void MatrixSeries::Trim() {
  const double least =
      kNegligibleCoefficient * coefficients_.cwiseAbs().maxCoeff();
  Eigen::Index n = degree();
  while (n > 1 && coefficients_.row(n - 1).cwiseAbs().maxCoeff() <= least) {
    --n;
  }
  std::vector<Eigen::Index> kept;
  for (Eigen::Index entry = 0; entry < entries(); ++entry) {
    if (!coefficients_.col(entry).isZero(0.0)) kept.push_back(entry);
  }
  coefficients_ = MatrixXd(coefficients_(Eigen::seqN(0, n), kept));
  for (Eigen::Index& entry : kept) entry = places_[entry];
  places_ = std::move(kept);
}

MatrixXcd MatrixSeries::operator()(const VectorXcd& powers) const {
  return Matrix(AtAll(powers).col(0));
}

MatrixXcd MatrixSeries::AtAll(const Eigen::Ref<const MatrixXcd>& powers) const {
  // Side by side: the coefficients are read once.
  const Eigen::Index count = powers.cols();
  MatrixXd parts(degree(), 2 * count);
  parts.leftCols(count) = powers.topRows(degree()).real();
  parts.rightCols(count) = powers.topRows(degree()).imag();
  const MatrixXd products = coefficients_.transpose() * parts;
  MatrixXcd values(entries(), count);
  values.real() = products.leftCols(count);
  values.imag() = products.rightCols(count);
  return values;
}

MatrixXcd MatrixSeries::OnHalfCircle(double radius, int n) const {
  MatrixXcd values(entries(), n + 1);
  Eigen::FFT<double> transform;
  VectorXd folded(2 * n);
  VectorXcd spectrum;
  for (Eigen::Index entry = 0; entry < entries(); ++entry) {
    folded.setZero();
    double power = 1.0;
    for (Eigen::Index a = 1; a <= degree(); ++a) {
      power *= radius;
      folded(a % (2 * n)) += power * coefficients_(a - 1, entry);
    }
    transform.fwd(spectrum, folded);
    values.row(entry) = spectrum.head(n + 1).adjoint();
  }
  return values;
}

MatrixXcd MatrixSeries::Matrix(
    const Eigen::Ref<const VectorXcd>& entries) const {
  MatrixXcd matrix = MatrixXcd::Zero(rows_, columns_);
  matrix.reshaped()(places_) = entries;
  return matrix;
}

MatrixSeries MatrixSeries::Ahead(const MatrixXd& gain) const {
  const Eigen::Index p = rows_;
  const Eigen::Index m = gain.rows();
  const Eigen::Index h = gain.cols() / p;
  const int length = 2 * FastLength(static_cast<int>((degree() + h + 1) / 2));
  Eigen::FFT<double> transform;
  transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  VectorXd padded = VectorXd::Zero(length);
  VectorXcd spectrum;
  MatrixXcd of_gain(length / 2 + 1, m);
  MatrixXcd sums = MatrixXcd::Zero(length / 2 + 1, m * columns_);
  for (Eigen::Index o = 0; o < p; ++o) {
    for (Eigen::Index r = 0; r < m; ++r) {
      for (Eigen::Index i = 0; i < h; ++i) padded(i) = gain(r, o + p * i);
      padded.tail(length - h).setZero();
      transform.fwd(spectrum, padded);
      of_gain.col(r) = spectrum.conjugate();
    }
    for (Eigen::Index entry = 0; entry < entries(); ++entry) {
      if (places_[entry] % p != o) continue;
      padded.head(degree()) = coefficients_.col(entry);
      padded.tail(length - degree()).setZero();
      transform.fwd(spectrum, padded);
      const Eigen::Index j = places_[entry] / p;
      for (Eigen::Index r = 0; r < m; ++r) {
        sums.col(r + m * j).array() +=
            of_gain.col(r).array() * spectrum.array();
      }
    }
  }
  MatrixSeries result(m, columns_, std::max<Eigen::Index>(degree() - 1, 1));
  for (Eigen::Index entry = 0; entry < sums.cols(); ++entry) {
    spectrum = sums.col(entry);
    transform.inv(padded, spectrum, length);
    result.coefficients_.col(entry) =
        padded.segment(1, result.coefficients_.rows());
  }
  result.Trim();
  return result;
}

}  // namespace mle::control
