#include "mle/data/quality_columns.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "absl/strings/str_split.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/import_options.h"
#include "mle/data/nearest_names.h"

namespace mle {
namespace {

struct Word {
  std::string_view text;
  QualityKind kind = QualityKind::kCode;
  bool is_short = false;  // only behind a separator
};

constexpr std::array<Word, 21> kWords = {
    {{"quality"},
     {"opcquality"},
     {"tagquality"},
     {"qualitycode"},
     {"qualitydetail"},
     {"qualitystatus"},
     {"dataquality"},
     {"status"},
     {"opcstatus"},
     {"statuscode"},
     {"qual", QualityKind::kCode, true},
     {"q", QualityKind::kCode, true},
     {"confidence", QualityKind::kConfidence},
     {"isgood", QualityKind::kFlag},
     {"isvalid", QualityKind::kFlag},
     {"good", QualityKind::kFlag, true},
     {"valid", QualityKind::kFlag, true},
     {"questionable", QualityKind::kFault},
     {"substituted", QualityKind::kFault},
     {"isbad", QualityKind::kFault},
     {"bad", QualityKind::kFault, true}}};

bool IsSeparator(char c) {
  return std::string_view(" _.:-/|()[]").find(c) != std::string_view::npos;
}

// The word that `rest` is, a name without that of a column.
const Word* FindWord(std::string_view rest) {
  bool has_separator = false;
  std::string letters;
  for (const char c : rest) {
    has_separator = has_separator || IsSeparator(c);
    if (!IsSeparator(c)) letters += c;
  }
  letters = FoldedName(letters);
  for (const Word& word : kWords) {
    if (letters == word.text && (has_separator || !word.is_short)) {
      return &word;
    }
  }
  return nullptr;
}

// The whole of a name may be a short word.
const Word* FindWholeWord(std::string_view name) {
  const std::string with_separator = "_" + std::string(name);
  return FoldedName(name) == "q" ? nullptr : FindWord(with_separator);
}

bool IsOneOf(const std::string& text, const std::vector<std::string>& list) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

constexpr char kBadWords[] =
    "bad, bad input, bad data, bad quality, i/o timeout, io timeout, "
    "timeout, time out, no data, no value, no result, no sample, no "
    "status, not connected, not connect, inst fail, comm fail, comm "
    "failure, pt created, point created, shutdown, intf shut, scan off, "
    "scan timeout, out of serv, out of service, configure, calc failed, "
    "calc fail, calc timeout, calc off, calc crash, not converge, set "
    "to bad, arc off-line, arc offline, over range, under range, over "
    "rngcheck, under rngcheck, inp outrange, unit down, equip fail, dcs "
    "failed, no lab data, trace off, wave off, nonumeric, filter error, "
    "invalid data, invalid float, doubtful, initial, suspect, "
    "inaccessible, unusable, failed, fail, badpv, badval, unknown, "
    "uncertain, not available, unavailable, inactive, disabled, "
    "off-scan, offscan, off scan, comm error, no comm, error, null, "
    "none, nil, na, n/a, #n/a, #value!, #div/0!, #ref!, #num!, #name?, "
    "-, --, ---, ----, -----, ?, ?\?, ?\??, ?\??\?, *, **, ***, ****, "
    "*****, missing, invalid";

}  // namespace

const std::vector<std::string>& KnownBadWords() {
  static const auto& words =
      *new std::vector<std::string>(absl::StrSplit(kBadWords, ", "));
  return words;
}

const std::vector<std::string>& UsualGoodQualities() {
  static const auto& values =
      *new std::vector<std::string>{"good", "ok", "192"};
  return values;
}

std::optional<QualityName> QualityOfName(
    std::string_view name, const std::vector<std::string_view>& columns) {
  std::optional<QualityName> found;
  for (const std::string_view column : columns) {
    if (column.empty() || column.size() >= name.size() ||
        (found && found->column.size() >= column.size())) {
      continue;
    }
    const std::string_view rest =
        name.starts_with(column) ? name.substr(column.size())
        : name.ends_with(column) ? name.substr(0, name.size() - column.size())
                                 : std::string_view();
    if (const Word* const word = FindWord(rest)) {
      found = QualityName{column, word->kind};
    }
  }
  if (found) return found;
  const Word* const word = FindWholeWord(name);
  if (word == nullptr) return std::nullopt;
  return QualityName{{}, word->kind};
}

bool AreUsualQualities(const std::vector<std::string>& good) {
  return good == UsualGoodQualities();
}

std::string UsualQualityName(QualityKind kind) {
  switch (kind) {
    case QualityKind::kFlag:
      return "isgood";
    case QualityKind::kFault:
      return "questionable";
    case QualityKind::kConfidence:
      return "confidence";
    case QualityKind::kCode:
      break;
  }
  return "quality";
}

bool IsUsuallyGood(std::string_view quality, QualityKind kind) {
  const std::string text = FoldedName(quality);
  double number = 0.0;
  const bool is_number = ReadCsvNumber(text, number);
  switch (kind) {
    case QualityKind::kFault:
      return text.empty() || (is_number && number == 0.0) ||
             IsOneOf(text, {"false", "no", "n", "f", "-"}) ||
             text.starts_with("good");
    case QualityKind::kFlag:
      return (is_number && number == 1.0) || text.starts_with("good") ||
             IsOneOf(text, {"true", "yes", "y", "t", "valid", "ok"});
    case QualityKind::kConfidence:
      if (is_number) return number == 100.0;
      break;
    case QualityKind::kCode:
      break;
  }
  if (is_number) {
    return number >= 192.0 && number <= 65535.0 &&
           number == std::floor(number) &&
           (static_cast<int>(number) & 0xC0) == 0xC0;
  }
  return text.starts_with("good") ||
         IsOneOf(text, {"ok", "valid", "normal", "0x00c0", "0xc0", "c0"});
}

}  // namespace mle
