// URIs of PostgreSQL, as libpq reads them. Internal to mle/database.

#ifndef MLE_DATABASE_POSTGRESQL_URI_H_
#define MLE_DATABASE_POSTGRESQL_URI_H_

#include <string>

#include "absl/status/statusor.h"

namespace mle {

// `uri` with all that it says as parameters, "postgresql:///?host=…&user=…",
// and with `password` if that is not empty. InvalidArgument for a URI that has
// a password in it or cannot be read; it does not repeat the URI.
//
// Everything is written by letters, digits and percent signs: SOCI takes what
// it is given apart at blanks, quotes and equals signs.
absl::StatusOr<std::string> PostgresqlParameters(const std::string& uri,
                                                 const std::string& password);

}  // namespace mle

#endif  // MLE_DATABASE_POSTGRESQL_URI_H_
