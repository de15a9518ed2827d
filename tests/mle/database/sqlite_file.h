// An SQLite file of its own for a test, gone afterwards.

#ifndef TESTS_MLE_DATABASE_SQLITE_FILE_H_
#define TESTS_MLE_DATABASE_SQLITE_FILE_H_

#include <string>

namespace mle {

class SqliteFile {
 public:
  SqliteFile();
  ~SqliteFile();
  SqliteFile(const SqliteFile&) = delete;
  SqliteFile& operator=(const SqliteFile&) = delete;

  const std::string& path() const { return path_; }
  std::string folder() const { return folder_; }
  // "sqlite:FILE".
  std::string name() const { return "sqlite:" + path_; }
  // Statements separated by semicolons; a failure of the test if one is wrong.
  void Run(const std::string& sql) const;
  // The first value of the first row as text.
  std::string Value(const std::string& query) const;

 private:
  std::string folder_;
  std::string path_;
};

}  // namespace mle

#endif  // TESTS_MLE_DATABASE_SQLITE_FILE_H_
