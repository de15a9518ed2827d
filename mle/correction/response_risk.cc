#include "mle/correction/response_risk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Variances are computed at about this many samples of a step response, which
// stand for their neighbours.
constexpr int kSamples = 45;
// A pivot below this part of a column's square is rounding.
constexpr double kDependent = 1e-12;
// A step response that grows by this factor when followed so many times as long
// does not settle; one that is larger by it than that of R is out of bounds.
constexpr int kFollowed = 4;
constexpr double kGrowth = 10.0;

// H(0) … H(last), each p × p.
std::vector<MatrixXd> FeedbackResponse(const ArxModel& model, int last) {
  const int p = model.num_outputs;
  const int channels = p + model.num_inputs;
  std::vector<MatrixXd> response;
  for (int k = 0; k <= last; ++k) {
    MatrixXd H = MatrixXd::Zero(p, p);
    if (k == 0) H.setIdentity();
    for (int lag = 1; lag <= std::min(k, model.order); ++lag) {
      H.noalias() += model.R.middleCols((lag - 1) * channels, p) *
                     response[static_cast<std::size_t>(k - lag)];
    }
    response.push_back(std::move(H));
  }
  return response;
}

// x(t) of t = 0 … last after a unit step of the input at 0 (a row each).
MatrixXd StepRegressors(const ArxModel& model, const StepResponse& steps,
                        int input, int last) {
  const int p = model.num_outputs;
  const int channels = p + model.num_inputs;
  MatrixXd regressors = MatrixXd::Zero(last + 1, model.num_regressors());
  for (int lag = 1; lag <= std::min(last, model.order); ++lag) {
    const int rows = last + 1 - lag;
    const int first = (lag - 1) * channels;
    for (int i = 0; i < p; ++i) {
      regressors.col(first + i).tail(rows) = steps.element(i, input).head(rows);
    }
    regressors.col(first + p + input).tail(rows).setOnes();
  }
  return regressors;
}

// The first `samples` of a model's step responses; none if, followed further,
// they grow: it is unstable.
std::optional<StepResponse> SettlingResponse(const ArxModel& model,
                                             int samples) {
  StepResponse response = model.ComputeStepResponse(kFollowed * samples);
  const double size = response.values.topRows(samples).cwiseAbs().maxCoeff();
  if (!(response.values.cwiseAbs().maxCoeff() <= kGrowth * size)) {
    return std::nullopt;
  }
  response.values.conservativeResize(samples, Eigen::NoChange);
  return response;
}

// Whether the pivots are more than rounding.
bool IsIndependent(const Eigen::LLT<MatrixXd>& factor, const MatrixXd& gram) {
  if (factor.info() != Eigen::Success) return false;
  const MatrixXd& L = factor.matrixLLT();
  for (Index i = 0; i < L.rows(); ++i) {
    if (!(L(i, i) * L(i, i) > kDependent * gram(i, i))) return false;
  }
  return true;
}

}  // namespace

MatrixXd StepResponseSensitivity(const ArxModel& model, int q,
                                 const std::vector<int>& samples) {
  const int last = samples.back();
  const auto count = static_cast<Index>(samples.size());
  const std::vector<MatrixXd> feedback = FeedbackResponse(model, last);
  const StepResponse steps = model.ComputeStepResponse(last + 1);
  MatrixXd sensitivity(count * model.num_outputs * model.num_inputs,
                       model.num_regressors());
  Index row = 0;
  for (int j = 0; j < model.num_inputs; ++j) {
    const MatrixXd regressors = StepRegressors(model, steps, j, last);
    for (int i = 0; i < model.num_outputs; ++i) {
      MatrixXd convolution = MatrixXd::Zero(count, last + 1);
      for (Index n = 0; n < count; ++n) {
        const int k = samples[static_cast<std::size_t>(n)];
        for (int t = 0; t <= k; ++t) {
          convolution(n, t) = feedback[static_cast<std::size_t>(k - t)](i, q);
        }
      }
      sensitivity.middleRows(row, count).noalias() = convolution * regressors;
      row += count;
    }
  }
  return sensitivity;
}

ResponseRisk::ResponseRisk(const ArxModel& initial, const LassoProblem& problem,
                           int samples)
    : initial_(initial), problem_(problem), samples_(samples) {}

