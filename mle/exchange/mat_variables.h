// Variables of libmatio that free themselves. Internal to mle/exchange.

#ifndef MLE_EXCHANGE_MAT_VARIABLES_H_
#define MLE_EXCHANGE_MAT_VARIABLES_H_

#include <matio.h>

#include <cstddef>
#include <memory>
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

}  // namespace mle

#endif  // MLE_EXCHANGE_MAT_VARIABLES_H_
