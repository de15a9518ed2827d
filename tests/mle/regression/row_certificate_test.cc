// Certificates of degenerate families against the gap of the rows, computed in
// four times the precision.

#include "mle/regression/row_certificate.h"

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "mle/data/lagged_series.h"

namespace mle {
namespace {

#ifdef __SIZEOF_FLOAT128__
__extension__ typedef __float128 Quad;
#else
using Quad = long double;
#endif

struct Degeneracy {
  std::string name;
  int order = 0;
  int samples = 0;
  std::function<void(Record&, std::mt19937_64&)> spoil;
};

// One output regressed on lags of itself and of two inputs, spoilt in one way.
class Family {
 public:
  explicit Family(const Degeneracy& one, int seed = 7,
                  Scaling scaling = Scaling::kStandardise)
      : series_(Made(one, seed), one.order),
        centred_(scaling == Scaling::kStandardise) {
    for (const RowRange& range : series_.UsableRows()) {
      rows_.push_back({&series_, range, series_.Outputs(range), 0});
    }
    problem_ = MakeLassoProblem(ComputeLaggedMoments(rows_), scaling);
  }

  const std::vector<RegressionRows>& rows() const { return rows_; }
  const LassoProblem& problem() const { return problem_; }

  // Primal less dual value of β at λ, relative to the primal one: all sums in
  // Quad.
  double RelativeGap(double lambda, const Eigen::VectorXd& beta) const;

 private:
  static Record Made(const Degeneracy& one, int seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Record record;
    record.sample_time = 1.0;
    record.inputs.resize(2, one.samples);
    record.outputs.setZero(1, one.samples);
    for (double& value : record.inputs.reshaped()) value = normal(random);
    for (int k = 1; k < one.samples; ++k) {
      record.outputs(0, k) = 0.8 * record.outputs(0, k - 1) +
                             record.inputs(0, k - 1) + 0.1 * normal(random);
    }
    one.spoil(record, random);
    return record;
  }

