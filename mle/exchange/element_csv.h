// Tables of elements, read from tables of any kind. Internal to mle/exchange.

#ifndef MLE_EXCHANGE_ELEMENT_CSV_H_
#define MLE_EXCHANGE_ELEMENT_CSV_H_

#include "absl/status/statusor.h"
#include "mle/exchange/element_table.h"
#include "mle/exchange/model_table.h"

namespace mle {

absl::StatusOr<ElementTable> ElementsOf(const ModelTable& table);

}  // namespace mle

#endif  // MLE_EXCHANGE_ELEMENT_CSV_H_
