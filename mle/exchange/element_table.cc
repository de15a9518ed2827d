#include "mle/exchange/element_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_format.h"
#include "mle/exchange/description.h"
#include "mle/exchange/nearest_integrator.h"
#include "mle/nonlinear/low_order_fit.h"

namespace mle {
namespace {

constexpr int kTableSamples = 400;
constexpr int kFiner = 10;  // samples between them, for the difference
// A negative (T − T₂)² is zero to rounding down to this share of the square of
// T + T₂.
constexpr double kTimeConstantRounding = 1e-12;

// T and T₂ of T T₂ s² + (T + T₂) s + 1, the larger first.
// An integrating element has the pole at 0 beside them.
std::optional<std::pair<double, double>> Lags(const TransferFunction& g) {
  std::vector<double> a = g.denominator();
  if (g.IsIntegrating()) a.pop_back();
  if (a.size() > 3) return std::nullopt;
  const double one = a.back();
  const double sum = a.size() > 1 ? a[a.size() - 2] / one : 0.0;
  const double product = a.size() > 2 ? a.front() / one : 0.0;
  const double square = sum * sum - 4.0 * product;
  if (square < -kTimeConstantRounding * sum * sum) return std::nullopt;
  const double larger = 0.5 * (sum + std::sqrt(std::max(square, 0.0)));
  return std::pair(larger, larger > 0.0 ? product / larger : 0.0);
}

// The row that is the element; nothing where none is.
std::optional<ElementRow> ExactRow(const TransferFunction& g) {
  const auto lags = Lags(g);
  std::vector<double> b = g.numerator();
  while (b.size() > 1 && b.front() == 0.0) b.erase(b.begin());
  if (!lags.has_value() || b.size() > 2 || b.back() == 0.0) {
    return std::nullopt;
  }
  ElementRow row;
  row.gain = g.StaticGain();
  row.time_constant = lags->first;
  row.second_time_constant = lags->second;
  row.lead = b.size() == 2 ? b.front() / b.back() : 0.0;
  row.delay = g.delay();
  row.integrating = g.IsIntegrating();
  return row;
}

double DifferenceOf(const ElementRow& row, const Eigen::VectorXd& response,
                    double sample_time) {
  return (row.Element().StepResponse(sample_time,
                                     static_cast<int>(response.size())) -
          response)
             .cwiseAbs()
             .maxCoeff() /
         RangeOf(response);
}

ElementRow NearestRamp(const TransferFunction& g) {
  const NearestIntegrator nearest = NearestIntegrator::Of(g);
  return {.gain = nearest.gain,
          .time_constant = nearest.time_constant,
          .delay = nearest.delay,
          .integrating = true,
          .largest_difference = nearest.largest_difference};
}

// The nearer of first and second order without lead; of second order only
// where both poles are real.
ElementRow NearestRow(const TransferFunction& g) {
  if (g.IsIntegrating()) return NearestRamp(g);
  // Long enough at rest for the gain to be that of the element.
  const double horizon = 2.0 * g.TimeToSettle();
  const double sample_time = horizon / (kTableSamples - 1);
  const Eigen::VectorXd response = g.StepResponse(sample_time, kTableSamples);
  const double fine_time = sample_time / kFiner;
  const Eigen::VectorXd fine =
      g.StepResponse(fine_time, kFiner * (kTableSamples - 1) + 1);
  ElementRow best;
  best.largest_difference = std::numeric_limits<double>::infinity();
  const auto take = [&](ElementRow row) {
    row.largest_difference = DifferenceOf(row, fine, fine_time);
    if (row.largest_difference < best.largest_difference) best = row;
  };
  if (const auto fit = FitFopdt(response, sample_time, {}); fit.ok()) {
    take({.gain = fit->gain,
          .time_constant = fit->time_constant,
          .delay = fit->delay});
  }
  if (const auto fit = FitSopdt(response, sample_time, horizon); fit.ok()) {
    const double t = fit->time_constant;
    const double zeta = std::max(fit->damping, 1.0);
    const double root = std::sqrt(zeta * zeta - 1.0);
    take({.gain = fit->gain,
          .time_constant = t * (zeta + root),
          .second_time_constant = t * (zeta - root),
          .delay = fit->delay});
  }
  return best;
}

}  // namespace

TransferFunction ElementRow::Element() const {
  std::vector<double> denominator = {1.0};
  for (const double lag : {time_constant, second_time_constant}) {
    if (lag == 0.0) continue;
    std::vector<double> product(denominator.size() + 1, 0.0);
    for (std::size_t i = 0; i < denominator.size(); ++i) {
      product[i] += lag * denominator[i];
      product[i + 1] += denominator[i];
    }
    denominator = std::move(product);
  }
  if (integrating) denominator.push_back(0.0);
  std::vector<double> numerator = {gain};
  if (lead != 0.0) numerator = {gain * lead, gain};
  return TransferFunction(std::move(numerator), std::move(denominator), delay);
}

ProcessModel ElementTable::Process() const {
  ProcessModel process = channels;
  for (const ElementRow& row : rows) {
    process.element(row.output, row.input) = row.Element();
  }
  return process;
}

ElementTable WithElements(const ElementTable& table,
                          const ProcessModel& corrected) {
  ElementTable changed = table;
  const ProcessModel before = table.Process();
  for (int i = 0; i < corrected.num_outputs(); ++i) {
    for (int j = 0; j < corrected.num_inputs(); ++j) {
      const TransferFunction& g = corrected.element(i, j);
      if (IsSameElement(g, before.element(i, j))) continue;
      const auto found = std::find_if(
          changed.rows.begin(), changed.rows.end(), [&](const ElementRow& row) {
            return row.output == i && row.input == j;
          });
      if (found == changed.rows.end() && g.IsZero()) continue;
      ElementRow row;
      if (!g.IsZero()) {
        const std::optional<ElementRow> exact = ExactRow(g);
        row = exact.has_value() ? *exact : NearestRow(g);
      }
      row.output = i;
      row.input = j;
      changed.has_second |= row.second_time_constant > 0.0;
      changed.has_lead |= row.lead != 0.0;
      changed.has_integrating |= row.integrating;
      if (found == changed.rows.end()) {
        changed.rows.push_back(row);
        continue;
      }
      if (found->second_time_constant > found->time_constant) {
        std::swap(row.time_constant, row.second_time_constant);
      }
      *found = row;
    }
  }
  return changed;
}

ElementTable ForTyping(const ElementTable& given, ElementTable corrected) {
  for (ElementRow& row : corrected.rows) {
    const auto before = std::find_if(
        given.rows.begin(), given.rows.end(), [&](const ElementRow& other) {
          return other.output == row.output && other.input == row.input;
        });
    for (double ElementRow::*const number :
         {&ElementRow::gain, &ElementRow::time_constant,
          &ElementRow::second_time_constant, &ElementRow::lead,
          &ElementRow::delay}) {
      if (before != given.rows.end() && row.*number == (*before).*number) {
        continue;
      }
      double rounded = 0.0;
      if (absl::SimpleAtod(absl::StrFormat("%.5g", row.*number), &rounded)) {
        row.*number = rounded;
      }
    }
  }
  return corrected;
}

}  // namespace mle
