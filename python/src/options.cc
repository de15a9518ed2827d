#include "python/src/options.h"

#include <algorithm>

#include "pybind11/stl.h"
#include "python/src/status.h"

namespace mle::python {

void SetOptions(const OptionTexts& options, OptionTable& table) {
  for (const auto& [name, text] : options) {
    ThrowUnlessOk(table.Set(name, text));
  }
  ThrowUnlessOk(table.Read());
}

pybind11::list TextsOf(const OptionTable& table,
                       const std::vector<std::string>& without) {
  pybind11::list texts;
  for (const OptionText& text : table.Texts()) {
    if (std::count(without.begin(), without.end(), text.name) > 0) continue;
    const std::vector<std::string> choices =
        text.is_switch ? std::vector<std::string>{"true", "false"}
                       : text.values;
    texts.append(pybind11::make_tuple(text.group, text.name, text.default_text,
                                      text.kind, WithoutDashes(text.help),
                                      choices));
  }
  return texts;
}

}  // namespace mle::python
