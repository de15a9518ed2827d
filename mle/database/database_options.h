// The part of a database that is read: a query, or a table and its columns.
//
//   DatabaseOptions options;
//   options.table = "plant.trend";
//   options.columns = {"time", "TI101", "FC7"};

#ifndef MLE_DATABASE_DATABASE_OPTIONS_H_
#define MLE_DATABASE_DATABASE_OPTIONS_H_

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace mle {

inline constexpr char kBeginPlace[] = "{begin}";
inline constexpr char kEndPlace[] = "{end}";

struct DatabaseOptions {
  // In SQL; its rows are taken in the order in which they come. {begin} and
  // {end} are replaced by the limits of the time range, a day before and after,
  // as in WHERE time BETWEEN '{begin}' AND '{end}'.
  std::string query = {};
  // A table or view instead, with its schema where one is needed; names that
  // have points or quotes in them are quoted: plant."my.table". Rows come in
  // order of time.
  std::string table = {};
  // Columns of the table; empty: all. The column of times is always read.
  std::vector<std::string> columns = {};
  // Asks for a password, where the database wants one and neither environment
  // nor service file has it; nothing: there is nobody to ask.
  std::function<std::optional<std::string>(const std::string& prompt)>
      ask_password = {};

  // Exactly one of query and table; columns with a table only.
  absl::Status Validate() const;
};

}  // namespace mle

#endif  // MLE_DATABASE_DATABASE_OPTIONS_H_
