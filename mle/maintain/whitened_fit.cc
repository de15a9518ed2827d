#include "mle/maintain/whitened_fit.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "Eigen/Cholesky"
#include "mle/data/lagged_series.h"
#include "mle/regression/lagged_products.h"

namespace mle {
namespace {

constexpr int kMostRounds = 10;
constexpr double kConverged = 1e-3;  // of a standard error
constexpr double kLeastVariance = 1e-8;
constexpr double kRidge = 1e-10;
// Share of a response's variance that other responses do not explain; far below
// it a gain stays as it is.
constexpr double kCollinear = 1e-9;

struct Noise {
  Eigen::VectorXd filter;  // −φ_n … −φ_1, 1
  double variance = 0.0;
  double rows = 0.0;
};

Eigen::VectorXd Centred(const Eigen::VectorXd& values) {
  return values.array() - values.mean();
}

// Sum of squares of the outputs about their means.
double SquaresOf(const WhitenedData& data) {
  double squares = 0.0;
  for (const Eigen::VectorXd& output : data.outputs) {
    squares += Centred(output).squaredNorm();
  }
  return squares;
}

// Adds Σ_{k=0}^{n−o−1} x_{k+a} x_{k+b}, o + 1 lags, to the lower triangle. Most
// of the products of a distance a − b are those of all a: their sum is taken
// once, and the ends, which differ, are added.
void AddGramOfLags(const Eigen::VectorXd& x, Eigen::MatrixXd& gram) {
  const Eigen::Index order = gram.rows() - 1;
  const Eigen::Index n = x.size();
  const Eigen::Index common = n - 2 * order;
  for (Eigen::Index distance = 0; distance <= order; ++distance) {
    const double sum =
        x.segment(order, common).dot(x.segment(order + distance, common));
    // From b on, and up to it.
    double before = 0.0;
    for (Eigen::Index b = order - 1; b >= 0; --b) {
      before += x(b) * x(b + distance);
      if (b + distance <= order) gram(b + distance, b) += before;
    }
    double after = 0.0;
    for (Eigen::Index b = 0; b + distance <= order; ++b) {
      gram(b + distance, b) += sum + after;
      if (b + distance < order) {
        after += x(n - order + b) * x(n - order + b + distance);
      }
    }
  }
}

// Autoregression of what the responses leave of the outputs.
Noise FitNoise(const WhitenedData& data, const Eigen::VectorXd& gains,
               int order) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(order + 1, order + 1);
  Noise noise;
  double samples = 0.0;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    const auto n = data.outputs[w].size();
    samples += static_cast<double>(n);
    if (n <= 2 * order) continue;
    const Eigen::VectorXd rest =
        Centred(data.outputs[w] - data.responses[w] * gains);
    AddGramOfLags(rest, gram);
    noise.rows += static_cast<double>(n - order);
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  const double ridge = kRidge * gram.trace() + 1e-300;
  const Eigen::MatrixXd past = gram.topLeftCorner(order, order) +
                               ridge * Eigen::MatrixXd::Identity(order, order);
  const Eigen::VectorXd present = gram.col(order).head(order);
  const Eigen::VectorXd phi = past.ldlt().solve(present);
  noise.filter.resize(order + 1);
  noise.filter << -phi, 1.0;
  const double least =
      kLeastVariance * SquaresOf(data) / std::max(samples, 1.0);
  noise.variance =
      noise.rows > 0.0
          ? std::max(noise.filter.dot(gram * noise.filter) / noise.rows, least)
          : std::max(least, 1e-300);
  return noise;
}

Eigen::Index OrderOf(const Noise& noise) { return noise.filter.size() - 1; }

double LogLikelihoodOfNoise(const Noise& noise) {
  return -0.5 * noise.rows * std::log(noise.variance);
}

// The responses that are not zero. Of a plant with many inputs most have no
// element in a row, and normal equations cost the cube of their number.
struct PresentColumns {
  std::vector<Eigen::Index> all;  // in any window
  // The numbers in `all` that each window has.
  std::vector<std::vector<Eigen::Index>> windows;
};

PresentColumns FindPresent(const WhitenedData& data, Eigen::Index columns) {
  PresentColumns present;
  present.windows.resize(data.responses.size());
  for (Eigen::Index j = 0; j < columns; ++j) {
    const auto place = static_cast<Eigen::Index>(present.all.size());
    bool any = false;
    for (std::size_t w = 0; w < data.responses.size(); ++w) {
      if (data.responses[w].col(j).isZero(0.0)) continue;
      present.windows[w].push_back(place);
      any = true;
    }
    if (any) present.all.push_back(j);
  }
  return present;
}

// Least squares of whitened outputs on whitened responses.
void FitGains(const WhitenedData& data, const PresentColumns& present,
              const Noise& noise, WhitenedFit& fit) {
  const auto m = static_cast<Eigen::Index>(present.all.size());
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(m, m);
  Eigen::VectorXd products = Eigen::VectorXd::Zero(m);
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    if (data.outputs[w].size() <= 2 * OrderOf(noise)) continue;
    const Eigen::VectorXd rest = ApplyFilter(
        noise.filter, data.outputs[w] - data.responses[w] * fit.gains);
    const std::vector<Eigen::Index>& columns = present.windows[w];
    Eigen::MatrixXd responses(rest.size(), columns.size());
    for (std::size_t c = 0; c < columns.size(); ++c) {
      responses.col(static_cast<Eigen::Index>(c)) = ApplyFilter(
          noise.filter, data.responses[w].col(present.all[columns[c]]));
    }
    gram(columns, columns) += GramMatrix(responses);
    products(columns) += responses.transpose() * rest;
  }
  const Eigen::VectorXd sizes = gram.diagonal().cwiseSqrt().cwiseMax(1e-150);
  const Eigen::MatrixXd scaled = sizes.cwiseInverse().asDiagonal() * gram *
                                     sizes.cwiseInverse().asDiagonal() +
                                 kCollinear * Eigen::MatrixXd::Identity(m, m);
  const Eigen::LLT<Eigen::MatrixXd> factor(scaled);
  const Eigen::VectorXd step =
      factor.solve(products.cwiseQuotient(sizes)).cwiseQuotient(sizes);
  // The inverse is L⁻ᵀL⁻¹.
  const Eigen::VectorXd inverse = factor.matrixL()
                                      .solve(Eigen::MatrixXd::Identity(m, m))
                                      .colwise()
                                      .squaredNorm();
  fit.errors.setConstant(std::numeric_limits<double>::infinity());
  for (Eigen::Index c = 0; c < m; ++c) {
    if (!(gram(c, c) > 0.0)) continue;
    fit.gains(present.all[c]) += step(c);
    fit.errors(present.all[c]) =
        std::sqrt(noise.variance * inverse(c)) / sizes(c);
  }
}

