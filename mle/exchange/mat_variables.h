// MAT files as libmatio reads them: variables that free themselves, and the
// sizes that a file of version 5 states, checked before libmatio relies on
// them. Internal to mle/exchange.

#ifndef MLE_EXCHANGE_MAT_VARIABLES_H_
#define MLE_EXCHANGE_MAT_VARIABLES_H_

#include <matio.h>

#include <cstddef>
#include <memory>
#include <string_view>
#include <vector>

namespace mle {

struct CloseMat {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using Mat = std::unique_ptr<mat_t, CloseMat>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;
using Sizes = std::vector<std::size_t>;

// Whether the variables end with the file, their parts with them, and arrays of
// numbers, characters and cells have no more entries than there are bytes for,
// compressed ones too. libmatio does not look: it asks for the memory of, and
// goes over, as many entries as a damaged file states.
bool IsWholeMatFile(std::string_view bytes);

}  // namespace mle

#endif  // MLE_EXCHANGE_MAT_VARIABLES_H_
