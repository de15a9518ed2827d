#include "apps/watch/database.h"

#include <utility>

#include "mle/base/status.h"
#include "mle/database/record_sources.h"

namespace mle::watch {

absl::Status Statement::Run() {
  absl::StatusOr<bool> row = Next();
  while (row.ok() && *row) row = Next();
  backend_->Reset();
  return row.status();
}

absl::StatusOr<Database> Database::Open(const std::string& name) {
  MLE_ASSIGN_OR_RETURN(
      std::unique_ptr<DatabaseBackend> backend,
      IsDatabase(name) ? OpenPostgresqlState(name) : OpenSqliteState(name));
  return Database(std::move(backend));
}

absl::StatusOr<Statement> Database::Prepare(std::string_view statement) {
  MLE_ASSIGN_OR_RETURN(std::unique_ptr<StatementBackend> backend,
                       backend_->Prepare(statement));
  return Statement(std::move(backend));
}

absl::StatusOr<Transaction> Transaction::Begin(Database& database) {
  MLE_RETURN_IF_ERROR(database.Execute(database.backend().Begin()));
  return Transaction(database);
}

Transaction::Transaction(Transaction&& other) noexcept
    : database_(std::exchange(other.database_, nullptr)) {}

Transaction::~Transaction() {
  if (database_ != nullptr) database_->Execute("ROLLBACK").IgnoreError();
}

absl::Status Transaction::Commit() {
  MLE_RETURN_IF_ERROR(database_->Execute("COMMIT"));
  database_ = nullptr;
  return absl::OkStatus();
}

}  // namespace mle::watch
