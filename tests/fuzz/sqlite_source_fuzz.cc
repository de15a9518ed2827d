// A table of SQLite whose names are anything and whose values are of any type,
// whatever its columns were declared as: what is read is a record, or an error,
// and nothing is changed.

#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <vector>

#include "mle/data/historian.h"
#include "mle/database/record_sources.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/scratch_file.h"
#include "tests/fuzz/tank.h"

namespace mle {
namespace {

constexpr std::int64_t kMaxSamples = 2000;
constexpr std::size_t kMostColumns = 12;

std::string Quoted(std::string_view name) {
  std::string quoted = "\"";
  for (const char c : name) {
    if (c == '"') quoted += '"';
    if (c != '\0') quoted += c;
  }
  return quoted + '"';
}

std::vector<std::string_view> Split(std::string_view text, char mark) {
  std::vector<std::string_view> parts;
  while (parts.size() < kMostColumns) {
    const std::size_t end = text.find(mark);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
  return parts;
}

// "i12": a whole number, "r1.5": a number, "t…": text, "b…": bytes; else null.
void BindValue(sqlite3_stmt* statement, int parameter, std::string_view value) {
  const char kind = value.empty() ? 'n' : value.front();
  const std::string text(value.substr(value.empty() ? 0 : 1));
  if (kind == 'i') {
    sqlite3_bind_int64(statement, parameter,
                       std::strtoll(text.c_str(), nullptr, 10));
  } else if (kind == 'r') {
    sqlite3_bind_double(statement, parameter,
                        std::strtod(text.c_str(), nullptr));
  } else if (kind == 't') {
    sqlite3_bind_text(statement, parameter, text.data(),
                      static_cast<int>(text.size()), SQLITE_TRANSIENT);
  } else if (kind == 'b') {
    sqlite3_bind_blob(statement, parameter, text.data(),
                      static_cast<int>(text.size()), SQLITE_TRANSIENT);
  } else {
    sqlite3_bind_null(statement, parameter);
  }
}

// Lines: the table, its columns with |, rows of values with |. Whether there is
// such a table.
bool MakeTable(fuzz::Bytes& bytes, const std::string& path,
               std::string_view table) {
  sqlite3* database = nullptr;
  sqlite3_open(path.c_str(), &database);
  const std::vector<std::string_view> columns = Split(bytes.Until("\n"), '|');
  std::string create = "CREATE TABLE " + Quoted(table) + "(";
  std::string insert = "INSERT INTO " + Quoted(table) + " VALUES (";
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const char* const types[] = {"", " TEXT", " REAL", " INTEGER", " BLOB"};
    create += (c == 0 ? "" : ", ") + Quoted(columns[c]) +
              types[columns[c].size() % std::size(types)];
    insert += c == 0 ? "?" : ", ?";
  }
  sqlite3_exec(database, "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF",
               nullptr, nullptr, nullptr);
  bool made = sqlite3_exec(database, (create + ")").c_str(), nullptr, nullptr,
                           nullptr) == SQLITE_OK;
  sqlite3_stmt* statement = nullptr;
  if (made) {
    sqlite3_exec(database, "BEGIN", nullptr, nullptr, nullptr);
    sqlite3_prepare_v2(database, (insert + ")").c_str(), -1, &statement,
                       nullptr);
    while (!bytes.empty()) {
      const std::vector<std::string_view> row = Split(bytes.Until("\n"), '|');
      sqlite3_reset(statement);
      sqlite3_clear_bindings(statement);
      for (std::size_t c = 0; c < std::min(row.size(), columns.size()); ++c) {
        BindValue(statement, static_cast<int>(c) + 1, row[c]);
      }
      sqlite3_step(statement);
    }
    sqlite3_finalize(statement);
    sqlite3_exec(database, "COMMIT", nullptr, nullptr, nullptr);
  }
  sqlite3_close(database);
  return made;
}

std::string Content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void Import(const std::string& name, const DatabaseOptions& database,
            const HistorianOptions& options) {
  const auto sources = RecordSources({name}, database, options);
  if (!sources.ok()) {
    FUZZ_EXPECT(!sources.status().message().empty());
    return;
  }
  const auto import = ImportHistorianSources(*sources, fuzz::Tank(), options);
  if (!import.ok()) {
    FUZZ_EXPECT(!import.status().message().empty());
    return;
  }
  std::int64_t samples = 0;
  for (const Record& record : import->records) {
    FUZZ_EXPECT(record.Validate().ok(), record.Validate().ToString());
    FUZZ_EXPECT(!record.outputs.array().isInf().any());
    samples += record.samples();
  }
  FUZZ_EXPECT(samples <= kMaxSamples);
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const int flags = bytes.Next();
  const std::string table(bytes.Until("\n"));
  const mle::fuzz::ScratchFolder folder;
  const std::string path = folder.path() + "/plant.db";
  if (!mle::MakeTable(bytes, path, table)) return 0;
  const std::string before = mle::Content(path);
  mle::HistorianOptions options;
  options.max_samples = mle::kMaxSamples;
  options.columns.ignore_other_columns = (flags & 1) != 0;
  options.any_word_is_bad = (flags & 2) != 0;
  options.skip_repeated_times = (flags & 4) != 0;
  if ((flags & 8) != 0) options.begin = "2026-01-01";
  mle::DatabaseOptions database;
  database.table = (flags & 16) != 0 ? table : mle::Quoted(table);
  mle::Import("sqlite:" + path, database, options);
  mle::Import("sqlite:" + path, {.query = table}, options);
  FUZZ_EXPECT(mle::Content(path) == before);
  return 0;
}
