// Responses of elements, and what was made of them, kept for the next look.
// Internal to mle/explain.

#ifndef MLE_EXPLAIN_RESPONSE_CACHE_H_
#define MLE_EXPLAIN_RESPONSE_CACHE_H_

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "Eigen/Core"

namespace mle {

// What a response for a gain of 1 depends on: T, L, the second lag, the lead,
// the ratio of the lag downwards; the input's curve, rate, backlash, limit,
// load with set points and its part; the time of an average; and the shape,
// plus one, of a gain that changes during the record.
using ResponseKey = std::array<double, 13>;
// A part of z: `gain` times the response of an element.
struct ResponsePart {
  int element = 0;
  ResponseKey key;
  double gain = 0.0;
};

// Vectors made of responses, those used last for each element.
class ResponseCache {
 public:
  // `size`: of each vector.
  explicit ResponseCache(double size = 1.0);
  template <typename Make>
  const Eigen::VectorXd& Get(const ResponsePart& part, const Make& make) {
    if (Find(part)) return elements_[part.element].back().second;
    return Keep(part, make());
  }
  void Clear() { elements_.clear(); }

 private:
  // Moves the vector of this part to the end of those of its element.
  bool Find(const ResponsePart& part);
  const Eigen::VectorXd& Keep(const ResponsePart& part, Eigen::VectorXd value);

  std::size_t most_ = 4;
  std::vector<std::vector<std::pair<ResponseKey, Eigen::VectorXd>>> elements_;
};

}  // namespace mle

#endif  // MLE_EXPLAIN_RESPONSE_CACHE_H_
