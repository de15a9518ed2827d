// An SQLite file of its own for a test, gone afterwards.

#ifndef TESTS_MLE_DATABASE_SQLITE_FILE_H_
#define TESTS_MLE_DATABASE_SQLITE_FILE_H_

#include <string>

#include "tests/mle/base/scratch_folder.h"

namespace mle {

class SqliteFile {
 public:
  const std::string& path() const { return path_; }
  const std::string& folder() const { return folder_.path(); }
  // "sqlite:FILE".
  std::string name() const { return "sqlite:" + path_; }
  // Statements separated by semicolons; a failure of the test if one is wrong.
  void Run(const std::string& sql) const;
  // The first value of the first row as text.
  std::string Value(const std::string& query) const;

 private:
  const ScratchFolder folder_;
  const std::string path_ = folder_ / "plant data.db";
};

}  // namespace mle

#endif  // TESTS_MLE_DATABASE_SQLITE_FILE_H_
