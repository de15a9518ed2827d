#include "mle/regression/row_certificate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "mle/base/double_limits.h"
#include "mle/regression/active_columns.h"
#include "mle/regression/kernels/kernels.h"

namespace mle {
namespace {

// A relative gap that the rounding of G may add without being looked at.
constexpr double kSmall = 1e-10;
// Above this a fit counts as not exact.
constexpr double kExact = 1e-9;
// The number of open values of λ whose rows are looked at first, and of those
// added where the bounds of their neighbours do not suffice.
constexpr std::size_t kMostLookedAt = 12;
constexpr int kMoreLookedAt = 100;
// Values of λ that share a bound.
constexpr Eigen::Index kTogether = 64;

struct Gradient {
  Eigen::VectorXd c;
  double square = 0.0;  // ‖r‖²/N
};

class RowGaps {
 public:
  RowGaps(absl::Span<const RegressionRows> rows, const LassoProblem& problem,
          int response, const LassoObjective& objective)
      : rows_(rows),
        problem_(problem),
        response_(response),
        objective_(objective) {
    const double total = static_cast<double>(problem.rows);
    const Eigen::ArrayXd part = problem.group_rows.array() / total;
    const Eigen::ArrayXd inverse =
        (problem.scale.array() > 0.0)
            .select(problem.scale.array().inverse(), 0.0);
    root_ = (problem.gram.diagonal().array().max(0.0) +
             (problem.regressor_mean.array().square().matrix() * part.matrix())
                     .array() *
                 inverse.square())
                .sqrt();
    response_root_ = std::sqrt(
        objective.response_square +
        (problem.response_mean.row(response).transpose().array().square() *
         part)
            .sum());
  }

  Gradient FromRows(const Eigen::VectorXd& beta) const;
  // The same of the Gram matrix; but for the square.
  Eigen::VectorXd FromGram(const Eigen::VectorXd& beta) const;
  DualityGap Gap(double lambda, const Eigen::VectorXd& beta,
                 const Gradient& gradient) const {
    const Eigen::VectorXd rounding =
        8.0 * kEpsilon * std::sqrt(gradient.square) * root_;
    return GapOfGradient(objective_, lambda, beta, gradient.c, gradient.square,
                         rounding);
  }
  // D.
  double GramRounding(const Eigen::VectorXd& beta) const {
    return RoundingOf(response_root_ + root_.dot(beta.cwiseAbs()));
  }
  // No less than D for any β with this Σ w|β|, where all weights are above 0.
  double MostGramRounding(double norm) const {
    return RoundingOf(response_root_ + Largest(root_) * norm);
  }
  // max_j |x_j| / w_j.
  double Largest(const Eigen::VectorXd& x) const {
    double largest = 0.0;
    for (Eigen::Index j = 0; j < x.size(); ++j) {
      const double w = objective_.weights(j);
      if (w > 0.0 && std::isfinite(w)) {
        largest = std::max(largest, std::abs(x(j)) / w);
      }
    }
    return largest;
  }

 private:
  double RoundingOf(double sum) const {
    const double terms =
        static_cast<double>(problem_.rows) + static_cast<double>(root_.size());
    return 2.0 * kEpsilon * std::sqrt(terms) * sum * Largest(root_);
  }

