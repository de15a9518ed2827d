#include "mle/database/record_sources.h"

#include <memory>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "mle/base/absl_view.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/row_source.h"
#include "mle/database/database_name.h"
#include "mle/database/database_session.h"
#include "mle/database/table_query.h"

namespace mle {
namespace {

// A block stays in the cache of the processor, and a slow network delivers it
// within a second or two.
constexpr int kRowsOfBlock = 4096;

// A query without the semicolon that would end it.
std::string Trimmed(const std::string& query) {
  absl::string_view text = query;
  while (!text.empty() &&
         (absl::ascii_isspace(static_cast<unsigned char>(text.back())) ||
          text.back() == ';')) {
    text.remove_suffix(1);
  }
  return std::string(text);
}

// A database, its session once that is open, and what went wrong with it.
class Database {
 public:
  Database(DatabaseName name, DatabaseOptions options, HistorianOptions import)
      : name_(std::move(name)),
        options_(std::move(options)),
        import_(std::move(import)) {}

  std::string Name() const {
    return options_.table.empty()
               ? absl::StrCat(name_.text, ", query")
               : absl::StrCat(name_.text, ", table ", options_.table);
  }
  const absl::Status& fault() const { return fault_; }

  // Begins at the first row: the names of the columns, and the first rows.
  absl::Status Start(std::vector<std::string>& columns, RowBlock& rows);
  // More rows; false at the end, and at a fault.
  bool Read(RowBlock& rows);
  // Which of the reads is the present one.
  int reads() const { return reads_; }

 private:
  absl::Status Place(const absl::Status& status, const std::string& where) {
    return WithPrefix(status, absl::StrCat(Name(), ": ", where));
  }
  absl::Status Prepare();

  DatabaseName name_;
  DatabaseOptions options_;
  HistorianOptions import_;
  std::unique_ptr<DatabaseSession> session_;
  std::string query_;
  std::int64_t rows_ = 0;
  int reads_ = 0;
  absl::Status fault_;
};

absl::Status Database::Prepare() {
  if (session_ != nullptr) return absl::OkStatus();
  MLE_ASSIGN_OR_RETURN(
      std::unique_ptr<DatabaseSession> session,
      DatabaseSession::Connect(
          name_, {.max_value_bytes = import_.limits.max_row_bytes},
          options_.ask_password));
  MLE_ASSIGN_OR_RETURN(query_, WithLimits(Trimmed(options_.query), import_));
  if (!options_.table.empty()) {
    MLE_ASSIGN_OR_RETURN(query_, TableQuery(options_, import_, *session));
  }
  session_ = std::move(session);
  return absl::OkStatus();
}

absl::Status Database::Start(std::vector<std::string>& columns,
                             RowBlock& rows) {
  ++reads_;
  rows_ = 0;
  fault_ = absl::OkStatus();
  if (const absl::Status status = Prepare(); !status.ok()) {
    return Place(status, "");
  }
  const absl::StatusOr<std::vector<SqlColumn>> found = session_->Start(query_);
  if (!found.ok()) return Place(found.status(), "");
  if (found->empty()) {
    return Place(absl::InvalidArgumentError("the query returns no columns"),
                 "");
  }
  RowBlock names;
  for (const SqlColumn& column : *found) AddText(column.name, names);
  std::vector<std::string_view> fields;
  names.Get(0, found->size(), fields);
  columns.assign(fields.begin(), fields.end());
  while (rows_ < kRowsOfBlock && Read(rows)) {
  }
  MLE_RETURN_IF_ERROR(fault_);
  if (rows_ > 0) return absl::OkStatus();
  const std::string nothing = absl::StrCat(
      options_.table.empty() ? "the query returns" : "the table has",
      " no rows");
  if (import_.begin.empty() && import_.end.empty()) {
    return Place(absl::InvalidArgumentError(nothing), "");
  }
  return Place(
      OptionError("begin,end", absl::StrCat(nothing, " between begin and end")),
      "");
}

bool Database::Read(RowBlock& rows) {
  const absl::StatusOr<int> count = session_->Read(kRowsOfBlock, rows);
  if (!count.ok()) {
    fault_ = Place(absl::UnavailableError(count.status().message()),
                   absl::StrCat("reading failed after row ", rows_, ": "));
    return false;
  }
  rows_ += *count;
  return *count > 0;
}

// Rows of one read of a database; a later one takes them from it.
class DatabaseRows : public RowSource {
 public:
  // `database` may be null: there are no more rows then.
  DatabaseRows(std::shared_ptr<Database> database, std::string name,
               std::vector<std::string> columns, RowBlock block)
      : RowSource(std::move(name), true),
        database_(std::move(database)),
        read_(database_ == nullptr ? 0 : database_->reads()),
        columns_(std::move(columns)),
        block_(std::move(block)) {}

