// Options from an object of a JSON file: a key for each, with the name, range
// and field that the option has as a flag (option_table.h).

#ifndef APPS_COMMON_OPTION_JSON_H_
#define APPS_COMMON_OPTION_JSON_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "mle/model/json_node.h"

namespace mle {

// Fields whose key is absent keep their value. Errors name the key, what was
// found and what would be right.
absl::Status ReadOptions(const JsonNode& object,
                         const std::vector<Option>& options);

// The same of an object that has all of `required` and no keys but these and
// the options.
absl::Status ReadOptionsOnly(const JsonNode& object,
                             const std::vector<std::string>& required,
                             const std::vector<Option>& options);

}  // namespace mle

#endif  // APPS_COMMON_OPTION_JSON_H_