// The response that explains most of the whitened outputs less all responses
// at `gains`, of those not `taken`; −1: none is left.
Eigen::Index LikeliestResponse(const WhitenedData& whitened,
                               const Eigen::VectorXd& gains,
                               const std::vector<bool>& taken) {
  Eigen::VectorXd products = Eigen::VectorXd::Zero(gains.size());
  Eigen::VectorXd squares = products;
  for (std::size_t w = 0; w < whitened.outputs.size(); ++w) {
    const Eigen::MatrixXd& responses = whitened.responses[w];
    products +=
        responses.transpose() * (whitened.outputs[w] - responses * gains);
    squares += responses.colwise().squaredNorm().transpose();
  }
  Eigen::Index likeliest = -1;
  double most = 0.0;
  for (Eigen::Index j = 0; j < gains.size(); ++j) {
    if (taken[j] || !(squares(j) > 0.0)) continue;
    const double explained = products(j) * products(j) / squares(j);
    if (!(explained > most)) continue;
    most = explained;
    likeliest = j;
  }
  return likeliest;
}

// With the responses that are not `free` taken off the outputs.
WhitenedData WithFree(const WhitenedData& data, const std::vector<bool>& free) {
  WhitenedData part = data;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    for (Eigen::Index j = 0; j < data.responses[w].cols(); ++j) {
      if (free[j]) continue;
      part.outputs[w] -= data.responses[w].col(j);
      part.responses[w].col(j).setZero();
    }
  }
  return part;
}

}  // namespace

WhitenedData BlockMeans(const WhitenedData& data, int length) {
  if (length <= 1) return data;
  WhitenedData means;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    const Eigen::Index n = data.outputs[w].size() / length;
    Eigen::VectorXd& output = means.outputs.emplace_back(n);
    Eigen::MatrixXd& responses =
        means.responses.emplace_back(n, data.responses[w].cols());
    for (Eigen::Index k = 0; k < n; ++k) {
      output(k) = data.outputs[w].segment(k * length, length).mean();
      responses.row(k) =
          data.responses[w].middleRows(k * length, length).colwise().mean();
    }
  }
  return means;
}

