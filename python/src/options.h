// Options given as keywords: the table of a command, with Python's values as
// the texts of its flags (python/mle/options.py writes them).

#ifndef PYTHON_SRC_OPTIONS_H_
#define PYTHON_SRC_OPTIONS_H_

#include <string>
#include <utility>
#include <vector>

#include "apps/common/option_table.h"
#include "pybind11/pybind11.h"

namespace mle::python {

using OptionTexts = std::vector<std::pair<std::string, std::string>>;

// Sets and checks them. Throws StatusError.
void SetOptions(const OptionTexts& options, OptionTable& table);

// (group, name, default, kind, help) of each, but for those in `without`.
pybind11::list TextsOf(const OptionTable& table,
                       const std::vector<std::string>& without = {});

}  // namespace mle::python

#endif  // PYTHON_SRC_OPTIONS_H_
