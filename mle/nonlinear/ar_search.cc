#include "mle/nonlinear/ar_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace mle {
namespace {

// −1/ln φ of the fastest AR component, in samples: below, it is white.
constexpr double kShortestMemory = 0.8;
constexpr double kLongestShare = 1.0 / 3.0;  // of the shortest segment
constexpr double kSlowestPole = 3.0;  // in shortest segments, behind a lag
// ζ below is a periodic line.
constexpr double kLeastArDamping = 0.03;
// The coarse grid: factors of time constants, steps of ln σ.
constexpr double kMemoryStep = 4.0;
constexpr double kResonanceStep = 2.5;
constexpr double kResonanceDamping = 0.25;
constexpr double kArStep = 2.5;
// The least ratio of the AR component's stationary variance to that of the
// white part; places of the grid above it.
constexpr double kLeastAr = 0.02;
constexpr int kFirstPlace = 1;
constexpr int kLastPlace = 7;
constexpr double kFirstStep = 1.0;
constexpr double kLocalStep = 0.25;  // from where it was before
// A smaller difference of −2 ln L does not count.
constexpr double kNoGain = 0.01;
// The best of the grid must gain this much for the simplex to be worth it.
constexpr double kPromise = 3.0;
constexpr int kMostEvaluations = 150;  // for three parameters

// ln ρ, ln σ, ln 1/ω and ln ζ.
using LogShape = std::array<double, 4>;

struct Vertex {
  LogShape x;
  Profile profile;
};

bool Better(const Vertex& a, const Vertex& b) {
  return a.profile.value < b.profile.value;
}

class ArSearch {
 public:
  ArSearch(const ShapeLikelihood& likelihood, int order)
      : likelihood_(likelihood),
        segment_(likelihood.problem().shortest_segment()),
        longest_(std::max(kLongestShare * segment_, kShortestMemory)),
        order_(order) {}

  // The best of the grid: without a walk, and with one as in `walk`, the best
  // without an AR component. For given poles −2 ln L has one minimum in σ: none
  // beyond the least σ if that is worse than no AR component, or else sought
  // from where the poles before had theirs.
  Profile OfGrid(const Profile& walk) const {
    std::vector<Profile> without = {
        walk.shape.ratio > 0.0 ? likelihood_.At(NoiseShape()) : walk};
    if (walk.shape.ratio > 0.0) without.push_back(walk);
    Profile best;
    for (const Profile& plain : without) {
      int place = kFirstPlace;
      for (NoiseShape shape : order_ == 1 ? FirstOrders() : SecondOrders()) {
        shape.ratio = plain.shape.ratio;
        Profile profile = At(shape, 0);
        if (profile.value < plain.value) profile = OfPoles(shape, place);
        if (profile.value < best.value) best = profile;
      }
    }
    return best;
  }

  // The simplex from `start`, whose AR component is positive, and the end
  // without a walk.
  Profile From(const Profile& start, double step) const {
    std::vector<Vertex> simplex = FirstSimplex(start, step);
    const int n = order_ + 2;
    const int most = kMostEvaluations * n / 3;
    for (int evaluations = n + 1; evaluations < most;) {
      std::stable_sort(simplex.begin(), simplex.end(), Better);
      if (simplex.back().profile.value - simplex.front().profile.value <
          0.1 * kNoGain) {
        break;
      }
      evaluations += Step(simplex);
    }
    Profile best =
        std::min_element(simplex.begin(), simplex.end(), Better)->profile;
    NoiseShape still = best.shape;
    still.ratio = 0.0;
    const Profile without_walk = likelihood_.At(still);
    return without_walk.value < best.value + kNoGain ? without_walk : best;
  }

 private:
  std::vector<NoiseShape> FirstOrders() const {
    std::vector<NoiseShape> shapes;
    for (double memory = kShortestMemory; memory <= longest_ * (1.0 + 1e-9);
         memory *= kMemoryStep) {
      shapes.push_back({.ar_pole = PoleOf(memory)});
    }
    return shapes;
  }

  // Two real poles, and resonances.
  std::vector<NoiseShape> SecondOrders() const {
    std::vector<NoiseShape> shapes;
    const double fastest = kMemoryStep * kShortestMemory;
    for (double lag = fastest; lag <= longest_; lag *= kMemoryStep) {
      for (const double t : {kMemoryStep * lag, kSlowestPole * segment_}) {
        const double memory = std::sqrt(lag * t);
        if (memory > longest_) continue;
        shapes.push_back({.ar_pole = PoleOf(memory),
                          .ar_damping = 0.5 * (lag + t) / memory});
      }
    }
    for (double memory = kResonanceStep * kShortestMemory; memory <= longest_;
         memory *= kResonanceStep) {
      shapes.push_back(
          {.ar_pole = PoleOf(memory), .ar_damping = kResonanceDamping});
    }
    return shapes;
  }

