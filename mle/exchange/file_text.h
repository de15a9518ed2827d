// What the text of a model's file is. Internal to mle/exchange.

#ifndef MLE_EXCHANGE_FILE_TEXT_H_
#define MLE_EXCHANGE_FILE_TEXT_H_

#include <string_view>

namespace mle {

// Whether the first character that is not blank is a brace: JSON, not CSV.
inline bool IsJsonText(std::string_view text) {
  const std::size_t start = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  return start != std::string_view::npos && text[start] == '{';
}

}  // namespace mle

#endif  // MLE_EXCHANGE_FILE_TEXT_H_
