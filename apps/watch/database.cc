#include "apps/watch/database.h"

#include "mle/base/status.h"
#include "mle/database/record_sources.h"

namespace mle::watch {

std::int64_t Row::Integer(std::size_t column) const {
  const auto* const value = std::get_if<std::int64_t>(&values_.at(column));
  return value == nullptr ? 0 : *value;
}

double Row::Number(std::size_t column) const {
  const auto* const value = std::get_if<double>(&values_.at(column));
  return value == nullptr ? static_cast<double>(Integer(column)) : *value;
}

std::string Row::Text(std::size_t column) const {
  if (const auto* text = std::get_if<std::string>(&values_.at(column))) {
    return *text;
  }
  const auto* const value = std::get_if<Bytes>(&values_[column]);
  return value == nullptr ? std::string() : value->bytes;
}

bool Row::IsNull(std::size_t column) const {
  return std::holds_alternative<std::monostate>(values_.at(column));
}

absl::StatusOr<std::unique_ptr<Database>> Database::Open(
    const std::string& name) {
  return IsDatabase(name) ? OpenPostgresqlState(name) : OpenSqliteState(name);
}

absl::StatusOr<Transaction> Transaction::Begin(Database& database) {
  MLE_RETURN_IF_ERROR(database.Execute(database.Begin()));
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
