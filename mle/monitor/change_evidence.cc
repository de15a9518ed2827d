#include "mle/monitor/change_evidence.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "glog/logging.h"
#include "mle/monitor/log_sum.h"
#include "mle/monitor/output_scores.h"

namespace mle {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kScales = 7;
// Half of the changes expected are so much smaller.
constexpr double kSmaller = 1.0 / 6.0;
// Batches that the evidence has to do without, one at a time.
constexpr std::size_t kDoubted = 3;

// Ages from which batches are merged, and into how many.
constexpr int kOld = 64;
constexpr int kOldBlock = 8;
constexpr int kOldest = 512;
constexpr int kOldestBlock = 64;

int LastOf(const ScoredBatch& batch) { return batch.number + batch.length - 1; }

// Scores and informations of a change that begins with a batch.
struct WhitenedContrast {
  VectorXd score;
  MatrixXd information;
};

// ln of the mixture over δ less the best |δ| ≤ least.
double LogRatio(double score, double information, double least,
                double deviation) {
  LogSum mixture;
  for (const double scale : {deviation, kSmaller * deviation}) {
    const double variance = scale * scale;
    const double growth = 1.0 + variance * information;
    mixture.Add(std::log(0.5) - 0.5 * std::log(growth) +
                0.5 * variance * score * score / growth);
  }
  const double best =
      information > 0.0 ? std::clamp(score / information, -least, least) : 0.0;
  return mixture.value() - best * (score - 0.5 * best * information);
}

// Sums of batches from the first on, and contrasts against all before.
class Suffixes {
 public:
  Suffixes(const std::vector<ScoredBatch>& batches, double model_error)
      : batches_(batches), prior_(1.0 / (model_error * model_error)) {
    const Index n = batches.empty() ? 0 : batches.front().score.size();
    scores_.push_back(VectorXd::Zero(n));
    informations_.push_back(MatrixXd::Zero(n, n));
    for (const ScoredBatch& batch : batches) {
      CHECK_EQ(batch.score.size(), n);
      scores_.push_back(scores_.back() + batch.score);
      informations_.push_back(informations_.back() + batch.information);
    }
  }

  // Takes batches[0 … last] for all there are.
  void StopAt(std::size_t last) {
    last_ = last;
    const MatrixXd& all = informations_[last + 1];
    solver_.compute(all + prior_ * MatrixXd::Identity(all.rows(), all.cols()));
    projected_ = solver_.solve(scores_[last + 1]);
  }
  // The contrast of a change that begins with batches[begin].
  WhitenedContrast From(std::size_t begin) const {
    const MatrixXd after = informations_[last_ + 1] - informations_[begin];
    return {scores_[last_ + 1] - scores_[begin] - after * projected_,
            after - after * solver_.solve(after)};
  }
  // ln of the weight of all begins that batches[begin] is the first after.
  double LogWeight(std::size_t begin, int life) const {
    int from = 0;
    if (begin > 0) from = LastOf(batches_[begin - 1]) + 1;
    double weight = 0.0;
    for (int d = from; d <= std::min(batches_[begin].number, life - 1); ++d) {
      weight += WeightOfBegin(d, life);
    }
    return weight > 0.0 ? std::log(weight) : kLogZero;
  }