  LaggedSeries series_;
  bool centred_;
  std::vector<RegressionRows> rows_;
  LassoProblem problem_;
};

double Family::RelativeGap(double lambda, const Eigen::VectorXd& beta) const {
  const auto X = series_.Regressors(rows_[0].rows);
  const Eigen::Index n = X.rows();
  const Eigen::Index N = X.cols();
  const auto total = static_cast<Quad>(N);
  std::vector<Quad> r(N);
  Quad mean = 0;
  for (Eigen::Index k = 0; k < N; ++k) {
    r[k] = rows_[0].responses(0, k);
    for (Eigen::Index j = 0; j < n; ++j) {
      if (beta(j) == 0.0) continue;
      r[k] -= static_cast<Quad>(beta(j)) * X(j, k) / problem_.scale(j);
    }
    mean += r[k] / total;
  }
  Quad square = 0;
  for (Quad& value : r) {
    if (centred_) value -= mean;
    square += value * value / total;
  }
  Quad ratio = 1;
  Quad products = 0;  // Σ β_j c_j
  Quad norm = 0;
  for (Eigen::Index j = 0; j < n; ++j) {
    if (!(problem_.scale(j) > 0.0)) continue;
    Quad c = 0;
    for (Eigen::Index k = 0; k < N; ++k) c += X(j, k) * r[k];
    c /= total * problem_.scale(j);
    const Quad size = (c < 0 ? -c : c) / lambda;
    if (size > ratio) ratio = size;
    products += beta(j) * c;
    norm += std::abs(beta(j));
  }
  const Quad alpha = 1 / ratio;
  const Quad gap =
      (1 - alpha) * (1 - alpha) * square / 2 + lambda * norm - alpha * products;
  const Quad primal = square / 2 + lambda * norm;
  return primal > 0 ? static_cast<double>(gap / primal) : 0.0;
}

std::vector<Degeneracy> Degeneracies() {
  const auto twins = [](Record& record, std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    for (int k = 0; k < record.samples(); ++k) {
      record.inputs(1, k) = record.inputs(0, k) + 1e-8 * normal(random);
      record.outputs(0, k) += normal(random);
    }
  };
  const auto spikes = [](Record& record, std::mt19937_64&) {
    record.inputs.col(40).setConstant(1e5);
    record.outputs(0, 41) += 1e5;
  };
  const auto exact = [](Record& record, std::mt19937_64&) {
    for (int k = 1; k < record.samples(); ++k) {
      record.outputs(0, k) =
          0.9 * record.outputs(0, k - 1) + 0.5 * record.inputs(0, k - 1);
    }
  };
  const auto nothing = [](Record&, std::mt19937_64&) {};
  const auto constant = [](Record& record, std::mt19937_64&) {
    record.inputs.row(1).setConstant(96.1);
    record.outputs.array() += 100.0;
  };
  return {{"twins", 20, 200, twins},
          {"spikes", 10, 150, spikes},
          {"exact fit", 10, 150, exact},
          {"fewer rows", 30, 70, nothing},
          {"constants", 10, 150, constant}};
}

class RowCertificateTest
    : public ::testing::TestWithParam<std::tuple<Degeneracy, int, Scaling>> {};

// What is stated is no less than what is true.
TEST_P(RowCertificateTest, TheStatedGapBoundsTheTrueOne) {
  Eigen::VectorXd parts(9);
  for (int i = 0; i < 9; ++i) parts(i) = std::pow(10.0, i - 9);
  const auto& [degeneracy, seed, scaling] = GetParam();
  const Family family(degeneracy, seed, scaling);
  const LassoObjective objective(family.problem(), 0);
  const Eigen::VectorXd lambdas = objective.LambdaMax() * parts;
  auto solution = SolveLasso(objective, lambdas, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  CertifyByRows(family.rows(), family.problem(), 0, objective, *solution);
  for (Eigen::Index i = 0; i < lambdas.size(); ++i) {
    const double actual =
        family.RelativeGap(lambdas(i), solution->path.Coefficients(lambdas(i)));
    EXPECT_LE(actual, 1.001 * solution->relative_gap(i) + 1e-13)
        << "at λ/λ_max = " << parts(i) << ": " << solution->report;
    // And no bound of no use.
    if (parts(i) >= 1e-4) {
      EXPECT_LE(solution->relative_gap(i), 1e-6) << parts(i);
    }
  }
}

std::string NameOf(
    const ::testing::TestParamInfo<std::tuple<Degeneracy, int, Scaling>>& one) {
  const auto& [degeneracy, seed, scaling] = one.param;
  return absl::StrCat(absl::StrReplaceAll(degeneracy.name, {{" ", "_"}}), "_",
                      seed, scaling == Scaling::kRaw ? "_raw" : "");
}

INSTANTIATE_TEST_SUITE_P(
    Families, RowCertificateTest,
    ::testing::Combine(::testing::ValuesIn(Degeneracies()),
                       ::testing::Range(1, 4),
                       ::testing::Values(Scaling::kStandardise, Scaling::kRaw)),
    NameOf);

// Twins 1e-8 apart took turns until the path was given up.
TEST(RowCertificatesTest, TwinsDoNotStallThePath) {
  const Degeneracy twins = Degeneracies()[0];
  const Family family(twins);
  const LassoObjective objective(family.problem(), 0);
  Eigen::VectorXd lambdas(1);
  lambdas(0) = 1e-6 * objective.LambdaMax();
  const auto solution = SolveLasso(objective, lambdas, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  EXPECT_THAT(solution->report, ::testing::HasSubstr("homotopy: complete"));
  EXPECT_LE(solution->MaxRelativeGap(), 1e-9);
}

// c of the Gram matrix is that of another problem here; the report says so.
TEST(RowCertificatesTest, BeyondDoublePrecisionIsSaid) {
  const Degeneracy constants = Degeneracies()[4];
  const Family family(constants);
  const LassoObjective objective(family.problem(), 0);
  Eigen::VectorXd lambdas(1);
  lambdas(0) = 1e-9 * objective.LambdaMax();
  auto solution = SolveLasso(objective, lambdas, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  const double before = solution->relative_gap(0);
  CertifyByRows(family.rows(), family.problem(), 0, objective, *solution);
  EXPECT_LT(before, 1e-9);
  EXPECT_GT(solution->relative_gap(0), 1e-6);
  EXPECT_THAT(solution->report,
              ::testing::HasSubstr("beyond double precision"));
}

// On a fine grid the values between those looked at are bounded too.
TEST(RowCertificatesTest, AFineGridIsBoundedBetween) {
  const Degeneracy spikes = Degeneracies()[1];
  const Family family(spikes);
  const LassoObjective objective(family.problem(), 0);
  const Eigen::VectorXd lambdas =
      Eigen::VectorXd::LinSpaced(2000, 1e-10, 1e-6) * objective.LambdaMax();
  auto solution = SolveLasso(objective, lambdas, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  CertifyByRows(family.rows(), family.problem(), 0, objective, *solution);
  for (Eigen::Index i = 0; i < lambdas.size(); i += 37) {
    EXPECT_LE(
        family.RelativeGap(lambdas(i), solution->path.Coefficients(lambdas(i))),
        1.001 * solution->relative_gap(i) + 1e-13)
        << i;
  }
}

// Where nothing is degenerate, gaps stay as small as they were.
TEST(RowCertificatesTest, OrdinaryGapsStaySmall) {
  const Family family({"ordinary", 10, 400, [](Record&, auto&) {}});
  const LassoObjective objective(family.problem(), 0);
  const Eigen::VectorXd lambdas =
      Eigen::VectorXd::LinSpaced(500, 1e-6, 1e-2) * objective.LambdaMax();
  auto solution = SolveLasso(objective, lambdas, {});
  ASSERT_TRUE(solution.ok()) << solution.status();
  CertifyByRows(family.rows(), family.problem(), 0, objective, *solution);
  EXPECT_LE(solution->MaxRelativeGap(), 1e-9) << solution->report;
}

}  // namespace
}  // namespace mle
