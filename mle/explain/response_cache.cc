#include "mle/explain/response_cache.h"

#include <algorithm>

namespace mle {
namespace {

// Doubles that the vectors of one element may take, and their number.
constexpr double kCachedDoubles = 1 << 21;
constexpr double kFewestCached = 4.0;
constexpr double kMostCached = 128.0;

}  // namespace

ResponseCache::ResponseCache(double size)
    : most_(static_cast<std::size_t>(
          std::clamp(kCachedDoubles / size, kFewestCached, kMostCached))) {}

bool ResponseCache::Find(const ResponsePart& part) {
  const auto element = static_cast<std::size_t>(part.element);
  if (element >= elements_.size()) elements_.resize(element + 1);
  auto& kept = elements_[element];
  for (auto at = kept.end(); at != kept.begin();) {
    --at;
    if (at->first != part.key) continue;
    std::rotate(at, at + 1, kept.end());
    return true;
  }
  return false;
}

const Eigen::VectorXd& ResponseCache::Keep(const ResponsePart& part,
                                           Eigen::VectorXd value) {
  auto& kept = elements_[static_cast<std::size_t>(part.element)];
  if (kept.size() >= most_) kept.erase(kept.begin());
  kept.emplace_back(part.key, std::move(value));
  return kept.back().second;
}

}  // namespace mle
