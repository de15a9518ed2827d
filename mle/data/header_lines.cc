#include "mle/data/header_lines.h"

#include <algorithm>
#include <set>
#include <utility>

#include "mle/data/csv_numbers.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

constexpr std::size_t kMostHeaderBytes = 1 << 16;
constexpr int kMostTitles = 50;
constexpr int kMostUnitRows = 3;

// Separators in the line that `head` begins with; −1 where it has a digit at
// the beginning of a field, as samples have and names do not.
int CountSeparators(std::string_view head, char separator) {
  int count = 0;
  bool begins = true;
  for (const char c : head) {
    if (c == '\n') break;
    if (begins && c >= '0' && c <= '9') return -1;
    begins = c == separator;
    if (begins) ++count;
  }
  return count;
}

// Where no line has names that are known: those before the first line of most
// columns whose fields do not begin with digits, so that a message can say what
// the header has.
int LinesAboveColumns(std::string_view head) {
  // A name in quotes may reach over lines.
  if (head.substr(0, head.find('\n')).find('"') != std::string_view::npos) {
    return 0;
  }
  int best = 0;
  int most = 0;
  for (const char separator : {',', ';', '\t'}) {
    std::string_view rest = head;
    for (int line = 0; line < kMostTitles && !rest.empty(); ++line) {
      const int count = CountSeparators(rest, separator);
      if (count > most) {
        most = count;
        best = line;
      }
      rest.remove_prefix(std::min(rest.find('\n'), rest.size() - 1) + 1);
    }
  }
  return best;
}

}  // namespace

int TitleLines(std::string_view head, const std::vector<std::string>& names) {
  std::set<std::string> wanted;
  for (const std::string& name : names) wanted.insert(FoldedName(name));
  const std::string_view whole = head;
  int best = 0;
  int most = 1;
  for (int line = 0; line < kMostTitles && !head.empty(); ++line) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    const std::string_view text = head.substr(0, end);
    for (const char separator : {',', ';', '\t'}) {
      std::set<std::string> found;
      std::size_t begin = 0;
      while (begin <= text.size() && begin < kMostHeaderBytes) {
        const std::size_t next =
            std::min(text.find(separator, begin), text.size());
        std::string name = FoldedName(text.substr(begin, next - begin));
        std::erase_if(name, [](char c) { return c == '"' || c == '\r'; });
        if (wanted.contains(name)) found.insert(std::move(name));
        begin = next + 1;
      }
      if (static_cast<int>(found.size()) <= most) continue;
      most = static_cast<int>(found.size());
      best = line;
    }
    head.remove_prefix(std::min(end + 1, head.size()));
  }
  return most > 1 ? best : LinesAboveColumns(whole);
}

int UnitRows(CsvRows& rows, const std::vector<RecordColumn>& columns,
             const RecordClock& clock) {
  using Kind = RecordColumn::Kind;
  std::vector<std::string_view> fields;
  for (int count = 0; count < kMostUnitRows; ++count) {
    if (!rows.Next(fields) || fields.size() != columns.size()) return count;
    bool has_text = false;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::string_view text = TrimCsvField(fields[c]);
      RecordClock copy = clock;
      double number = 0.0;
      if (ReadCsvNumber(text, number) || ReadCsvNumber(text, number, ',')) {
        return count;
      }
      if (columns[c].kind == Kind::kTime && copy.Read(text, '.', number)) {
        return count;
      }
      const bool is_sample =
          columns[c].kind != Kind::kTime && columns[c].kind != Kind::kOther;
      has_text = has_text || (is_sample && !text.empty());
    }
    // A time of another form, with bad samples, is none.
    const auto time = std::find_if(
        columns.begin(), columns.end(),
        [](const RecordColumn& column) { return column.kind == Kind::kTime; });
    const std::string_view text =
        TrimCsvField(fields[static_cast<std::size_t>(time - columns.begin())]);
    if (!has_text ||
        text.find_first_of("0123456789") != std::string_view::npos) {
      return count;
    }
  }
  return kMostUnitRows;
}

}  // namespace mle
