// A state in SQLite and in PostgreSQL, for tests of both.

#ifndef TESTS_APPS_WATCH_STATE_DATABASES_H_
#define TESTS_APPS_WATCH_STATE_DATABASES_H_

#include <optional>
#include <string>

#include "apps/watch/state.h"
#include "gtest/gtest.h"
#include "tests/mle/base/scratch_folder.h"
#include "tests/mle/database/postgresql_server.h"

namespace mle::watch {

// In SQLite, and in PostgreSQL.
class StateDatabases : public ::testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    if (!GetParam()) {
      name_ = folder_ / "state.sqlite";
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

  const ScratchFolder folder_;
  std::optional<PostgresqlServer> server_;
  std::string name_;
};

}  // namespace mle::watch

#endif  // TESTS_APPS_WATCH_STATE_DATABASES_H_