  // With these poles, the stationary variance kLeastAr e^(2.5 place) of the
  // white part's.
  Profile At(NoiseShape shape, int place) const {
    shape.ar_ratio =
        kLeastAr / shape.ar().Stationary().aa * std::exp(kArStep * place);
    return likelihood_.At(shape);
  }

  Profile OfPoles(const NoiseShape& shape, int& place) const {
    Profile best = At(shape, place);
    bool moved = false;
    for (const int direction : {1, -1}) {
      while (!(direction < 0 && moved) && place + direction >= 0 &&
             place + direction <= kLastPlace) {
        const Profile next = At(shape, place + direction);
        if (!(next.value < best.value)) break;
        best = next;
        place += direction;
        moved = moved || direction > 0;
      }
    }
    return best;
  }

  Vertex AtLog(LogShape x) const {
    for (int i = 0; i < 2; ++i) {
      x[i] = std::clamp(x[i], kMinLogRatio, kMaxLogRatio);
    }
    x[2] = std::clamp(x[2], std::log(kShortestMemory), std::log(longest_));
    const double memory = std::exp(x[2]);
    NoiseShape shape = {.ratio = std::exp(x[0]),
                        .ar_ratio = std::exp(x[1]),
                        .ar_pole = PoleOf(memory)};
    if (order_ == 2) {
      // The slow pole's time constant over the natural one, above 1.
      const double slowest =
          std::min(kSlowestPole * segment_ / memory, memory / kShortestMemory);
      const double most = slowest > 1.0 ? 0.5 * (slowest + 1.0 / slowest) : 1.0;
      x[3] = std::clamp(x[3], std::log(kLeastArDamping), std::log(most));
      shape.ar_damping = std::exp(x[3]);
    }
    return {x, likelihood_.At(shape)};
  }

  std::vector<Vertex> FirstSimplex(const Profile& start, double step) const {
    const NoiseShape& shape = start.shape;
    // A walk too small to matter still has a slope.
    const double ratio = std::max(shape.ratio, 1e-3 * shape.ar_ratio);
    LogShape x = {std::log(ratio), std::log(shape.ar_ratio),
                  std::log(MemoryOf(shape.ar_pole)), 0.0};
    if (order_ == 2) x[3] = std::log(shape.ar_damping);
    std::vector<Vertex> simplex = {AtLog(x)};
    for (int i = 0; i < order_ + 2; ++i) {
      LogShape moved = x;
      // Away from the longest memory, and towards less of a walk.
      moved[i] += i == 1 ? step : -step;
      simplex.push_back(AtLog(moved));
    }
    return simplex;
  }

  // One move of the worst vertex; the evaluations that it takes. Sorted.
  int Step(std::vector<Vertex>& simplex) const {
    const int n = order_ + 2;
    Vertex& worst = simplex[n];
    const auto along = [&](double factor) {
      LogShape at = worst.x;
      for (int i = 0; i < n; ++i) {
        double centre = 0.0;
        for (int v = 0; v < n; ++v) centre += simplex[v].x[i];
        centre /= n;
        at[i] = centre + factor * (worst.x[i] - centre);
      }
      return AtLog(at);
    };
    const Vertex reflected = along(-1.0);
    if (Better(reflected, simplex[0])) {
      const Vertex expanded = along(-2.0);
      worst = Better(expanded, reflected) ? expanded : reflected;
      return 2;
    }
    if (Better(reflected, simplex[n - 1])) {
      worst = reflected;
      return 1;
    }
    const Vertex contracted = along(Better(reflected, worst) ? -0.5 : 0.5);
    if (Better(contracted, worst) && Better(contracted, reflected)) {
      worst = contracted;
      return 2;
    }
    for (int v = 1; v <= n; ++v) {
      for (int i = 0; i < n; ++i) {
        simplex[v].x[i] = 0.5 * (simplex[v].x[i] + simplex[0].x[i]);
      }
      simplex[v] = AtLog(simplex[v].x);
    }
    return 2 + n;
  }

  const ShapeLikelihood& likelihood_;
  double segment_;
  double longest_;
  int order_;
};

}  // namespace

Profile FindBestAr(const ShapeLikelihood& likelihood, int order,
                   const Profile& walk) {
  const ArSearch search(likelihood, order);
  const Profile start = search.OfGrid(walk);
  if (!start.shape.has_ar()) return start;
  if (!(start.value < walk.value - kPromise)) return start;
  return search.From(start, kFirstStep);
}

Profile ContinueAr(const ShapeLikelihood& likelihood, const NoiseShape& start) {
  const Profile former = likelihood.At(start);
  const Profile moved =
      ArSearch(likelihood, start.ar().order()).From(former, kLocalStep);
  return moved.value < former.value - kNoGain ? moved : former;
}

}  // namespace mle
