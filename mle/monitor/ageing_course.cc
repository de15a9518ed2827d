#include "mle/monitor/ageing_course.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "mle/monitor/log_sum.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kLeastBatches = 5;
constexpr double kLeastSpan = 30.0;
constexpr double kCourseMonth = 30.0;
constexpr int kGridSteps = 24;
constexpr int kMostPoints = 40;
constexpr double kMostDispersion = 2.0;
constexpr double kSmallGain = 0.01;
constexpr double kSmallOther = 0.03;
constexpr double kLeastExplained = 0.5;
constexpr double kSmallerScale = 1.0 / 6.0;
constexpr double kHalfTail = 0.025;
// Courses with less than this share of the largest weight change no digit that
// is shown.
constexpr double kNegligibleWeight = 1e-7;
// Eigenvalues up to this share of the largest are rounding.
constexpr double kRankLimit = 1e-10;
constexpr int kBisections = 60;
constexpr double kRounding = 1e-12;

double TimeOf(const ScoredBatch& batch) {
  return batch.number + 0.5 * (batch.length - 1);
}

// Between two times, in proportion to time.
struct CourseTimes {
  double start = 0.0;
  double end = 0.0;

  bool at_once() const { return start == end; }
  double ShareAt(double time) const {
    if (time >= end) return 1.0;
    return time <= start ? 0.0 : (time - start) / (end - start);
  }
};

// A course of one parameter, with β ~ N(mean, deviation²).
struct WeightedCourse {
  CourseTimes times;
  double log_weight = 0.0;
  double mean = 0.0;
  double deviation = 0.0;
};

// Sums over the batches that a course of any parameter needs.
struct CourseSums {
  explicit CourseSums(Index n)
      : q(VectorXd::Zero(n)),
        h(VectorXd::Zero(n)),
        across(MatrixXd::Zero(n, n)) {}
  void Add(const ScoredBatch& batch, double share) {
    q += share * batch.score;
    h += share * share * batch.information.diagonal();
    across += share * batch.information;
  }

  VectorXd q;       // n, Σ c S
  VectorXd h;       // n, Σ c² V_aa
  MatrixXd across;  // n × n, Σ c V
};

class CourseEstimator {
 public:
  CourseEstimator(const std::vector<ScoredBatch>& batches, int now,
                  const WatchOptions& options);
  // φ, and the share of what θ leaves that the best course explains.
  struct Misfit {
    double dispersion = 1.0;
    double explained = 1.0;
  };
  Misfit MisfitOfBest() const;
  AgeingCourse Estimate() const;

 private:
  void AddCourses(double log_prior, const CourseTimes& times, CourseSums sums);
  void AddLastingCourses(double log_prior, const CourseTimes& times);
  void AddAllAtOnce(double log_prior);
  void AddAllCourses();
  // Estimate of β times `share` over the courses of parameter `a` and no
  // change; `unfinished`: over those courses alone that still go on.
  template <typename Share>
  CourseEstimate ValueOf(Index a, const Share& share,
                         bool unfinished = false) const;
  CourseEstimate RateOf(Index a) const;
  double LargestRateUnseen(Index a) const;

  const std::vector<ScoredBatch>& batches_;
  const WatchOptions& options_;
  double first_ = 0.0;
  double now_ = 0.0;
  Index n_ = 0;
  VectorXd score_;
  Eigen::LDLT<MatrixXd> solver_;
  VectorXd projected_;
  std::vector<std::vector<WeightedCourse>> courses_;  // n
  std::vector<LogSum> of_parameter_;                  // n
  double log_none_ = std::log(0.5);
  double best_gain_ = 0.0;  // q²/h, the largest
};

CourseEstimator::CourseEstimator(const std::vector<ScoredBatch>& batches,
                                 int now, const WatchOptions& options)
    : batches_(batches),
      options_(options),
      first_(TimeOf(batches.front())),
      now_(std::max<double>(now, TimeOf(batches.back()))),
      n_(batches.front().score.size()),
      score_(VectorXd::Zero(n_)),
      courses_(static_cast<std::size_t>(n_)),
      of_parameter_(static_cast<std::size_t>(n_)) {
  MatrixXd information =
      MatrixXd::Identity(n_, n_) / (options.model_error * options.model_error);
  for (const ScoredBatch& batch : batches) {
    information += batch.information;
    score_ += batch.score;
  }
  solver_.compute(information);
  projected_ = solver_.solve(score_);
  AddAllCourses();
}

