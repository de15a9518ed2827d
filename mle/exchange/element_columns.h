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

// Lower case, a blank for each underline: "Time_unit" is "time unit".
std::string FoldedKey(std::string_view text);

// Its values are times.
inline bool IsTimeColumn(ElementColumn column) {
  return column == kTimeConstantColumn || column == kSecondColumn ||
         column == kLeadColumn || column == kDelayColumn;
}

// "dead time", as the program writes it.
const char* NameOf(ElementColumn column);

// The column that a field of a header names, nothing for other fields; a unit
// in brackets at its end does not count.
std::optional<ElementColumn> ElementColumnOf(std::string_view field);

// A damping ratio: zeta, xi, damping.
bool IsDampingField(std::string_view field);

// The one unit in brackets of the columns of times that have one ("Tau (min)",
// "theta [min]"); empty where there is none, or they differ.
std::string TimeUnitInHeader(const std::vector<std::string>& fields);

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