 private:
  const std::vector<ScoredBatch>& batches_;
  double prior_;  // precision of θ
  std::vector<VectorXd> scores_;
  std::vector<MatrixXd> informations_;
  std::size_t last_ = 0;
  Eigen::LDLT<MatrixXd> solver_;
  VectorXd projected_;
};

// The contrast of the parameters first … first + 2, all others eliminated.
struct OwnContrast {
  WhitenedContrast own;
  double log_others = 0.0;  // ln of the likelihood ratio of the others alone
};

OwnContrast WithoutOthers(const WhitenedContrast& all, Index first) {
  const Index n = all.score.size();
  const Index others = n - 3;
  if (others == 0) return {all};
  VectorXd score(others);
  MatrixXd information(others, others);
  MatrixXd across(others, 3);
  const auto index = [first](Index k) { return k < first ? k : k + 3; };
  for (Index r = 0; r < others; ++r) {
    score(r) = all.score(index(r));
    across.row(r) = all.information.row(index(r)).segment(first, 3);
    for (Index c = 0; c < others; ++c) {
      information(r, c) = all.information(index(r), index(c));
    }
  }
  // Their changes are of the order of 1 at most.
  information.diagonal().array() += 1.0;
  const Eigen::LDLT<MatrixXd> solver(information);
  const VectorXd best = solver.solve(score);
  return {.own = {all.score.segment(first, 3) - across.transpose() * best,
                  all.information.block(first, first, 3, 3) -
                      across.transpose() * solver.solve(across)},
          .log_others = 0.5 * score.dot(best)};
}

// The contrasts of all possible begins, from which all evidence is computed.
struct Contrasts {
  std::vector<WhitenedContrast> of_begins;
  std::vector<double> weights;  // their logarithms
  double none = kLogZero;       // ln of the weight of those still to begin
};

Contrasts ContrastsOf(const std::vector<ScoredBatch>& batches,
                      const WatchOptions& options) {
  Contrasts contrasts;
  Suffixes suffixes(batches, options.model_error);
  suffixes.StopAt(batches.size() - 1);
  for (std::size_t s = 0; s < batches.size(); ++s) {
    const double weight = suffixes.LogWeight(s, options.life);
    if (weight == kLogZero) continue;
    contrasts.weights.push_back(weight);
    contrasts.of_begins.push_back(suffixes.From(s));
  }
  double coming = 0.0;
  for (int d = LastOf(batches.back()) + 1; d < options.life; ++d) {
    coming += WeightOfBegin(d, options.life);
  }
  if (coming > 0.0) contrasts.none = std::log(coming);
  return contrasts;
}

// ln E of one element.
double ElementEvidence(const Contrasts& contrasts, Index first,
                       const VectorXd& least, double deviation) {
  std::vector<OwnContrast> own;
  double best_others = 0.0;
  for (const WhitenedContrast& contrast : contrasts.of_begins) {
    own.push_back(WithoutOthers(contrast, first));
    best_others = std::max(best_others, own.back().log_others);
  }
  LogSum sum;
  sum.Add(contrasts.none - best_others);
  for (std::size_t s = 0; s < own.size(); ++s) {
    for (Index a = 0; a < 3; ++a) {
      sum.Add(contrasts.weights[s] - std::log(3.0) + own[s].log_others -
              best_others +
              LogRatio(own[s].own.score(a), own[s].own.information(a, a),
                       least(first + a), deviation));
    }
  }
  return sum.value();
}

// Those batches that the evidence has to do without, one at a time.
std::vector<std::size_t> Doubted(const std::vector<ScoredBatch>& batches) {
  std::vector<std::pair<double, std::size_t>> sizes;
  for (std::size_t b = 0; b < batches.size(); ++b) {
    const ScoredBatch& batch = batches[b];
    const double size =
        batch.largest.has_value()
            ? ExplainedSquares(batch.largest->score, batch.largest->information)
            : ExplainedSquares(batch.score, batch.information);
    sizes.emplace_back(-size, b);
  }
  std::sort(sizes.begin(), sizes.end());
  sizes.resize(std::min(sizes.size(), kDoubted));
  std::vector<std::size_t> doubted;
  for (const auto& [size, b] : sizes) doubted.push_back(b);
  return doubted;
}

// All but the batch, or but the largest change in it.
std::vector<ScoredBatch> Without(const std::vector<ScoredBatch>& batches,
                                 std::size_t doubted) {
  std::vector<ScoredBatch> others = batches;
  ScoredBatch& batch = others[doubted];
  if (batch.largest.has_value()) {
    batch.score -= batch.largest->score;
    batch.information -= batch.largest->information;
  } else {
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(doubted));
  }
  return others;
}

}  // namespace

double WeightOfBegin(int batch, int life) {
  if (batch < 0 || batch >= life) return 0.0;
  double weight = 0.0;
  for (int scale = 0; scale < kScales; ++scale) {
    const int step = 1 << scale;
    if (batch % step != 0) break;
    const int begins = (life + step - 1) / step;
    weight += 1.0 / (kScales * static_cast<double>(begins));
  }
  return weight;
}

ChangeEvidence EvidenceOf(const std::vector<ScoredBatch>& batches,
                          const VectorXd& least, const WatchOptions& options) {
  ChangeEvidence evidence;
  if (batches.empty()) return evidence;
  const Contrasts contrasts = ContrastsOf(batches, options);
  const Index n = batches.front().score.size();
  LogSum output;
  for (std::size_t s = 0; s < contrasts.of_begins.size(); ++s) {
    const WhitenedContrast& contrast = contrasts.of_begins[s];
    for (Index a = 0; a < n; ++a) {
      output.Add(contrasts.weights[s] - std::log(static_cast<double>(n)) +
                 LogRatio(contrast.score(a), contrast.information(a, a),
                          least(a), options.change_deviation));
    }
  }
  output.Add(contrasts.none);
  evidence.number = LastOf(batches.back());
  evidence.log_output = output.value();
  for (Index first = 0; first < n; first += 3) {
    evidence.log_elements.push_back(
        ElementEvidence(contrasts, first, least, options.change_deviation));
  }
  return evidence;
}

