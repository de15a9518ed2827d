#include "mle/data/time_columns.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "mle/base/absl_view.h"
#include "mle/data/csv_numbers.h"
#include "mle/data/nearest_names.h"
#include "mle/data/quality_columns.h"

namespace mle {
namespace {

bool IsFigure(char c) {
  return absl::ascii_isdigit(static_cast<unsigned char>(c));
}

bool AllDigits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), IsFigure);
}

bool IsAmong(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

// Without the midnight that spreadsheets write behind a date.
std::string_view WithoutMidnight(std::string_view text) {
  for (const std::string_view midnight :
       {"T00:00:00", " 00:00:00", " 00:00", " 0:00:00", " 0:00"}) {
    if (text.ends_with(midnight)) {
      return TrimCsvField(text.substr(0, text.size() - midnight.size()));
    }
  }
  return text;
}

// 8:15, 08:15:01.5, 08:15 AM
bool IsTimeOfDay(std::string_view text) {
  const std::size_t colon = text.find(':');
  return (colon == 1 || colon == 2) && AllDigits(text.substr(0, colon)) &&
         text.size() > colon + 2 && IsFigure(text[colon + 1]) &&
         IsFigure(text[colon + 2]);
}

// By any form, whether it is certain or not, or as declared.
bool Reads(std::string_view text, const RecordClock& clock) {
  if (clock.format() == TimeFormat::kPattern) {
    RecordClock copy = clock;
    double time = 0.0;
    return copy.Read(text, '.', time);
  }
  return std::any_of(TimeForms().begin(), TimeForms().end(),
                     [&](const TimeForm& form) {
                       return ReadCivilTime(text, form).has_value();
                     });
}

bool IsMilliseconds(const std::string& name) {
  const std::string folded = FoldedName(name);
  return folded.starts_with("milli") || folded == "ms" || folded == "msec";
}

// The first rows of samples: rows of units have no digit.
std::vector<const std::vector<std::string>*> SampleRows(
    const std::vector<std::vector<std::string>>& rows, std::size_t columns) {
  constexpr std::size_t kRows = 5;
  std::vector<const std::vector<std::string>*> samples;
  for (const std::vector<std::string>& row : rows) {
    const bool has_digit =
        std::any_of(row.begin(), row.end(), [](const std::string& field) {
          return std::any_of(field.begin(), field.end(), IsFigure);
        });
    if (has_digit && row.size() == columns) samples.push_back(&row);
    if (samples.size() == kRows) break;
  }
  return samples;
}

}  // namespace

const std::vector<std::string>& UsualTimeColumns() {
  static const auto& names = *new std::vector<std::string>{
      "time",         "timestamp",    "datetime",      "date",
      "ts",           "date/time",    "ip_trend_time", "_time",
      "last_changed", "last_updated", "t_stamp",       "sampletime",
      "timestamputc", "utctime",      "localtime",     "date_time",
      "zeitstempel",  "logtime",      "eventtime"};
  return names;
}

std::string JoinTimeFields(std::string_view first, std::string_view second) {
  first = TrimCsvField(first);
  second = TrimCsvField(second);
  if (second.find(':') != std::string_view::npos)
    first = WithoutMidnight(first);
  const std::size_t colon = first.find(':');
  const bool has_clock = colon != std::string_view::npos || AllDigits(first);
  if (!has_clock || !AllDigits(second) || second.size() > 3) {
    return absl::StrCat(AbslView(first), " ", AbslView(second));
  }
  const std::string fraction =
      absl::StrCat(".", std::string(3 - second.size(), '0'), AbslView(second));
  if (colon == std::string_view::npos) {
    return absl::StrCat(AbslView(first), fraction);
  }
  const std::size_t minutes = std::min(colon + 3, first.size());
  const bool has_seconds = minutes < first.size() && first[minutes] == ':';
  const std::size_t end =
      std::min(has_seconds ? minutes + 3 : minutes, first.size());
  return absl::StrCat(AbslView(first.substr(0, end)), has_seconds ? "" : ":00",
                      fraction, AbslView(first.substr(end)));
}

