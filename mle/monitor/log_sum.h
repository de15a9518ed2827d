// ln Σ exp of terms that are added one after another. Internal to mle/monitor.

#ifndef MLE_MONITOR_LOG_SUM_H_
#define MLE_MONITOR_LOG_SUM_H_

#include <cmath>
#include <limits>

namespace mle {

// ln 0.
inline constexpr double kLogZero = -std::numeric_limits<double>::infinity();

class LogSum {
 public:
  void Add(double log_term) {
    if (log_term == kLogZero) return;
    if (log_term > largest_) {
      sum_ = sum_ * std::exp(largest_ - log_term) + 1.0;
      largest_ = log_term;
    } else {
      sum_ += std::exp(log_term - largest_);
    }
  }
  double value() const {
    return sum_ > 0.0 ? largest_ + std::log(sum_) : kLogZero;
  }

 private:
  double largest_ = kLogZero;
  double sum_ = 0.0;
};

}  // namespace mle

#endif  // MLE_MONITOR_LOG_SUM_H_