bool ResponseRisk::FitLeastSquares(const MatrixXd& penalty_weights,
                                   std::vector<LeastSquares>& fits) {
  const auto rows = static_cast<double>(problem_.rows);
  noise_.resize(problem_.num_responses());
  for (int q = 0; q < problem_.num_responses(); ++q) {
    LeastSquares fit;
    for (int j = 0; j < problem_.num_regressors(); ++j) {
      const bool held =
          penalty_weights.size() > 0 && std::isinf(penalty_weights(q, j));
      if (problem_.scale(j) > 0.0 && !held) fit.columns.push_back(j);
    }
    const double freedom = rows - static_cast<double>(fit.columns.size());
    if (fit.columns.empty() || !(freedom > 0.0)) return false;
    const MatrixXd gram = problem_.gram(fit.columns, fit.columns);
    fit.factor.compute(gram);
    if (!IsIndependent(fit.factor, gram)) return false;
    const VectorXd correlation = problem_.correlation.col(q)(fit.columns);
    fit.beta = fit.factor.solve(correlation);
    // A difference, whose rounding may be negative where the fit is exact.
    const double residual =
        std::max(problem_.response_square(q) -
                     fit.beta.dot(2.0 * correlation - gram * fit.beta),
                 0.0);
    noise_(q) = residual / freedom;
    fits.push_back(std::move(fit));
  }
  return true;
}

std::optional<ResponseRisk> ResponseRisk::Create(
    const ArxModel& initial, const LassoProblem& problem,
    const MatrixXd& penalty_weights, int samples) {
  ResponseRisk risk(initial, problem, samples);
  std::vector<LeastSquares> fits;
  if (!risk.FitLeastSquares(penalty_weights, fits)) return std::nullopt;
  ArxModel model = initial;
  for (std::size_t q = 0; q < fits.size(); ++q) {
    for (std::size_t a = 0; a < fits[q].columns.size(); ++a) {
      const int j = fits[q].columns[a];
      model.R(static_cast<Index>(q), j) +=
          fits[q].beta(static_cast<Index>(a)) / problem.scale(j);
    }
  }
  // It may be unstable, as under drift, but not within these samples.
  risk.least_squares_ = model.ComputeStepResponse(samples);
  const auto size = [](const StepResponse& response) {
    return response.values.cwiseAbs().maxCoeff();
  };
  if (!(size(risk.least_squares_) <=
        kGrowth * size(initial.ComputeStepResponse(samples)))) {
    return std::nullopt;
  }

  std::vector<int> kept;
  const int stride = std::max(samples / kSamples, 1);
  for (int k = 0; k < samples; k += stride) kept.push_back(k);
  const VectorXd unscale = problem.Unscale(VectorXd::Ones(initial.R.cols()));
  MatrixXd covariance;
  for (std::size_t q = 0; q < fits.size(); ++q) {
    MatrixXd J =
        StepResponseSensitivity(model, static_cast<int>(q), kept) *
        (std::sqrt(static_cast<double>(stride)) * unscale).asDiagonal();
    MatrixXd half = J(Eigen::all, fits[q].columns).transpose();
    fits[q].factor.matrixL().solveInPlace(half);
    if (covariance.size() == 0) covariance.setZero(J.rows(), J.rows());
    covariance.noalias() +=
        risk.noise_(static_cast<Index>(q)) * half.transpose() * half;
    risk.sensitivity_.push_back(std::move(J));
  }
  risk.variance_ = covariance.trace();
  risk.deviation_ = std::sqrt(2.0) * covariance.norm();
  if (!(risk.deviation_ < risk.least_squares_.values.squaredNorm())) {
    return std::nullopt;
  }
  return risk;
}

double ResponseRisk::VarianceOf(int q, const std::vector<int>& active) const {
  if (active.empty()) return 0.0;
  const Eigen::LLT<MatrixXd> factor(problem_.gram(active, active));
  if (factor.info() != Eigen::Success) return 0.0;
  MatrixXd half =
      sensitivity_[static_cast<std::size_t>(q)](Eigen::all, active).transpose();
  factor.matrixL().solveInPlace(half);
  return noise_(q) * half.squaredNorm();
}

double ResponseRisk::operator()(absl::Span<const LassoSolution> fits,
                                double lambda) const {
  ArxModel model = initial_;
  double variance = 0.0;
  for (std::size_t q = 0; q < fits.size(); ++q) {
    const auto row = static_cast<Index>(q);
    std::vector<int> active;
    fits[q].path.VisitCoefficients(lambda, [&](int j, double beta) {
      if (beta == 0.0) return;
      active.push_back(j);
      model.R(row, j) += beta / problem_.scale(j);
    });
    variance += VarianceOf(static_cast<int>(q), active);
  }
  const std::optional<StepResponse> response =
      SettlingResponse(model, samples_);
  if (!response.has_value()) return std::numeric_limits<double>::infinity();
  return SquaredDistance(least_squares_, *response) + 2.0 * variance -
         variance_;
}

}  // namespace mle