WhitenedData Increments(const WhitenedData& data) {
  WhitenedData increments = data;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    const Eigen::VectorXd& y = data.outputs[w];
    const Eigen::MatrixXd& x = data.responses[w];
    const Eigen::Index later = y.size() - 1;
    if (later < 0) continue;
    increments.outputs[w].tail(later) = y.tail(later) - y.head(later);
    increments.outputs[w](0) = 0.0;
    increments.responses[w].bottomRows(later) =
        x.bottomRows(later) - x.topRows(later);
    increments.responses[w].row(0).setZero();
  }
  return increments;
}

double WhitenedLogLikelihood(const WhitenedData& data,
                             const Eigen::VectorXd& gains) {
  return LogLikelihoodOfNoise(FitNoise(data, gains, kWhitenedOrder));
}

WhitenedData Whiten(const WhitenedData& data, const Eigen::VectorXd& gains) {
  const Noise noise = FitNoise(data, gains, kWhitenedOrder);
  WhitenedData whitened;
  for (std::size_t w = 0; w < data.outputs.size(); ++w) {
    const Eigen::Index n = data.outputs[w].size() > 2 * OrderOf(noise)
                               ? data.outputs[w].size() - OrderOf(noise)
                               : 0;
    Eigen::VectorXd& output = whitened.outputs.emplace_back(n);
    Eigen::MatrixXd& responses =
        whitened.responses.emplace_back(n, data.responses[w].cols());
    if (n == 0) continue;
    output = ApplyFilter(noise.filter, data.outputs[w]);
    for (Eigen::Index j = 0; j < responses.cols(); ++j) {
      if (data.responses[w].col(j).isZero(0.0)) {
        responses.col(j).setZero();
      } else {
        responses.col(j) = ApplyFilter(noise.filter, data.responses[w].col(j));
      }
    }
  }
  return whitened;
}

double FewGainsLogLikelihood(const WhitenedData& data) {
  const Eigen::Index m =
      data.responses.empty() ? 0 : data.responses.front().cols();
  double samples = 0.0;
  for (const Eigen::VectorXd& output : data.outputs) {
    samples += static_cast<double>(output.size());
  }
  const double price = 0.5 * std::log(std::max(samples, 1.0));
  Eigen::VectorXd gains = Eigen::VectorXd::Ones(m);
  std::vector<bool> free(m, false);
  double best = WhitenedLogLikelihood(data, gains);
  while (true) {
    const Eigen::Index next =
        LikeliestResponse(Whiten(data, gains), gains, free);
    if (next < 0) return best;
    free[next] = true;
    const WhitenedFit fit = FitWhitenedGains(WithFree(data, free), gains);
    const auto count =
        static_cast<double>(std::count(free.begin(), free.end(), true));
    const double priced = fit.log_likelihood - price * count;
    if (!(priced > best)) return best;
    best = priced;
    gains = fit.gains;
  }
}

Eigen::VectorXd WhiteningFilter(const WhitenedData& data,
                                const Eigen::VectorXd& gains, int order) {
  return FitNoise(data, gains, order).filter;
}

Eigen::VectorXd ApplyFilter(const Eigen::VectorXd& filter,
                            const Eigen::Ref<const Eigen::VectorXd>& values) {
  const Eigen::Index taps = filter.size();
  const Eigen::Index rows = values.size() - taps + 1;
  Eigen::VectorXd filtered = Eigen::VectorXd::Zero(rows);
  // The values from each tap on are columns that overlap.
  AddLaggedProducts(
      LaggedSeries::View(values.data(), rows, taps, Eigen::OuterStride<>(1)),
      Eigen::Map<const Eigen::MatrixXd>(filter.data(), 1, taps), filtered);
  filtered.array() -= filtered.mean();
  return filtered;
}

WhitenedFit FitWhitenedGains(const WhitenedData& data, Eigen::VectorXd start,
                             int order) {
  WhitenedFit fit;
  fit.gains = std::move(start);
  fit.errors = Eigen::VectorXd::Zero(fit.gains.size());
  const PresentColumns present = FindPresent(data, fit.gains.size());
  Noise noise = FitNoise(data, fit.gains, order);
  for (int round = 0; round < kMostRounds; ++round) {
    const Eigen::VectorXd before = fit.gains;
    FitGains(data, present, noise, fit);
    noise = FitNoise(data, fit.gains, order);
    const bool converged =
        ((fit.gains - before).array().abs() <= kConverged * fit.errors.array())
            .all();
    if (converged) break;
  }
  fit.log_likelihood = LogLikelihoodOfNoise(noise);
  return fit;
}

}  // namespace mle
