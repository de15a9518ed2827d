// Responses of elements, and what was made of them, kept for the next look.
// Internal to mle/explain.

#ifndef MLE_EXPLAIN_RESPONSE_CACHE_H_
#define MLE_EXPLAIN_RESPONSE_CACHE_H_

#include <cstddef>
#include <utility>
#include <vector>

#include "Eigen/Core"

namespace mle {

// What a response for a gain of 1 depends on. As it is: an element of the model
// without explanations.
struct ResponseKey {
  double time_scale = 1.0;  // T
  double delay = 0.0;       // L, < 0 where a clock is ahead
  double second_lag = 0.0;
  double lead = 0.0;
  double falling = 1.0;  // the lag downwards, in that upwards
  // Of the input, θ of each explanation; 0: none.
  double curve = 0.0;
  double slowness = 0.0;  // τ over the full range, at the limit of the rate
  double backlash = 0.0;
  double limit = 0.0;
  double load = 0.0;  // with set points
  int load_part = 0;  // which (Explanation::part)
  // Samples of an average; 0: none.
  double average = 0.0;
  // The shape of a gain that changes during the record; −1: none.
  int change = -1;

  bool operator==(const ResponseKey&) const = default;
};
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
