// The columns of a table of elements (element_table.h), by the names that
// people give them: "Gain", "K", "Time_Constant", "tau [min]". Internal to
// mle/exchange.

#ifndef MLE_EXCHANGE_ELEMENT_COLUMNS_H_
#define MLE_EXCHANGE_ELEMENT_COLUMNS_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mle {

enum ElementColumn {
  kOutputColumn,
  kInputColumn,
  kGainColumn,
  kTimeConstantColumn,
  kSecondColumn,
  kLeadColumn,
  kDelayColumn,
  kIntegratingColumn,
  kDifferenceColumn,  // what the program writes; it is not read
  kNumElementColumns
};

// "dead time", as the program writes it.
const char* NameOf(ElementColumn column);

// Of a field of a header; a unit in brackets at its end does not count.
std::optional<ElementColumn> ElementColumnOf(std::string_view field);

// The unit in brackets at its end: "min" of "tau [min]"; empty without one.
std::string UnitInHeader(std::string_view field);

// Whether the fields of a header are those of a table of elements: output,
// input and gain are among them.
bool IsElementHeader(const std::vector<std::string>& fields);

// Whether a field of the column "integrating" says yes ("yes", "integrator",
// "1", …) or no (empty, "no", "first order", …); nothing where it is neither.
std::optional<bool> IsIntegratingField(std::string_view field);

}  // namespace mle

#endif  // MLE_EXCHANGE_ELEMENT_COLUMNS_H_
