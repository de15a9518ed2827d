// Checks the sizes that a MAT file of version 5 states, before libmatio relies
// on them. Internal to mle/exchange.

#ifndef MLE_EXCHANGE_MAT_STRUCTURE_H_
#define MLE_EXCHANGE_MAT_STRUCTURE_H_

#include <string_view>

namespace mle {

// Whether the variables end with the file, their parts with them, and arrays of
// numbers, characters and cells have no more entries than there are bytes for,
// compressed ones too. libmatio does not look: it asks for the memory of, and
// goes over, as many entries as a damaged file states.
bool IsWholeMatFile(std::string_view bytes);

}  // namespace mle

#endif  // MLE_EXCHANGE_MAT_STRUCTURE_H_