  absl::Span<const RegressionRows> rows_;
  const LassoProblem& problem_;
  int response_;
  const LassoObjective& objective_;
  Eigen::VectorXd root_;  // m_j
  double response_root_ = 0.0;
};

// In two parts, high + low.
struct Twice {
  Eigen::VectorXd high;
  Eigen::VectorXd low;
};

// β_j / scale_j of the active ones.
Twice Unscaled(const Eigen::VectorXd& beta, const Eigen::VectorXd& scale,
               const std::vector<int>& active) {
  Twice b;
  b.high.resize(static_cast<Eigen::Index>(active.size()));
  b.low.resize(b.high.size());
  for (Eigen::Index i = 0; i < b.high.size(); ++i) {
    const int j = active[i];
    b.high(i) = beta(j) / scale(j);
    b.low(i) = std::fma(-b.high(i), scale(j), beta(j)) / scale(j);
  }
  return b;
}

// e_k − Σ_j b_j x_jk for the rows of one part.
Twice Residual(const RegressionRows& part, int response,
               const std::vector<int>& active, const Twice& b) {
  const auto X = part.series->Regressors(part.rows);
  Eigen::MatrixXd columns(X.cols(), static_cast<Eigen::Index>(active.size()));
  for (std::size_t i = 0; i < active.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = X.row(active[i]).transpose();
  }
  std::vector<int> all(active.size());
  std::iota(all.begin(), all.end(), 0);
  const ColumnSet set = {columns.data(), columns.rows(), all.data(),
                         columns.cols()};
  Twice r = {part.responses.row(response).transpose(),
             Eigen::VectorXd::Zero(X.cols())};
  VectorKernels().subtract_columns_twice(set, b.high.data(), r.high.size(),
                                         r.high.data(), r.low.data());
  r.low.noalias() -= columns * b.low;
  return r;
}

Gradient RowGaps::FromRows(const Eigen::VectorXd& beta) const {
  std::vector<int> active;
  for (int j = 0; j < beta.size(); ++j) {
    if (beta(j) != 0.0 && problem_.scale(j) > 0.0) active.push_back(j);
  }
  const Twice b = Unscaled(beta, problem_.scale, active);
  std::vector<Twice> residuals;
  std::vector<long double> sums(problem_.group_rows.size(), 0.0L);
  for (const RegressionRows& part : rows_) {
    residuals.push_back(Residual(part, response_, active, b));
    for (Eigen::Index k = 0; k < residuals.back().high.size(); ++k) {
      sums[part.group] += residuals.back().high(k);
      sums[part.group] += residuals.back().low(k);
    }
  }
  const bool centred = (problem_.regressor_mean.array() != 0.0).any() ||
                       (problem_.response_mean.array() != 0.0).any();
  Gradient gradient;
  gradient.c.setZero(beta.size());
  for (std::size_t p = 0; p < rows_.size(); ++p) {
    const int group = rows_[p].group;
    const long double mean =
        centred
            ? sums[group] / static_cast<long double>(problem_.group_rows(group))
            : 0.0L;
    const auto high = static_cast<double>(mean);
    const auto low = static_cast<double>(mean - high);
    const Eigen::VectorXd r =
        (residuals[p].high.array() - high) + (residuals[p].low.array() - low);
    gradient.square += r.squaredNorm();
    gradient.c += rows_[p].series->Regressors(rows_[p].rows) * r;
  }
  const double total = static_cast<double>(problem_.rows);
  gradient.square /= total;
  for (Eigen::Index j = 0; j < gradient.c.size(); ++j) {
    gradient.c(j) = problem_.scale(j) > 0.0
                        ? gradient.c(j) / (total * problem_.scale(j))
                        : 0.0;
  }
  return gradient;
}

Eigen::VectorXd RowGaps::FromGram(const Eigen::VectorXd& beta) const {
  std::vector<int> active;
  for (int j = 0; j < beta.size(); ++j) {
    if (beta(j) != 0.0) active.push_back(j);
  }
  const Eigen::VectorXd values = beta(active);
  Eigen::VectorXd c = objective_.correlation;
  Eigen::VectorXd low = Eigen::VectorXd::Zero(beta.size());
  VectorKernels().subtract_columns_twice(
      ActiveColumns(*objective_.gram, active), values.data(), beta.size(),
      c.data(), low.data());
  return c + low;
}

// An upper bound of what a `difference` of c adds to a relative gap. `square`
// may be less than ‖r‖²/N.
double Added(double difference, double lambda, double penalty, double square) {
  const double part = difference / lambda;
  const double primal = 0.5 * square + penalty;
  if (!(primal > 0.0)) return 0.0;
  return 2.0 * part * penalty / primal + part * part;
}

// Σ w_j |β_j|.
double Norm(const LassoObjective& objective, const Eigen::VectorXd& beta) {
  double sum = 0.0;
  for (Eigen::Index j = 0; j < beta.size(); ++j) {
    if (beta(j) != 0.0) sum += objective.weights(j) * std::abs(beta(j));
  }
  return sum;
}

class Certifier {
 public:
  Certifier(RowGaps gaps, const LassoObjective& objective,
            LassoSolution& solution)
      : gaps_(std::move(gaps)), objective_(objective), solution_(solution) {}

  // Adds what the rounding of G may add where that is small; the others stay
  // open.
  void AddBounds();
  void LookAtRows();

 private:
  // Makes the gap of an open value that of the rows; max |δc_j|/w_j there.
  double Look(std::size_t at);
  // Bounds the open values between two that were looked at by the larger of the
  // differences there, or looks at more of them.
  void BoundBetween(std::size_t first, double first_difference,
                    std::size_t last, double last_difference);
  // The most that `difference` adds to the relative gap of an open value.
  double AddedAt(std::size_t at, double difference) const;

