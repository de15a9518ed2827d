// The process models of configs/ that commands know by name, built in so that
// they work from any folder.

#ifndef APPS_COMMON_BUILT_IN_MODELS_H_
#define APPS_COMMON_BUILT_IN_MODELS_H_

#include <string_view>

namespace mle {

struct BuiltInModel {
  std::string_view name;    // empty for the initial model
  std::string_view source;  // the file it is built from
  std::string_view json;
};

// The Wood-Berry column as it was commissioned.
extern const BuiltInModel kWoodBerry;
// The aged columns: "gain" and "delay".
extern const BuiltInModel kWoodBerryAged[2];

}  // namespace mle

#endif  // APPS_COMMON_BUILT_IN_MODELS_H_
