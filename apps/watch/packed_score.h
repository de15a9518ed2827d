// A score and its information in few bytes, so that what is lost does not
// change what a score says where nothing has changed. With the factor of
// Cholesky
//
//   V = L Lᵀ,   S = L z,
//
// z is a standard normal vector then. Kept are L̃, L rounded, and z, so that
// L̃ z and L̃ L̃ᵀ, which are taken for S and V, still belong together whatever the
// rounding is, and V never has a negative eigenvalue. In each row a, in which
// no number is larger than √V_aa, the pivot L_aa, which says what the parameter
// adds to those before it, is kept in 2 bytes and the others in 12 bits:
//
//   |L̃_aa − L_aa| ≤ 2⁻¹⁴ √V_aa,   |L̃_ac − L_ac| ≤ 0.05 % √V_aa   (c < a).
//
// After a change δ the mean of z is Lᵀδ, and is taken for L̃ᵀδ: the rounding
// moves each of z by at most
//
//   0.05 % Σ_a √V_aa |δ_a|
//
// standard deviations, which is 0.05 % of those that a change of one parameter
// has in the score of that parameter. Directions in which V says less than 10⁻⁹
// of its diagonal are left out. But for those at that limit, what has been
// packed once does not change when it is again.
//
//   n exponents of 1 byte, of the largest of a row; n pivots; n (n − 1)/2
//   numbers of L row by row, two in 3 bytes; an exponent and n numbers of z

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