  RowGaps gaps_;
  const LassoObjective& objective_;
  LassoSolution& solution_;
  double least_square_ = -1.0;  // ‖r‖²/N at the least λ: it grows with λ
  std::vector<Eigen::Index> open_;
  int more_ = kMoreLookedAt;
  double beyond_ = 0.0;
};

void Certifier::AddBounds() {
  const Eigen::VectorXd& lambdas = solution_.lambdas;
  // Σ w|β| falls with λ, so that one bound serves many values; but β without
  // weight is not part of it.
  const bool one_for_many = objective_.weights.minCoeff() > 0.0;
  Eigen::Index end = 0;
  for (Eigen::Index i = 0; i < lambdas.size(); i = end) {
    end = i + 1;
    if (lambdas(i) == 0.0 || !std::isfinite(solution_.relative_gap(i))) {
      continue;
    }
    const Eigen::VectorXd beta = solution_.path.Coefficients(lambdas(i));
    if (least_square_ < 0.0) least_square_ = gaps_.FromRows(beta).square;
    const double norm = Norm(objective_, beta);
    const auto added = [&](double rounding) {
      return Added(rounding, lambdas(i), lambdas(i) * norm, least_square_);
    };
    const double of_all = added(gaps_.MostGramRounding(norm));
    const double of_one = added(gaps_.GramRounding(beta));
    if (one_for_many && of_all <= kSmall) {
      end = std::min(i + kTogether, lambdas.size());
      solution_.relative_gap.segment(i, end - i).array() += of_all;
    } else if (of_one <= kSmall) {
      solution_.relative_gap(i) += of_one;
    } else {
      open_.push_back(i);
    }
  }
}

void Certifier::LookAtRows() {
  if (open_.empty()) return;
  const std::size_t stride = open_.size() / kMostLookedAt + 1;
  std::size_t at = 0;
  double difference = Look(at);
  while (at + 1 < open_.size()) {
    const std::size_t next = std::min(at + stride, open_.size() - 1);
    const double next_difference = Look(next);
    BoundBetween(at, difference, next, next_difference);
    at = next;
    difference = next_difference;
  }
  if (beyond_ > 0.0) {
    absl::StrAppendFormat(
        &solution_.report,
        "; λ up to %.3g are beyond double precision: relative "
        "gap of the rows ≤ %.2g",
        beyond_, solution_.MaxRelativeGap());
  }
}

double Certifier::Look(std::size_t at) {
  const double lambda = solution_.lambdas(open_[at]);
  const Eigen::VectorXd beta = solution_.path.Coefficients(lambda);
  const Gradient gradient = gaps_.FromRows(beta);
  double& stated = solution_.relative_gap(open_[at]);
  const double gap = gaps_.Gap(lambda, beta, gradient).Relative();
  if (gap > kExact && stated <= kExact) beyond_ = std::max(beyond_, lambda);
  stated = gap;
  return gaps_.Largest(gradient.c - gaps_.FromGram(beta));
}

double Certifier::AddedAt(std::size_t at, double difference) const {
  const double lambda = solution_.lambdas(open_[at]);
  const double penalty =
      lambda * Norm(objective_, solution_.path.Coefficients(lambda));
  return Added(difference, lambda, penalty, least_square_);
}

void Certifier::BoundBetween(std::size_t first, double first_difference,
                             std::size_t last, double last_difference) {
  if (last - first < 2) return;
  const double most = 2.0 * std::max(first_difference, last_difference);
  std::vector<double> added;
  for (std::size_t at = first + 1; at < last; ++at) {
    added.push_back(AddedAt(at, most));
  }
  if (more_ > 0 &&
      *std::max_element(added.begin(), added.end()) > 0.5 * kExact) {
    --more_;
    const std::size_t middle = first + (last - first) / 2;
    const double difference = Look(middle);
    BoundBetween(first, first_difference, middle, difference);
    BoundBetween(middle, difference, last, last_difference);
    return;
  }
  for (std::size_t at = first + 1; at < last; ++at) {
    const double more = added[at - first - 1];
    solution_.relative_gap(open_[at]) += more;
    if (more > kExact) {
      beyond_ = std::max(beyond_, solution_.lambdas(open_[at]));
    }
  }
}

}  // namespace

DualityGap GapOfRows(absl::Span<const RegressionRows> rows,
                     const LassoProblem& problem, int response,
                     const LassoObjective& objective, double lambda,
                     const Eigen::VectorXd& beta) {
  const RowGaps gaps(rows, problem, response, objective);
  return gaps.Gap(lambda, beta, gaps.FromRows(beta));
}

void CertifyByRows(absl::Span<const RegressionRows> rows,
                   const LassoProblem& problem, int response,
                   const LassoObjective& objective, LassoSolution& solution) {
  // A response without variation: β = 0 whatever the rows.
  if (objective.response_square == 0.0) return;
  Certifier certifier(RowGaps(rows, problem, response, objective), objective,
                      solution);
  certifier.AddBounds();
  certifier.LookAtRows();
}

}  // namespace mle
