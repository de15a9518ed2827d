#include "python/src/options.h"

#include <algorithm>

#include "python/src/status.h"

namespace mle::python {

void SetOptions(const OptionTexts& options, OptionTable& table) {
  for (const auto& [name, text] : options) {
    ThrowUnlessOk(table.Set(name, text));
  }
  ThrowUnlessOk(table.Read());
}

std::vector<std::string> NamesIn(const OptionTable& table,
                                 const std::vector<std::string>& without) {
  std::vector<std::string> names;
  for (const auto& [name, value] : table.Values()) {
    if (std::count(without.begin(), without.end(), name) == 0) {
      names.push_back(name);
    }
  }
  return names;
}

}  // namespace mle::python
