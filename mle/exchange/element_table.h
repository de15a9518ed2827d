// Elements of first and second order as a table (CSV, docs/formats.md): a row
// for each pair, with gain K, time constants T and T₂, lead A and dead time L,
//
//   g(s) = K (A s + 1) e^{−Ls} / ((T s + 1) (T₂ s + 1)),
//
// divided by s where the row says that the element integrates.
//
//   time unit,min
//   output,input,gain,time constant,second time constant,lead,dead time
//   temperature,steam,8,12,,,1.5

#ifndef MLE_EXCHANGE_ELEMENT_TABLE_H_
#define MLE_EXCHANGE_ELEMENT_TABLE_H_

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/model/process_model.h"
#include "mle/model/transfer_function.h"

namespace mle {

struct ElementRow {
  int output = 0;
  int input = 0;
  double gain = 0.0;                  // K
  double time_constant = 0.0;         // T ≥ 0; 0: the input acts at once
  double second_time_constant = 0.0;  // T₂ ≥ 0; 0: first order
  double lead = 0.0;                  // A; 0: none
  double delay = 0.0;                 // L ≥ 0
  bool integrating = false;           // K is a slope
  // Largest difference between the step responses of the row and of the element
  // that it stands for, relative to the range; 0 where the row is the element.
  double largest_difference = 0.0;

  TransferFunction Element() const;
};

struct ElementTable {
  ProcessModel channels;         // all elements zero
  std::vector<ElementRow> rows;  // in the order of the file
  bool has_second = false;       // columns of the file
  bool has_lead = false;
  bool has_integrating = false;

  ProcessModel Process() const;
};

// Errors name `source`, line and column: rows that are too long, fields that
// are not numbers, channels that are not known, duplicated pairs,
// elements that are not stable and proper.
absl::StatusOr<ElementTable> ParseElementTable(std::string_view csv,
                                               std::string_view source);

// Numbers read back bit by bit. A column has largest_difference where a row has
// one.
std::string FormatElementTable(const ElementTable& table);

// The table with the elements of `corrected` (the same channels). Rows whose
// elements are those of `table` keep their numbers. An element of the rows'
// form is written exactly; of any other, the one of first or second order
// whose step response is nearest (low_order_fit.h), and how near.
ElementTable WithElements(const ElementTable& table,
                          const ProcessModel& corrected);

// Numbers that are not those of `given` with five significant digits, as they
// are typed into a controller.
ElementTable ForTyping(const ElementTable& given, ElementTable corrected);

// Whether a correction has left an element as it was.

inline bool IsSameElement(const TransferFunction& a,
                          const TransferFunction& b) {
  return a.numerator() == b.numerator() && a.denominator() == b.denominator() &&
         a.delay() == b.delay();
}

}  // namespace mle

#endif  // MLE_EXCHANGE_ELEMENT_TABLE_H_
