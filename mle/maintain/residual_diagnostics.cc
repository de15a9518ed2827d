#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "mle/base/parallel.h"
#include "mle/maintain/validation.h"
#include "mle/nonlinear/distributions.h"
#include "mle/nonlinear/elimination.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

constexpr double k99Percent = 2.5758293035489004;

// A signal in its windows, NaN where it is not known.
using Windows = std::vector<RowVectorXd>;

// Takes the mean of all finite values off.
void CentreWindows(Windows& windows) {
  double sum = 0.0;
  double count = 0.0;
  for (const RowVectorXd& window : windows) {
    for (const double value : window) {
      if (!std::isfinite(value)) continue;
      sum += value;
      count += 1.0;
    }
  }
  if (count == 0.0) return;
  for (RowVectorXd& window : windows) window.array() -= sum / count;
}

// With zeros where it is not known.
Windows Known(Windows windows) {
  for (RowVectorXd& window : windows) {
    window = window.array().isFinite().select(window, 0.0);
  }
  return windows;
}

// Σ_k a_{k+lag} b_k of Known() signals.
double Product(const Windows& a, const Windows& b, int lag) {
  double sum = 0.0;
  for (std::size_t w = 0; w < a.size(); ++w) {
    const Eigen::Index n = a[w].size() - std::abs(lag);
    if (n <= 0) continue;
    sum += a[w].segment(std::max(lag, 0), n)
               .dot(b[w].segment(std::max(-lag, 0), n));
  }
  return sum;
}

// r(1) … r(max_lag); zeros for a signal that does not move.
VectorXd Autocorrelation(const Windows& signal, int max_lag) {
  const double squares = Product(signal, signal, 0);
  VectorXd values = VectorXd::Zero(max_lag);
  if (!(squares > 0.0)) return values;
  for (int lag = 1; lag <= max_lag; ++lag) {
    values(lag - 1) = Product(signal, signal, lag) / squares;
  }
  return values;
}

// N R² of the errors on means of `input` over lags 1 … step, step + 1 … 2 step,
// and so on; rank of the regressors.
void TestInput(const Windows& errors, const Windows& input, int max_lag,
               InputCorrelation& result) {
  const int step = std::max((max_lag + kTestLags - 1) / kTestLags, 1);
  const int lags = (max_lag - 1) / step + 1;
  const int deepest = lags * step;
  std::vector<double> values;
  int rows = 0;
  for (std::size_t w = 0; w < errors.size(); ++w) {
    for (int k = deepest; k < errors[w].size(); ++k) {
      if (!std::isfinite(errors[w](k))) continue;
      for (int a = 0; a < lags; ++a) {
        values.push_back(input[w].segment(k - (a + 1) * step, step).mean());
      }
      values.push_back(errors[w](k));
      ++rows;
    }
  }
  if (rows <= 2 * lags) return;
  MatrixXd table =
      Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic,
                                     Eigen::RowMajor>>(values.data(), rows,
                                                       lags + 1);
  table.rowwise() -= table.colwise().mean().eval();
  const MatrixXd products = table.transpose() * table;
  const double squares = products(lags, lags);
  if (!(squares > 0.0)) return;
  const Elimination regression = EliminateFirst(lags, products);
  if (regression.rank() == 0) return;
  result.statistic = rows * (1.0 - regression.rest(0, 0) / squares);
  result.degrees_of_freedom = regression.rank();
  result.p_value = ChiSquareTail(result.statistic, regression.rank());
}

// An input with which every output's errors are compared.
struct Input {
  Windows centred;
  Windows moves;         // Known()
  double squares = 0.0;  // of the moves
  VectorXd autocorrelation;
};

Input InputOf(Windows recorded, int max_lag) {
  Input input;
  CentreWindows(recorded);
  input.moves = Known(recorded);
  input.centred = std::move(recorded);
  input.squares = Product(input.moves, input.moves, 0);
  input.autocorrelation = Autocorrelation(input.moves, max_lag);
  return input;
}

// `known` are the Known() errors.
InputCorrelation Correlate(const Windows& errors, const Windows& known,
                           const VectorXd& errors_acf, const Input& input,
                           int samples, int max_lag) {
  InputCorrelation result;
  result.max_lag = max_lag;
  result.values = VectorXd::Zero(2 * max_lag + 1);
  const double norm = std::sqrt(Product(known, known, 0) * input.squares);
  if (!(norm > 0.0)) return result;
  for (int lag = -max_lag; lag <= max_lag; ++lag) {
    const double value = Product(known, input.moves, lag) / norm;
    result.values(lag + max_lag) = value;
    if (lag > 0 && std::abs(value) > result.largest) {
      result.largest = std::abs(value);
      result.largest_lag = lag;
    }
  }
  const double spread = std::max(
      1.0 + 2.0 * errors_acf.dot(input.autocorrelation), 1.0 / samples);
  result.limit = k99Percent * std::sqrt(spread / samples);
  TestInput(errors, input.centred, max_lag, result);
  return result;
}

ResidualReport ExamineOutput(Windows errors, const std::vector<Input>& inputs,
                             int max_lag) {
  ResidualReport report;
  CentreWindows(errors);
  for (const RowVectorXd& window : errors) {
    report.samples += static_cast<int>(window.array().isFinite().count());
  }
  const double n = report.samples;
  const Windows known = Known(errors);
  const VectorXd acf = Autocorrelation(known, max_lag);
  report.autocorrelation = acf;
  if (report.samples > max_lag + 1) {
    report.variance = Product(known, known, 0) / n;
    report.limit = k99Percent / std::sqrt(n);
    for (int lag = 1; lag <= max_lag; ++lag) {
      report.ljung_box += acf(lag - 1) * acf(lag - 1) / (n - lag);
    }
    report.ljung_box *= n * (n + 2.0);
    report.degrees_of_freedom = max_lag;
    report.p_value = ChiSquareTail(report.ljung_box, max_lag);
    report.outside = (acf.array().abs() > report.limit).cast<double>().mean();
    for (const Input& input : inputs) {
      report.inputs.push_back(
          Correlate(errors, known, acf, input, report.samples, max_lag));
    }
  } else {
    report.inputs.resize(inputs.size());
  }
  return report;
}

}  // namespace

std::vector<ResidualReport> ExamineResiduals(const Predictor& predictor,
                                             const std::vector<Record>& windows,
                                             int max_lag, int threads) {
  const int p = windows.front().num_outputs();
  const int m = windows.front().num_inputs();
  std::vector<Windows> errors(p);
  std::vector<Windows> recorded(m);
  int longest = 0;
  for (const Record& window : windows) {
    const MatrixXd one_step = predictor(window, 1);
    for (int i = 0; i < p; ++i) errors[i].push_back(one_step.row(i));
    for (int j = 0; j < m; ++j) recorded[j].push_back(window.inputs.row(j));
    longest = std::max(longest, window.samples() - window.lead());
  }
  const int lags = std::clamp(max_lag, 1, std::max(longest / 4, 1));
  std::vector<Input> inputs(m);
  ParallelFor(m, threads, [&](int j) {
    inputs[j] = InputOf(std::move(recorded[j]), lags);
  });
  std::vector<ResidualReport> reports(p);
  ParallelFor(p, threads, [&](int i) {
    reports[i] = ExamineOutput(errors[i], inputs, lags);
  });
  return reports;
}

}  // namespace mle