double ElementEvidenceOf(const std::vector<ScoredBatch>& batches, int element,
                         const VectorXd& least, const WatchOptions& options) {
  if (batches.empty()) return 0.0;
  return ElementEvidence(ContrastsOf(batches, options), Index{3} * element,
                         least, options.change_deviation);
}

ChangeEvidence ConfirmedEvidenceOf(const std::vector<ScoredBatch>& batches,
                                   const VectorXd& least,
                                   const WatchOptions& options) {
  ChangeEvidence evidence = EvidenceOf(batches, least, options);
  for (const std::size_t b : Doubted(batches)) {
    ChangeEvidence without = EvidenceOf(Without(batches, b), least, options);
    without.log_elements.resize(evidence.log_elements.size(), 0.0);
    evidence.log_output = std::min(evidence.log_output, without.log_output);
    for (std::size_t e = 0; e < evidence.log_elements.size(); ++e) {
      evidence.log_elements[e] =
          std::min(evidence.log_elements[e], without.log_elements[e]);
    }
  }
  return evidence;
}

double ConfirmedElementEvidenceOf(const std::vector<ScoredBatch>& batches,
                                  int element, const VectorXd& least,
                                  const WatchOptions& options) {
  double evidence = ElementEvidenceOf(batches, element, least, options);
  for (const std::size_t b : Doubted(batches)) {
    evidence = std::min(evidence, ElementEvidenceOf(Without(batches, b),
                                                    element, least, options));
  }
  return evidence;
}

std::vector<ScoredBatch> MergeOld(const std::vector<ScoredBatch>& batches,
                                  int now) {
  std::vector<ScoredBatch> merged;
  for (const ScoredBatch& batch : batches) {
    int block = 1;
    // Whole blocks only.
    for (const auto& [length, age] :
         {std::pair(kOldestBlock, kOldest), std::pair(kOldBlock, kOld)}) {
      const int end = (batch.number / length + 1) * length - 1;
      if (block == 1 && now - end >= age) block = length;
    }
    const int begin = batch.number / block * block;
    if (block > 1 && !merged.empty() && merged.back().length == block &&
        merged.back().number == begin) {
      merged.back().score += batch.score;
      merged.back().information += batch.information;
      continue;
    }
    merged.push_back(batch);
    if (block <= batch.length) continue;
    merged.back().largest.reset();
    merged.back().number = begin;
    merged.back().length = block;
  }
  return merged;
}

Eigen::Matrix3d OwnInformation(const std::vector<ScoredBatch>& batches,
                               int begin, int element,
                               const WatchOptions& options) {
  std::size_t first = 0;
  while (first < batches.size() && batches[first].number < begin) ++first;
  if (first == batches.size()) return Eigen::Matrix3d::Zero();
  Suffixes suffixes(batches, options.model_error);
  suffixes.StopAt(batches.size() - 1);
  return WithoutOthers(suffixes.From(first), Index{3} * element)
      .own.information;
}

LikelyChange ExplainEvidence(const std::vector<ScoredBatch>& batches,
                             const VectorXd& least,
                             const WatchOptions& options) {
  LikelyChange likely;
  if (batches.empty()) return likely;
  Suffixes suffixes(batches, options.model_error);
  suffixes.StopAt(batches.size() - 1);
  const Index n = batches.front().score.size();
  const double variance = options.change_deviation * options.change_deviation;
  LogSum total;
  std::vector<LogSum> elements(static_cast<std::size_t>(n / 3));
  std::vector<double> best(elements.size(), kLogZero);
  std::vector<LikelyChange> candidates(elements.size());
  for (std::size_t s = 0; s < batches.size(); ++s) {
    const double weight = suffixes.LogWeight(s, options.life);
    if (weight == kLogZero) continue;
    const WhitenedContrast contrast = suffixes.From(s);
    for (Index a = 0; a < n; ++a) {
      const double information = contrast.information(a, a);
      const double value =
          weight + LogRatio(contrast.score(a), information, least(a),
                            options.change_deviation);
      const auto e = static_cast<std::size_t>(a / 3);
      total.Add(value);
      elements[e].Add(value);
      if (value <= best[e]) continue;
      best[e] = value;
      const double precision = information + 1.0 / variance;
      candidates[e] = {.element = static_cast<int>(e),
                       .parameter = static_cast<int>(a % 3),
                       .probability = 0.0,
                       .change = contrast.score(a) / precision,
                       .error = 1.0 / std::sqrt(precision),
                       .begin = batches[s].number};
    }
  }
  for (std::size_t e = 0; e < elements.size(); ++e) {
    candidates[e].probability = std::exp(elements[e].value() - total.value());
    if (candidates[e].probability > likely.probability) likely = candidates[e];
  }
  return likely;
}

double HealthOf(double log_evidence, double share_of_level) {
  return 1.0 / (1.0 + std::exp(std::log(share_of_level) + log_evidence));
}

}  // namespace mle
