#include "mle/data/csv_format.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <sstream>

#include "absl/strings/str_cat.h"
#include "mle/base/option_error.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/csv_rows.h"

namespace mle {
namespace {

constexpr std::string_view kSeparators = ",;\t";

const char* SeparatorName(char separator) {
  return separator == ',' ? "comma" : separator == ';' ? "semicolon" : "tab";
}

// Fields of the first row that are among `names`.
int CountHeadNames(std::string_view text, char separator,
                   const std::vector<std::string>& names) {
  std::istringstream in{std::string(text)};
  CsvRows rows(in, "");
  rows.set_separator(separator);
  std::vector<std::string_view> fields;
  if (!rows.Next(fields)) return 0;
  return static_cast<int>(
      std::count_if(fields.begin(), fields.end(), [&](std::string_view field) {
        const std::string_view name = TrimCsvField(field);
        return std::find(names.begin(), names.end(), name) != names.end();
      }));
}

// Separators outside quotes in the first line.
std::string SeparatorsInHeader(std::string_view text) {
  std::string found;
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == '\n' || c == '\r') break;
    if (kSeparators.find(c) != std::string_view::npos &&
        found.find(c) == std::string::npos) {
      found += c;
    }
  }
  return found;
}

bool LooksNumeric(std::string_view text) {
  return !text.empty() &&
         text.find_first_not_of("+-0123456789.,eE") == std::string_view::npos;
}

// A comma before three digits, with one to three before it that do not begin
// with a zero: "1,234" may be one thousand or one.
bool MayBeThousands(std::string_view text) {
  if (!text.empty() && (text[0] == '+' || text[0] == '-')) {
    text.remove_prefix(1);
  }
  const std::size_t comma = text.find(',');
  if (comma < 1 || comma > 3 || text[0] == '0') return false;
  return text.size() == comma + 4 &&
         text.substr(comma + 1).find_first_not_of("0123456789") ==
             std::string_view::npos;
}

// Where a kind of field was first seen.
struct Sighting {
  int line = 0;
  int column = 0;
  std::string text;
};

// The first field seen of each form that tells the decimal mark.
struct Evidence {
  std::optional<Sighting> point;      // 1.5
  std::optional<Sighting> comma;      // 1,5
  std::optional<Sighting> thousands;  // 1,234
  std::optional<Sighting> grouped;    // 1,234.5 or 1,234,567
};

void Take(std::string_view text, int line, int column, Evidence& evidence) {
  const auto commas = std::count(text.begin(), text.end(), ',');
  const bool has_point = text.find('.') != std::string_view::npos;
  if (commas == 0 && !has_point) return;
  std::optional<Sighting>& kind = commas > 1 || (commas == 1 && has_point)
                                      ? evidence.grouped
                                  : has_point            ? evidence.point
                                  : MayBeThousands(text) ? evidence.thousands
                                                         : evidence.comma;
  if (!kind) kind = Sighting{line, column, std::string(text)};
}

absl::Status Fault(const RowSource& rows, const Sighting& at,
                   const std::string& what) {
  return OptionError("decimal",
                     absl::StrCat(rows.PlaceIn(at.line, at.column), ": '",
                                  ShowCsvText(at.text), "' ", what));
}

}  // namespace

absl::StatusOr<char> RecogniseSeparator(std::string_view text,
                                        const std::string& source, int line,
                                        const std::vector<std::string>& names) {
  const std::string found = SeparatorsInHeader(text);
  if (found.size() <= 1) return found.empty() ? ',' : found[0];
  char best = found[0];
  int most = -1;
  bool is_tie = false;
  for (const char separator : found) {
    const int count = CountHeadNames(text, separator, names);
    is_tie = count == most || (is_tie && count < most);
    if (count > most) {
      most = count;
      best = separator;
    }
  }
  if (!is_tie) return best;
  return OptionError(
      "separator",
      absl::StrCat(source, ": line ", line, ", column 1: the header has a ",
                   SeparatorName(found[0]), " and a ", SeparatorName(found[1]),
                   ", and either may stand between its columns; declare "
                   "separator = ",
                   SeparatorName(found[0]),
                   " or separator = ", SeparatorName(found[1])));
}

absl::StatusOr<char> RecogniseDecimal(
    RowSource& rows, const std::vector<RecordColumn>& columns) {
  std::vector<std::string_view> fields;
  rows.Next(fields);  // the header
  Evidence evidence;
  // A date alone may have points.
  const bool has_part = std::any_of(
      columns.begin(), columns.end(), [](const RecordColumn& column) {
        return column.kind == RecordColumn::Kind::kTimePart;
      });
  while (rows.Next(fields)) {
    for (std::size_t c = 0; c < std::min(fields.size(), columns.size()); ++c) {
      const RecordColumn::Kind kind = columns[c].kind;
      if (kind == RecordColumn::Kind::kOther ||
          (has_part && (kind == RecordColumn::Kind::kTime ||
                        kind == RecordColumn::Kind::kTimePart))) {
        continue;
      }
      const std::string_view text = TrimCsvField(fields[c]);
      if (LooksNumeric(text)) {
        Take(text, rows.line(), static_cast<int>(c) + 1, evidence);
      }
    }
  }

  if (evidence.grouped) {
    return Fault(rows, *evidence.grouped,
                 "has marks between its thousands, or two marks for decimals; "
                 "export numbers without thousands separators");
  }
  const auto& comma = evidence.comma ? evidence.comma : evidence.thousands;
  if (comma && evidence.point) {
    return Fault(
        rows, *comma,
        absl::StrCat("has a comma, but '", evidence.point->text, "' in ",
                     rows.LineName(evidence.point->line),
                     " a point; declare which it is, such as decimal = comma"));
  }
  if (comma && !evidence.comma) {
    return Fault(rows, *comma,
                 "may have a decimal comma or one between thousands; declare "
                 "decimal = comma or decimal = point");
  }
  return comma ? ',' : '.';
}

}  // namespace mle
