#include "tests/mle/database/sqlite_file.h"

#include <sqlite3.h>

#include "gtest/gtest.h"

namespace mle {
namespace {

int KeepFirst(void* value, int columns, char** values, char**) {
  if (columns > 0 && values[0] != nullptr) {
    *static_cast<std::string*>(value) = values[0];
  }
  return 1;  // no more rows
}

}  // namespace

void SqliteFile::Run(const std::string& sql) const {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path_.c_str(), &database), SQLITE_OK);
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &error),
            SQLITE_OK)
      << error;
  sqlite3_free(error);
  sqlite3_close(database);
}

std::string SqliteFile::Value(const std::string& query) const {
  sqlite3* database = nullptr;
  std::string value;
  if (sqlite3_open(path_.c_str(), &database) == SQLITE_OK) {
    sqlite3_exec(database, query.c_str(), &KeepFirst, &value, nullptr);
  }
  sqlite3_close(database);
  return value;
}

}  // namespace mle
