#include "mle/model/integrator_split.h"

#include <utility>
#include <vector>

#include "mle/base/status.h"
#include "mle/model/held_response.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// R = (N − K D) / (s D), the dead time aside.
TransferFunction WithoutIntegratorPart(const TransferFunction& g) {
  std::vector<double> d = g.denominator();
  d.pop_back();
  std::vector<double> b = g.numerator();
  b.insert(b.begin(), d.size() + 1 - b.size(), 0.0);  // of the degree of s D
  for (std::size_t k = 0; k < d.size(); ++k) {
    b[k + 1] -= g.StaticGain() * d[k];
  }
  b.pop_back();  // 0, as K = N(0)/D(0)
  return TransferFunction(std::move(b), std::move(d), 0.0);
}

}  // namespace

absl::StatusOr<IntegratorSplit> SplitIntegrator(const TransferFunction& element,
                                                double sample_time, int left) {
  MLE_ASSIGN_OR_RETURN(const HeldResponse whole,
                       HeldResponse::Create(element, sample_time));
  double fraction = element.delay() / sample_time - whole.whole_delay;
  if (whole.map.older.isZero(0.0)) fraction = 0.0;
  IntegratorSplit split;
  split.slope = element.StaticGain();
  const double step = split.slope * sample_time;
  TransferFunction others = WithoutIntegratorPart(element);
  if (left == 0 && fraction == 0.0 && others.IsZero()) return split;
  others.set_delay(fraction * sample_time);
  MLE_ASSIGN_OR_RETURN(const HeldResponse held,
                       HeldResponse::Create(others, sample_time));
  const RowElement settling = RowElement::Of(held);
  // States of R, then the inputs of the last left + 1 samples.
  const Index r = settling.b.size();
  const Index line = left + 1;
  RowElement rest;
  rest.A = MatrixXd::Zero(r + line, r + line);
  rest.b = VectorXd::Zero(r + line);
  rest.c = RowVectorXd::Zero(r + line);
  rest.A.topLeftCorner(r, r) = settling.A;
  rest.c.head(r) = settling.c;
  rest.b(r) = 1.0;
  for (Index k = 1; k < line; ++k) rest.A(r + k, r + k - 1) = 1.0;
  if (left == 0) {
    rest.b.head(r) = settling.b;
  } else {
    rest.A.col(r + left - 1).head(r) = settling.b;
  }
  rest.c.segment(r, left).setConstant(-step);
  rest.c(r + left) = -fraction * step;
  split.rest = std::move(rest);
  split.rest_gain = others.StaticGain() - step * (left + fraction);
  return split;
}

}  // namespace mle
