#include "mle/maintain/exact_arx.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/LU"
#include "Eigen/QR"
#include "glog/logging.h"
#include "mle/base/double_limits.h"
#include "mle/model/response_difference.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Equations for each input, at lags that lie the denser the closer to the
// order; modes of an element are at most half as many.
constexpr int kEquations = 16;
// A pivot below this share of the largest is rounding of the responses.
constexpr double kRounding = 1e-11;
// A value below this share of the largest of an impulse response is before its
// dead time.
constexpr double kNoResponse = 1e-12;
// Longest time constants and dead times until a response has settled.
constexpr double kSettled = 8.0;
constexpr double kMostArxSamples = 20000.0;
// Lags of the outputs for each mode of a row, at least.
constexpr int kLagsPerMode = 3;

// h(l), l = 0, 1, …, h(0) = 0.
VectorXd ImpulseOf(const Eigen::Ref<const VectorXd>& response) {
  VectorXd impulse = VectorXd::Zero(response.size());
  impulse.tail(response.size() - 1) =
      response.tail(response.size() - 1) - response.head(response.size() - 1);
  return impulse;
}

// The first lag at which an impulse response is not 0.
int DeadSamples(const VectorXd& impulse) {
  const double least = kNoResponse * impulse.cwiseAbs().maxCoeff();
  int lag = 1;
  while (lag < impulse.size() - 1 && !(std::abs(impulse(lag)) > least)) ++lag;
  return lag;
}

// a (L): the shortest with h(l) = Σ_m a_m h(l−m) beyond the order.
VectorXd ShortestAnnihilator(const std::vector<VectorXd>& impulses, int order) {
  int dead = 1;
  for (const VectorXd& h : impulses) dead = std::max(dead, DeadSamples(h));
  const int lags = std::max(order - dead, 1);
  std::vector<Eigen::RowVectorXd> rows;
  std::vector<double> values;
  for (const VectorXd& h : impulses) {
    const double size = h.cwiseAbs().maxCoeff();
    const double span = static_cast<double>(h.size()) - order - 2.0;
    int last = 0;
    for (int e = 0; e < kEquations; ++e) {
      const double place = static_cast<double>(e) / (kEquations - 1);
      const int lag = std::max(
          order + 1 + static_cast<int>(std::round(span * place * place)),
          last + 1);
      if (lag >= h.size()) break;
      last = lag;
      rows.emplace_back(h.segment(lag - lags, lags).reverse() / size);
      values.push_back(h(lag) / size);
    }
  }
  if (rows.empty()) return VectorXd::Zero(lags);
  MatrixXd equations(rows.size(), lags);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    equations.row(static_cast<Eigen::Index>(r)) = rows[r];
  }
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(kRounding);
  decomposition.compute(equations);
  return decomposition.solve(Eigen::Map<const VectorXd>(
      values.data(), static_cast<Eigen::Index>(values.size())));
}

// The annihilator of an output that integrates: (1 − z⁻¹), exactly, times that
// of the increments of its impulse responses, which decay.
VectorXd IntegratingAnnihilator(std::vector<VectorXd> impulses, int order) {
  for (VectorXd& h : impulses) h = ImpulseOf(h);
  const VectorXd inner = ShortestAnnihilator(impulses, order - 1);
  VectorXd a = VectorXd::Zero(inner.size() + 1);
  a(0) = 1.0;
  a.head(inner.size()) += inner;
  a.tail(inner.size()) -= inner;
  return a;
}

// Row i of R.
void SetRow(const StepResponse& response, int i, bool integrating,
            ArxModel& model) {
  std::vector<VectorXd> all;
  std::vector<VectorXd> present;
  for (int j = 0; j < model.num_inputs; ++j) {
    all.push_back(ImpulseOf(response.element(i, j)));
    if (!all.back().isZero(0.0)) present.push_back(all.back());
  }
  if (present.empty()) return;
  const VectorXd a = integrating ? IntegratingAnnihilator(present, model.order)
                                 : ShortestAnnihilator(present, model.order);
  for (Eigen::Index lag = 1; lag <= model.order; ++lag) {
    const Eigen::Index first = (lag - 1) * model.num_channels();
    if (lag <= a.size()) model.R(i, first + i) = a(lag - 1);
    const Eigen::Index past = std::min<Eigen::Index>(a.size(), lag - 1);
    for (int j = 0; j < model.num_inputs; ++j) {
      model.R(i, first + model.num_outputs + j) =
          all[j](lag) -
          a.head(past).dot(all[j].segment(lag - past, past).reverse());
    }
  }
}

