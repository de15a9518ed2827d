#include "mle/base/fast_length.h"

#include <initializer_list>

namespace mle {

int FastLength(int count) {
  for (int length = count;; ++length) {
    int rest = length;
    for (const int factor : {2, 3, 5}) {
      while (rest % factor == 0) rest /= factor;
    }
    if (rest == 1) return length;
  }
}

}  // namespace mle
