#include "mle/database/sql_backend.h"

namespace mle {

std::string SqlBackend::Quote(const std::string& name) const {
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace mle
