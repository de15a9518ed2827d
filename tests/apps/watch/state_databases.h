// A state in SQLite and in PostgreSQL, for tests of both.

#ifndef TESTS_APPS_WATCH_STATE_DATABASES_H_
#define TESTS_APPS_WATCH_STATE_DATABASES_H_

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/watch/state.h"
#include "gtest/gtest.h"
#include "tests/mle/database/postgresql_server.h"

namespace mle::watch {

// A file that is gone after the test. Tests run side by side: each has its own.
class StateFile {
 public:
  StateFile() : file_(NameOfFile()) { Remove(); }
  ~StateFile() { Remove(); }
  StateFile(const StateFile&) = delete;
  StateFile& operator=(const StateFile&) = delete;

  const std::string& file() const { return file_; }

 private:
  static std::string NameOfFile() {
    std::string name =
        testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '_');
    return testing::TempDir() + "/state_" + name + ".sqlite";
  }
  void Remove() const {
    for (const char* end : {"", "-wal", "-shm"}) {
      std::filesystem::remove(file_ + end);
    }
  }

  std::string file_;
};

// In SQLite, and in PostgreSQL.
class StateDatabases : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!GetParam()) {
      name_ = folder_.file();
      return;
    }
    if (!PostgresqlServer::IsInstalled()) GTEST_SKIP() << "no PostgreSQL";
    server_.emplace();
    ASSERT_TRUE(server_->is_running());
    name_ = server_->name("postgres");
  }

  State Open() const {
    absl::StatusOr<State> state = State::Open(name_);
    EXPECT_TRUE(state.ok()) << state.status();
    return *std::move(state);
  }

  const StateFile folder_;
  std::optional<PostgresqlServer> server_;
  std::string name_;
};

}  // namespace mle::watch

#endif  // TESTS_APPS_WATCH_STATE_DATABASES_H_
