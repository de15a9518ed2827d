#include "mle/model/row_realization.h"

#include <algorithm>

#include "Eigen/QR"
#include "glog/logging.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// Once a power of A is smaller than this, further terms of the sum are below
// rounding.
constexpr double kForgottenPower = 1e-18;
constexpr int kMostDoublings = 60;

// R with RᵀR = rowsᵀ·rows and no more rows than columns.
MatrixXd Compressed(const MatrixXd& rows) {
  const Index n = rows.cols();
  if (rows.rows() <= n) return rows;
  const Eigen::HouseholderQR<MatrixXd> qr(rows);
  return qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
}

// R with RᵀR = Σ_t (c A^t)ᵀ(c A^t).
MatrixXd ObservabilityFactor(MatrixXd power, const RowVectorXd& c) {
  MatrixXd factor = c;
  for (int doubling = 0; doubling < kMostDoublings; ++doubling) {
    MatrixXd both(2 * factor.rows(), factor.cols());
    both << factor, factor * power;
    factor = Compressed(both);
    power = (power * power).eval();
    if (power.norm() < kForgottenPower) break;
  }
  return factor;
}

// L (r × r) with L Lᵀ = Σ_t (A^t b)(A^t b)ᵀ.
MatrixXd ControllabilityFactor(const RowElement& element) {
  return ObservabilityFactor(element.A.transpose(), element.b.transpose())
      .transpose();
}

int LongestDelay(const std::vector<RowElement>& elements) {
  int longest = 0;
  for (const RowElement& element : elements) {
    longest = std::max(longest, element.delay);
  }
  return longest;
}

// The first state of each element, and the number of states.
std::vector<Index> FirstStates(const std::vector<RowElement>& elements) {
  std::vector<Index> first = {LongestDelay(elements)};
  for (const RowElement& element : elements) {
    first.push_back(first.back() + element.A.rows());
  }
  return first;
}

void SetSystem(const std::vector<RowElement>& elements,
               const std::vector<Index>& first, RowRealization& row) {
  const Index n = first.back();
  const Index line = first.front();
  row.A = MatrixXd::Zero(n, n);
  row.B = MatrixXd::Zero(n, static_cast<Index>(elements.size()));
  row.C = RowVectorXd::Zero(n);
  for (Index i = 0; i + 1 < line; ++i) row.A(i, i + 1) = 1.0;
  if (line > 0) row.C(0) = 1.0;
  for (std::size_t j = 0; j < elements.size(); ++j) {
    const RowElement& element = elements[j];
    const Index r = element.A.rows();
    row.A.block(first[j], first[j], r, r) = element.A;
    row.B.col(static_cast<Index>(j)).segment(first[j], r) = element.b;
    if (element.delay > 0) {
      row.A.row(element.delay - 1).segment(first[j], r) = element.c;
    } else {
      row.C.segment(first[j], r) = element.c;
    }
  }
}

// Rows 1 … D are the output at the first D samples; those below, what is seen
// from then on, when the line has run out.
void SetObservability(const std::vector<RowElement>& elements,
                      const std::vector<Index>& first, RowRealization& row) {
  const Index n = first.back();
  const Index line = first.front();
  RowVectorXd c(n - line);
  for (std::size_t j = 0; j < elements.size(); ++j) {
    c.segment(first[j] - line, elements[j].A.rows()) = elements[j].c;
  }
  const MatrixXd later =
      ObservabilityFactor(row.A.bottomRightCorner(n - line, n - line), c);
  MatrixXd& factor = row.observability_factor;
  factor = MatrixXd::Zero(line + later.rows(), n);
  factor.topLeftCorner(line, line).setIdentity();
  for (std::size_t j = 0; j < elements.size(); ++j) {
    const RowElement& element = elements[j];
    const Index r = element.A.rows();
    RowVectorXd seen = element.c;
    MatrixXd moved = later.middleCols(first[j] - line, r);
    for (Index t = element.delay; t < line; ++t) {
      factor.row(t).segment(first[j], r) = seen;
      seen = (seen * element.A).eval();
      moved = (moved * element.A).eval();
    }
    factor.block(line, first[j], later.rows(), r) = moved;
  }
}

// The state that one input leaves: of what was d samples ago and before (the
// first r columns), and of the inputs 1 … d samples ago.
MatrixXd StatesLeft(const RowElement& element, Index first, Index n) {
  const Index r = element.A.rows();
  const Index d = element.delay;
  MatrixXd states = MatrixXd::Zero(n, r + d);
  MatrixXd past = ControllabilityFactor(element);
  // x_j of d samples ago is in the line's entry 1, and so on up to now.
  for (Index i = 0; i < d; ++i) {
    states.row(i).head(r) = element.c * past;
    past = (element.A * past).eval();
  }
  states.block(first, 0, r, r) = past;
  VectorXd impulses(d);
  VectorXd moved = element.b;
  for (Index age = 0; age < d; ++age) {
    states.col(r + age).segment(first, r) = moved;
    impulses(age) = element.c.dot(moved);
    moved = (element.A * moved).eval();
  }
  // Entry d − late of the line holds what left the element `late` samples ago.
  for (Index age = 1; age < d; ++age) {
    for (Index late = 1; late <= age; ++late) {
      states(d - late, r + age) = impulses(age - late);
    }
  }
  return states;
}

}  // namespace

RowElement RowElement::Of(const HeldResponse& response) {
  const Index r = response.C.size();
  const bool past = response.D != 0.0 || !response.map.older.isZero(0.0);
  RowElement element;
  const Index size = past ? r + 1 : r;
  element.A = MatrixXd::Zero(size, size);
  element.A.topLeftCorner(r, r) = MatrixXd::Identity(r, r) + response.map.E;
  element.b = VectorXd::Zero(size);
  element.b.head(r) = response.map.newer;
  element.c = RowVectorXd::Zero(size);
  element.c.head(r) = response.C;
  if (past) {
    element.A.topRightCorner(r, 1) = response.map.older;
    element.b(r) = 1.0;
    element.c(r) = response.D;
  }
  return element;
}

RowRealization RowRealization::Of(const std::vector<RowElement>& elements) {
  CHECK(!elements.empty());
  const std::vector<Index> first = FirstStates(elements);
  RowRealization row;
  SetSystem(elements, first, row);
  SetObservability(elements, first, row);
  const Index n = first.back();
  MatrixXd inputs(0, n);
  for (std::size_t j = 0; j < elements.size(); ++j) {
    const MatrixXd states = StatesLeft(elements[j], first[j], n);
    MatrixXd all(inputs.rows() + states.cols(), n);
    all << inputs, states.transpose();
    inputs = Compressed(all);
  }
  row.controllability_factor = inputs.transpose();
  return row;
}

}  // namespace mle
