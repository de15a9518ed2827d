// A score and its information in 2 bytes for each number, so that what is lost
// does not change what a score says where nothing has changed. With the factor
// of Cholesky
//
//   V = L Lᵀ,   S = L z,
//
// z is a standard normal vector then. Kept are L, each row in steps of a power
// of 2 for which 14 to 15 bits reach up to √V_aa, and z likewise, so that S and
// V = L Lᵀ, of the L that is kept, still belong together, and V never has a
// negative eigenvalue. Directions in which V says less than 10⁻⁹ of its
// diagonal are left out. But for those at that limit, what has been packed once
// does not change when it is again.
//
//   n exponents of 1 byte, n (n + 1)/2 numbers of L row by row, an exponent and
//   n numbers of z

#ifndef APPS_WATCH_PACKED_SCORE_H_
#define APPS_WATCH_PACKED_SCORE_H_

#include <cstddef>
#include <string>
#include <string_view>

#include "mle/monitor/change_evidence.h"

namespace mle::watch {

// Of n parameters.
std::size_t PackedSize(std::size_t n);

void Pack(const ScorePart& part, std::string& bytes);
// Of PackedSize(n) bytes.
ScorePart Unpack(std::size_t n, std::string_view bytes);

}  // namespace mle::watch

#endif  // APPS_WATCH_PACKED_SCORE_H_