  bool Next(std::vector<std::string_view>& fields) override;
  std::unique_ptr<RowSource> Preview() override {
    return std::make_unique<DatabaseRows>(nullptr, source(), columns_, block_);
  }

 private:
  bool Fill();

  std::shared_ptr<Database> database_;
  int read_;
  std::vector<std::string> columns_;
  RowBlock block_;
  std::size_t at_ = 0;  // the next field in it
};

bool DatabaseRows::Fill() {
  if (database_ == nullptr || !status_.ok()) return false;
  if (read_ != database_->reads()) {
    status_ = absl::DataLossError(
        absl::StrCat(source(), ": cannot be read after ", LineName(row_line_),
                     ", as it was opened again"));
    return false;
  }
  block_.Clear();
  at_ = 0;
  const bool has_rows = database_->Read(block_);
  status_ = database_->fault();
  return has_rows;
}

bool DatabaseRows::Next(std::vector<std::string_view>& fields) {
  if (row_line_ == 0) {
    fields.assign(columns_.begin(), columns_.end());
  } else {
    if (at_ == block_.num_fields() && !Fill()) return false;
    block_.Get(at_, columns_.size(), fields);
    at_ += columns_.size();
  }
  ++row_line_;
  return true;
}

HistorianSource SourceOf(const std::shared_ptr<Database>& database) {
  HistorianSource source;
  source.name = database->Name();
  source.is_table = true;
  source.open_rows =
      [database]() -> absl::StatusOr<std::unique_ptr<RowSource>> {
    std::vector<std::string> columns;
    RowBlock rows;
    MLE_RETURN_IF_ERROR(database->Start(columns, rows));
    return std::make_unique<DatabaseRows>(database, database->Name(),
                                          std::move(columns), std::move(rows));
  };
  return source;
}

// "mysql" of mysql://…; empty for text that does not begin so.
std::string_view SchemeOf(std::string_view text) {
  const std::size_t end = text.find("://");
  if (end == std::string_view::npos || end == 0) return {};
  for (const char c : text.substr(0, end)) {
    const auto byte = static_cast<unsigned char>(c);
    if (!absl::ascii_isalnum(byte) && c != '+' && c != '-' && c != '.') {
      return {};
    }
  }
  return text.substr(0, end);
}

}  // namespace

absl::Status DatabaseOptions::Validate() const {
  if (query.empty() == table.empty()) {
    return OptionError(
        "query,table",
        absl::StrCat("of a database either table or query must be given",
                     query.empty() ? "" : ", not both"));
  }
  if (query.find('\0') != std::string::npos) {
    return OptionError("query", "query has a NUL byte in it");
  }
  if (!query.empty() && !columns.empty()) {
    return OptionError("columns",
                       "columns are those of a table; a query names its own");
  }
  return absl::OkStatus();
}

bool IsDatabase(std::string_view name) {
  return absl::StartsWithIgnoreCase(AbslView(name), "sqlite:") ||
         absl::StartsWithIgnoreCase(AbslView(name), "odbc:") ||
         absl::StartsWithIgnoreCase(AbslView(name), "jdbc:") ||
         !SchemeOf(name).empty();
}

absl::StatusOr<std::vector<HistorianSource>> RecordSources(
    const std::vector<std::string>& names, const DatabaseOptions& database,
    const HistorianOptions& import) {
  std::vector<HistorianSource> sources;
  bool has_database = false;
  for (const std::string& name : names) {
    if (!IsDatabase(name)) {
      sources.push_back(FileSource(name));
      continue;
    }
    has_database = true;
    MLE_ASSIGN_OR_RETURN(DatabaseName parsed, ParseDatabaseName(name));
    MLE_RETURN_IF_ERROR(database.Validate());
    sources.push_back(SourceOf(
        std::make_shared<Database>(std::move(parsed), database, import)));
  }
  const bool has_options = !database.query.empty() || !database.table.empty() ||
                           !database.columns.empty();
  if (has_options && !has_database) {
    return OptionError("query,table,columns",
                       "query, table and columns are for databases, and none "
                       "is named; those are postgresql://USER@HOST/NAME, "
                       "sqlite:FILE and odbc:NAME");
  }
  return sources;
}

}  // namespace mle