std::optional<std::pair<std::string, std::string>> SplitTimeName(
    const std::string& name, const std::vector<std::string>& header) {
  const auto has = [&](const std::string& part) {
    return std::any_of(header.begin(), header.end(),
                       [&](const std::string& column) {
                         return FoldedName(column) == FoldedName(part);
                       });
  };
  std::optional<std::pair<std::string, std::string>> parts;
  if (has(name)) return parts;
  for (std::size_t at = name.find('+'); at != std::string::npos;
       at = name.find('+', at + 1)) {
    std::pair<std::string, std::string> division = {
        std::string(TrimCsvField(name.substr(0, at))),
        std::string(TrimCsvField(name.substr(at + 1)))};
    if (division.first.empty() || division.second.empty()) continue;
    const bool is_there = has(division.first) && has(division.second);
    if (is_there || !parts) parts = std::move(division);
    if (is_there) break;
  }
  return parts;
}

std::optional<std::string> RecogniseTimeColumn(
    const std::vector<std::string>& header,
    const std::vector<std::vector<std::string>>& rows,
    const RecordClock& clock) {
  const auto samples = SampleRows(rows, header.size());
  if (samples.empty()) return std::nullopt;
  std::vector<std::string> dates;
  std::vector<std::string> clocks;
  std::vector<std::string> moments;
  std::vector<std::string> milliseconds;
  std::vector<std::string> usual;
  const auto all = [&](std::size_t c, const auto& is) {
    return std::all_of(samples.begin(), samples.end(), [&](const auto* row) {
      return is(TrimCsvField((*row)[c]));
    });
  };
  for (std::size_t c = 0; c < header.size(); ++c) {
    const std::string& name = header[c];
    if (IsAmong(UsualTimeColumns(), FoldedName(name))) usual.push_back(name);
    if (all(c, IsTimeOfDay)) {
      clocks.push_back(name);
    } else if (all(c, [&](std::string_view text) {
                 double number = 0.0;
                 return !ReadCsvNumber(WithoutMidnight(text), number) &&
                        WithoutMidnight(text).find(':') ==
                            std::string_view::npos &&
                        Reads(JoinTimeFields(text, "00:00:00"), clock);
               })) {
      dates.push_back(name);
    } else if (all(c, [&](std::string_view text) {
                 return text.find(':') != std::string_view::npos &&
                        Reads(text, clock);
               })) {
      moments.push_back(name);
    } else if (IsMilliseconds(name) && all(c, [](std::string_view text) {
                 return AllDigits(text) && text.size() <= 3;
               })) {
      milliseconds.push_back(name);
    }
  }
  if (dates.size() == 1 && clocks.size() == 1 && moments.empty()) {
    return absl::StrCat(dates[0], "+", clocks[0]);
  }
  const std::vector<std::string>& times = moments.empty() ? usual : moments;
  if (times.size() == 1 && milliseconds.size() == 1) {
    return absl::StrCat(times[0], "+", milliseconds[0]);
  }
  // Dates at midnight are times of days.
  if (moments.empty()) moments = dates;
  if (usual.empty() && moments.size() == 1) return moments[0];
  return std::nullopt;
}

bool IsSampleField(std::string_view field, const RecordClock& clock) {
  const std::string_view text = TrimCsvField(field);
  double number = 0.0;
  if (ReadCsvNumber(text, number) || ReadCsvNumber(text, number, ',')) {
    return true;
  }
  if (text.find_first_of("0123456789") != std::string_view::npos) {
    return Reads(text, clock) || Reads(JoinTimeFields(text, "00:00"), clock) ||
           IsTimeOfDay(text);
  }
  const std::string folded = absl::AsciiStrToLower(AbslView(text));
  return IsAmong(KnownBadWords(), folded);
}

}  // namespace mle
