// A PostgreSQL server for a test: in a temporary folder, on a socket there, in
// a zone and with a form of dates that are not the usual ones. One server
// serves all tests of a process, one after the other; the database `plant` is
// empty at the beginning of each. Roles: `postgres` and `open` (who may read
// all) need no password, `reader` (who may read all) has one.

#ifndef TESTS_MLE_DATABASE_POSTGRESQL_SERVER_H_
#define TESTS_MLE_DATABASE_POSTGRESQL_SERVER_H_

#include <string>

#include "tests/mle/base/scratch_folder.h"

namespace mle {

class PostgresqlServer {
 public:
  PostgresqlServer();
  PostgresqlServer(const PostgresqlServer&) = delete;
  PostgresqlServer& operator=(const PostgresqlServer&) = delete;

  // Whether the machine has Debian's packages of the server.
  static bool IsInstalled();
  static constexpr char kPassword[] = "geheim-4711";

  bool is_running() const { return is_running_; }
  const std::string& folder() const { return folder_; }
  // A URI of the database.
  std::string name(const std::string& role = "open") const;
  // Statements; a failure of the test if one is wrong.
  void Run(const std::string& sql) const;
  // The first value of the first row.
  std::string Value(const std::string& query) const;
  // As if the machine had lost its power.
  void Kill();

 private:
  class Shared;
  static Shared& Process();

  const ScratchFolder& scratch_;
  const std::string folder_;
  bool is_running_ = false;
};

}  // namespace mle

#endif  // TESTS_MLE_DATABASE_POSTGRESQL_SERVER_H_