// All parameters' courses of these times.
void CourseEstimator::AddCourses(double log_prior, const CourseTimes& times,
                                 CourseSums sums) {
  const MatrixXd& across = sums.across;
  sums.q -= across.transpose() * projected_;
  sums.h -=
      (across.cwiseProduct(solver_.solve(across))).colwise().sum().transpose();
  const double each = log_prior - std::log(static_cast<double>(n_));
  for (Index a = 0; a < n_; ++a) {
    const double q = sums.q(a);
    const double h = std::max(sums.h(a), 0.0);
    if (h > 0.0) best_gain_ = std::max(best_gain_, q * q / h);
    for (const double scale : {1.0, kSmallerScale}) {
      const double deviation = scale * options_.change_deviation;
      const double v = deviation * deviation;
      const double growth = 1.0 + h * v;
      const double log_weight = each + std::log(0.5) - 0.5 * std::log(growth) +
                                0.5 * q * q * v / growth;
      const auto at = static_cast<std::size_t>(a);
      of_parameter_[at].Add(log_weight);
      courses_[at].push_back(
          {times, log_weight, q * v / growth, std::sqrt(v / growth)});
    }
  }
}

void CourseEstimator::AddLastingCourses(double log_prior,
                                        const CourseTimes& times) {
  CourseSums sums(n_);
  for (const ScoredBatch& batch : batches_) {
    const double share = times.ShareAt(TimeOf(batch));
    if (share > 0.0) sums.Add(batch, share);
  }
  AddCourses(log_prior, times, std::move(sums));
}

// Between any two batches, as probable as the time between them is long: on a
// grid the batches of the step that it falls into would be taken for those of
// the other side.
void CourseEstimator::AddAllAtOnce(double log_prior) {
  CourseSums sums(n_);
  for (std::size_t k = batches_.size() - 1; k > 0; --k) {
    sums.Add(batches_[k], 1.0);
    const double before = TimeOf(batches_[k - 1]);
    const double gap = TimeOf(batches_[k]) - before;
    const double time = before + 0.5 * gap;
    AddCourses(log_prior + std::log(gap / (now_ - first_)), {time, time}, sums);
  }
}

void CourseEstimator::AddAllCourses() {
  const double step = (now_ - first_) / kGridSteps;
  const double kind = std::log(0.5 / 3.0);
  const double of_one = kind - std::log(static_cast<double>(kGridSteps));
  const double of_passed =
      kind - std::log(0.5 * kGridSteps * (kGridSteps - 1.0));
  for (int s = 0; s < kGridSteps; ++s) {
    const double start = first_ + s * step;
    for (int e = s + 1; e < kGridSteps; ++e) {
      if ((e - s) * step < kCourseMonth) continue;
      AddLastingCourses(of_passed, {start, first_ + e * step});
    }
    if (now_ - start >= kCourseMonth) AddLastingCourses(of_one, {start, now_});
  }
  AddAllAtOnce(kind);
}

template <typename Share>
CourseEstimate CourseEstimator::ValueOf(Index a, const Share& share,
                                        bool unfinished) const {
  struct Part {
    double weight, mean, deviation;
  };
  const auto& courses = courses_[static_cast<std::size_t>(a)];
  const double log_none = unfinished ? kLogZero : log_none_;
  const auto counts = [&](const WeightedCourse& course) {
    return !unfinished || (course.times.end == now_ && !course.times.at_once());
  };
  double largest = log_none;
  for (const WeightedCourse& course : courses) {
    if (counts(course)) largest = std::max(largest, course.log_weight);
  }
  std::vector<Part> parts;
  double all = 0.0;
  if (log_none > kLogZero) {
    parts.push_back({std::exp(log_none - largest), 0.0, 0.0});
    all = parts.front().weight;
  }
  for (const WeightedCourse& course : courses) {
    if (!counts(course)) continue;
    const double weight = std::exp(course.log_weight - largest);
    if (weight < kNegligibleWeight) continue;
    const double part = share(course.times);
    parts.push_back({weight, part * course.mean, part * course.deviation});
    all += weight;
  }
  CourseEstimate value;
  double least = 0.0;
  double most = 0.0;
  for (const Part& part : parts) {
    value.mean += part.weight / all * part.mean;
    least = std::min(least, part.mean - 10.0 * part.deviation);
    most = std::max(most, part.mean + 10.0 * part.deviation);
  }
  const auto quantile = [&](double probability) {
    double low = least;
    double high = most;
    for (int k = 0; k < kBisections; ++k) {
      const double x = 0.5 * (low + high);
      double below = 0.0;
      for (const Part& part : parts) {
        below += part.weight *
                 (part.deviation > 0.0
                      ? 0.5 * std::erfc((part.mean - x) /
                                        (std::sqrt(2.0) * part.deviation))
                      : (x >= part.mean ? 1.0 : 0.0));
      }
      (below < probability * all ? low : high) = x;
    }
    const double x = 0.5 * (low + high);
    // That of no change.
    return std::abs(x) < kRounding ? 0.0 : x;
  };
  value.low = quantile(kHalfTail);
  value.high = quantile(1.0 - kHalfTail);
  return value;
}

