#include "mle/database/record_sources.h"

#include <array>
#include <memory>
#include <streambuf>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "mle/base/absl_view.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/data/csv_rows.h"
#include "mle/database/database_name.h"
#include "mle/database/database_session.h"
#include "mle/database/table_query.h"
#include "mle/database/table_text.h"

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

  // Begins at the first row; header and first rows are in `text`.
  absl::Status Start(TableText& text);
  // False at the end, and at a fault.
  bool Read(TableText& text);
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

absl::Status Database::Start(TableText& text) {
  ++reads_;
  rows_ = 0;
  fault_ = absl::OkStatus();
  if (const absl::Status status = Prepare(); !status.ok()) {
    return Place(status, "");
  }
  const absl::StatusOr<std::vector<SqlColumn>> columns =
      session_->Start(query_);
  if (!columns.ok()) return Place(columns.status(), "");
  if (columns->empty()) {
    return Place(absl::InvalidArgumentError("the query returns no columns"),
                 "");
  }
  for (const SqlColumn& column : *columns) text.AddName(column.name);
  text.EndRow();
  const bool has_rows = Read(text);
  MLE_RETURN_IF_ERROR(fault_);
  if (has_rows) return absl::OkStatus();
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

bool Database::Read(TableText& text) {
  const absl::StatusOr<int> rows = session_->Read(kRowsOfBlock, text);
  if (!rows.ok()) {
    fault_ = Place(absl::UnavailableError(rows.status().message()),
                   absl::StrCat("reading failed after row ", rows_, ": "));
    return false;
  }
  rows_ += *rows;
  return *rows > 0;
}

class DatabaseBuffer : public std::streambuf {
 public:
  // `owner` turns bad() at a fault.
  DatabaseBuffer(std::shared_ptr<Database> database, TableText text,
                 std::ios& owner)
      : database_(std::move(database)),
        read_(database_->reads()),
        text_(std::move(text)),
        owner_(owner) {
    Show();
  }

 protected:
  int_type underflow() override {
    if (gptr() < egptr()) return traits_type::to_int_type(*gptr());
    text_.Clear();
    // A later read of the same database has taken its rows from this one.
    const bool is_present = read_ == database_->reads();
    const bool has_rows = is_present && database_->Read(text_);
    if (!is_present || !database_->fault().ok())
      owner_.setstate(std::ios::badbit);
    if (!has_rows) return traits_type::eof();
    Show();
    return traits_type::to_int_type(*gptr());
  }

 private:
  void Show() {
    setg(text_.data(), text_.data(), text_.data() + text_.text().size());
  }

  std::shared_ptr<Database> database_;
  int read_;
  TableText text_;
  std::ios& owner_;
};

class DatabaseStream : public std::istream {
 public:
  DatabaseStream(std::shared_ptr<Database> database, TableText text)
      : std::istream(nullptr),
        buffer_(std::move(database), std::move(text), *this) {
    rdbuf(&buffer_);
  }

 private:
  DatabaseBuffer buffer_;
};

HistorianSource SourceOf(const std::shared_ptr<Database>& database) {
  HistorianSource source;
  source.name = database->Name();
  source.is_table = true;
  source.fault = [database] { return database->fault(); };
  source.open = [database]() -> absl::StatusOr<std::unique_ptr<std::istream>> {
    TableText text;
    MLE_RETURN_IF_ERROR(database->Start(text));
    return std::make_unique<DatabaseStream>(database, std::move(text));
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