// Σ_lags of the columns of `count` channels from `first`.
MatrixXd SumOverLags(const ArxModel& model, int first, int count) {
  MatrixXd sum = MatrixXd::Zero(model.num_outputs, count);
  for (Eigen::Index lag = 0; lag < model.order; ++lag) {
    sum += model.R.middleCols(lag * model.num_channels() + first, count);
  }
  return sum;
}

int ArxOrderOf(const ProcessModel& model, double sample_time,
               const ConversionSettings& settings) {
  int order = settings.OrderFor(model, sample_time);
  if (settings.order > 0) return order;
  for (int i = 0; i < model.num_outputs(); ++i) {
    double dead = 0.0;
    int modes = 0;
    for (int j = 0; j < model.num_inputs(); ++j) {
      const TransferFunction& element = model.element(i, j);
      if (element.IsZero()) continue;
      dead = std::max(dead, element.delay());
      modes += static_cast<int>(element.denominator().size()) - 1;
    }
    const double least =
        std::ceil(dead / sample_time) + 2.0 + kLagsPerMode * modes;
    order = std::max(order, static_cast<int>(std::min(least, kMostArxSamples)));
  }
  return order;
}

}  // namespace

ExactArx ArxOfResponse(const StepResponse& response, const MatrixXd& gains,
                       int order, const std::vector<bool>& integrating) {
  CHECK_GE(order, integrating.empty() ? 1 : 2);
  CHECK_GT(response.samples(), order);
  ExactArx exact;
  ArxModel& model = exact.model;
  model.sample_time = response.sample_time;
  model.order = order;
  model.num_outputs = response.num_outputs;
  model.num_inputs = response.num_inputs;
  model.R = MatrixXd::Zero(model.num_outputs, model.num_regressors());
  for (int i = 0; i < model.num_outputs; ++i) {
    SetRow(response, i, !integrating.empty() && integrating[i], model);
  }
  exact.errors = FreeRunErrors(model, response, gains, integrating);
  return exact;
}

ExactArx ArxOfModel(const ProcessModel& model, double sample_time,
                    const ConversionSettings& settings) {
  const int order = ArxOrderOf(model, sample_time, settings);
  const double settled = std::ceil(
      kSettled * std::max(LongestMemory(model), sample_time) / sample_time);
  const int samples =
      order + 2 + static_cast<int>(std::min(settled, kMostArxSamples));
  std::vector<bool> integrating = IntegratingOutputs(model);
  MatrixXd gains = StaticGains(model);
  for (int i = 0; i < model.num_outputs(); ++i) {
    for (int j = 0; integrating[i] && j < model.num_inputs(); ++j) {
      // Beside one that integrates, one that settles has no slope.
      if (!model.element(i, j).IsIntegrating()) gains(i, j) = 0.0;
    }
  }
  if (!IsIntegrating(model)) integrating.clear();
  return ArxOfResponse(model.ComputeStepResponse(sample_time, samples), gains,
                       order, integrating);
}

VectorXd FreeRunErrors(const ArxModel& model, const StepResponse& response,
                       const MatrixXd& gains,
                       const std::vector<bool>& integrating) {
  const int p = model.num_outputs;
  const int m = model.num_inputs;
  const StepResponse run = model.ComputeStepResponse(response.samples());
  MatrixXd inner = MatrixXd::Identity(p, p) - SumOverLags(model, 0, p);
  MatrixXd by_inputs = SumOverLags(model, p, m);
  const int last = run.samples() - 1;
  for (std::size_t i = 0; i < integrating.size(); ++i) {
    if (!integrating[i]) continue;
    const auto row = static_cast<Eigen::Index>(i);
    inner.row(row).setZero();
    inner(row, row) = 1.0;
    for (int j = 0; j < m; ++j) {
      const auto of = run.element(static_cast<int>(i), j);
      by_inputs(row, j) = (of(last) - of(last - 1)) / run.sample_time;
    }
  }
  const Eigen::FullPivLU<MatrixXd> solver(inner);
  if (!solver.isInvertible()) return VectorXd::Constant(p, kInfinity);
  return RelativeDifferences({run, solver.solve(by_inputs)}, {response, gains});
}

}  // namespace mle