CourseEstimate CourseEstimator::RateOf(Index a) const {
  return ValueOf(a, [this](const CourseTimes& times) {
    return times.at_once() ? 0.0 : 1.0 - times.ShareAt(now_ - kCourseMonth);
  });
}

double CourseEstimator::LargestRateUnseen(Index a) const {
  const CourseEstimate rate = ValueOf(
      a,
      [this](const CourseTimes& times) {
        return 1.0 - times.ShareAt(now_ - kCourseMonth);
      },
      /*unfinished=*/true);
  return std::max(-rate.low, rate.high);
}

CourseEstimator::Misfit CourseEstimator::MisfitOfBest() const {
  double squares = -score_.dot(projected_);
  double freedom = -static_cast<double>(n_) - 1.0;
  for (const ScoredBatch& batch : batches_) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(batch.information);
    const VectorXd& values = solver.eigenvalues();
    const VectorXd along = solver.eigenvectors().transpose() * batch.score;
    for (Index k = 0; k < n_; ++k) {
      if (values(k) <= kRankLimit * values(n_ - 1)) continue;
      squares += along(k) * along(k) / values(k);
      freedom += 1.0;
    }
  }
  if (freedom < 1.0) return {};
  const double left = std::max(squares - best_gain_, 0.0);
  // The squares beyond those expected of noise.
  const double more = squares - freedom;
  return {.dispersion = std::max(left / freedom, 1.0),
          .explained = more > 0.0 ? std::min(best_gain_ / more, 1.0) : 1.0};
}

AgeingCourse CourseEstimator::Estimate() const {
  LogSum changed;
  Index best = 0;
  for (Index a = 0; a < n_; ++a) {
    const double value = of_parameter_[static_cast<std::size_t>(a)].value();
    changed.Add(value);
    if (value > of_parameter_[static_cast<std::size_t>(best)].value()) best = a;
  }
  AgeingCourse course;
  course.element = static_cast<int>(best / 3);
  course.parameter = static_cast<int>(best % 3);
  course.probability = std::exp(
      of_parameter_[static_cast<std::size_t>(best)].value() - changed.value());
  course.changed = 1.0 / (1.0 + std::exp(log_none_ - changed.value()));
  course.change = ValueOf(best, [](const CourseTimes&) { return 1.0; });
  course.rate = RateOf(best);
  const int points =
      course.is_known()
          ? std::min(kMostPoints, static_cast<int>(now_ - first_) + 1)
          : 0;
  for (int k = 0; k < points; ++k) {
    const double time = first_ + (now_ - first_) * k / (points - 1);
    course.points.push_back({time, ValueOf(best, [&](const CourseTimes& times) {
                               return times.ShareAt(time);
                             })});
  }
  const bool moves = course.rate.low > 0.0 || course.rate.high < 0.0;
  const auto limit = [](Index a) {
    return a % 3 == 0 ? kSmallGain : kSmallOther;
  };
  bool steady = std::max(-course.rate.low, course.rate.high) <= limit(best);
  for (Index a = 0; a < n_; ++a) {
    const double most = LargestRateUnseen(a);
    if (!course.is_known()) steady = steady && most <= limit(a);
    if (a % 3 == 0) {
      course.largest_gain_rate = std::max(course.largest_gain_rate, most);
    }
  }
  using Course = AgeingCourse::State;
  if (moves) {
    course.state = course.probability >= AgeingCourse::kKnown
                       ? Course::kTrend
                       : Course::kWhichElement;
  } else {
    course.state = steady ? Course::kSteady : Course::kWhetherAtAll;
  }
  return course;
}

}  // namespace

AgeingCourse EstimateCourse(const std::vector<ScoredBatch>& batches, int now,
                            const WatchOptions& options) {
  if (batches.size() < kLeastBatches) return {};
  const ScoredBatch& first = batches.front();
  if (std::max(now, batches.back().number) - first.number < kLeastSpan ||
      first.score.size() == 0) {
    return {};
  }
  const CourseEstimator estimator(batches, now, options);
  const CourseEstimator::Misfit misfit = estimator.MisfitOfBest();
  if (misfit.dispersion == 1.0) return estimator.Estimate();
  std::vector<ScoredBatch> dispersed = batches;
  for (ScoredBatch& batch : dispersed) {
    batch.score /= misfit.dispersion;
    batch.information /= misfit.dispersion;
  }
  AgeingCourse course = CourseEstimator(dispersed, now, options).Estimate();
  if (misfit.explained < kLeastExplained &&
      misfit.dispersion > kMostDispersion) {
    course.state = AgeingCourse::State::kNoSingleChange;
  }
  return course;
}

}  // namespace mle
