// Whether a correction has left an element as it was. Internal to
// mle/exchange.

#ifndef MLE_EXCHANGE_SAME_ELEMENT_H_
#define MLE_EXCHANGE_SAME_ELEMENT_H_

#include "mle/model/transfer_function.h"

namespace mle {

inline bool IsSameElement(const TransferFunction& a,
                          const TransferFunction& b) {
  return a.numerator() == b.numerator() && a.denominator() == b.denominator() &&
         a.delay() == b.delay();
}

}  // namespace mle

#endif  // MLE_EXCHANGE_SAME_ELEMENT_H_
