#include <algorithm>
#include <set>
#include <utility>

#include "mle/data/csv_format.h"
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
  bool best_is_comment = false;
  for (const char separator : {',', ';', '\t'}) {
    std::string_view rest = head;
    for (int line = 0; line < kMostTitles && !rest.empty(); ++line) {
      const int count = CountSeparators(rest, separator);
      const bool is_comment = rest.starts_with('#');
      if (count > most || (count == most && best_is_comment && !is_comment)) {
        most = count;
        best = line;
        best_is_comment = is_comment;
      }
      rest.remove_prefix(std::min(rest.find('\n'), rest.size() - 1) + 1);
    }
  }
  return best;
}

std::set<std::string> FoldedSet(const std::vector<std::string>& names) {
  std::set<std::string> folded;
  for (const std::string& name : names) folded.insert(FoldedName(name));
  return folded;
}

// Different fields of a line that are among `wanted`.
int CountNames(std::string_view text, char separator,
               const std::set<std::string>& wanted) {
  std::set<std::string> found;
  std::size_t begin = 0;
  while (begin <= text.size() && begin < kMostHeaderBytes) {
    const std::size_t next = std::min(text.find(separator, begin), text.size());
    const std::string_view field = text.substr(begin, next - begin);
    std::string name = FoldedName(begin == 0 ? WithoutHash(field) : field);
    std::erase_if(name, [](char c) { return c == '"' || c == '\r'; });
    if (wanted.contains(name)) found.insert(std::move(name));
    begin = next + 1;
  }
  return static_cast<int>(found.size());
}

int CountFields(std::string_view line, char separator) {
  return 1 + static_cast<int>(std::count(line.begin(), line.end(), separator));
}

bool HasDigit(std::string_view line) {
  return line.find_first_of("0123456789") != std::string_view::npos;
}

// The first lines of a text.
std::vector<std::string_view> FirstLines(std::string_view head, int most) {
  std::vector<std::string_view> lines;
  while (!head.empty() && static_cast<int>(lines.size()) < most) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    lines.push_back(head.substr(0, end));
    head.remove_prefix(std::min(end + 1, head.size()));
  }
  return lines;
}

}  // namespace

bool LooksLikeTable(std::string_view head,
                    const std::vector<std::string>& names) {
  const std::set<std::string> wanted = FoldedSet(names);
  // In quotes there may be anything, and a line that is too long has an error
  // of its own.
  if (head.find('"') != std::string_view::npos ||
      (head.size() >= kMostHeaderBytes / 2 &&
       head.find('\n') == std::string_view::npos)) {
    return true;
  }
  const std::vector<std::string_view> lines = FirstLines(head, kMostTitles);
  for (const char separator : {',', ';', '\t'}) {
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const int fields = CountFields(lines[k], separator);
      if (fields < 2) continue;
      if (CountNames(lines[k], separator, wanted) > 0) return true;
      // A header alone, or one above rows, of which the first may be of units.
      if (lines.size() == 1) return true;
      for (std::size_t r = k + 1; r <= k + 1 + kMostUnitRows; ++r) {
        if (r >= lines.size() || CountFields(lines[r], separator) != fields) {
          break;
        }
        if (HasDigit(lines[r])) return true;
      }
    }
  }
  return false;
}

int TitleLines(std::string_view head, const std::vector<std::string>& names) {
  const std::set<std::string> wanted = FoldedSet(names);
  const std::vector<std::string_view> lines = FirstLines(head, kMostTitles);
  int best = 0;
  int most = 1;
  for (std::size_t line = 0; line < lines.size(); ++line) {
    for (const char separator : {',', ';', '\t'}) {
      const int found = CountNames(lines[line], separator, wanted);
      if (found <= most) continue;
      most = found;
      best = static_cast<int>(line);
    }
  }
  return most > 1 ? best : LinesAboveColumns(head);
}

int UnitRows(RowSource& rows, const std::vector<RecordColumn>& columns,
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
