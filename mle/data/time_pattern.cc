#include <array>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "mle/base/status.h"
#include "mle/data/time_format.h"

namespace mle {
namespace {

constexpr int kMaxDepth = 8;

// Three letters each, and what German has otherwise.
constexpr std::array<std::array<std::string_view, 2>, 12> kMonths = {
    {{"january", "januar"},
     {"february", "februar"},
     {"march", "mrz"},
     {"april", "april"},
     {"may", "mai"},
     {"june", "juni"},
     {"july", "juli"},
     {"august", "august"},
     {"september", "september"},
     {"october", "oktober"},
     {"november", "november"},
     {"december", "dezember"}}};

char Lower(char c) {
  return static_cast<char>(absl::ascii_tolower(static_cast<unsigned char>(c)));
}

bool IsDigit(char c) {
  return absl::ascii_isdigit(static_cast<unsigned char>(c));
}

bool TakeOneOf(std::string_view& text, std::string_view characters) {
  if (text.empty() || characters.find(text[0]) == std::string_view::npos) {
    return false;
  }
  text.remove_prefix(1);
  return true;
}

// Takes `digits` digits from the front of `text`.
bool TakeNumber(std::string_view& text, int digits, int& number) {
  if (text.size() < static_cast<std::size_t>(digits)) return false;
  number = 0;
  for (const char c : text.substr(0, digits)) {
    if (!IsDigit(c)) return false;
    number = 10 * number + (c - '0');
  }
  text.remove_prefix(digits);
  return true;
}

// One or two digits.
bool TakeShortNumber(std::string_view& text, int& number) {
  return TakeNumber(text, 2, number) || TakeNumber(text, 1, number);
}

// ss[.fraction]
bool TakeSeconds(std::string_view& text, double& seconds) {
  int whole = 0;
  if (!TakeNumber(text, 2, whole)) return false;
  seconds = whole;
  if (!TakeOneOf(text, ".,")) return true;
  double digits = 0.0;
  double scale = 1.0;
  while (!text.empty() && IsDigit(text[0])) {
    if (scale < 1e15) {
      digits = 10.0 * digits + (text[0] - '0');
      scale *= 10.0;
    }
    text.remove_prefix(1);
  }
  seconds += digits / scale;
  return true;
}

// Z, UTC or ±hh[[:]mm], as seconds east of UTC.
bool TakeZone(std::string_view& text, std::optional<int>& seconds) {
  if (TakeOneOf(text, "Zz")) {
    seconds = 0;
    return true;
  }
  if (text.starts_with("UTC")) {
    text.remove_prefix(3);
    seconds = 0;
    return true;
  }
  const int sign = text.starts_with('-') ? -1 : 1;
  int hours = 0;
  int minutes = 0;
  if (!TakeOneOf(text, "+-") || !TakeNumber(text, 2, hours)) return false;
  const bool has_colon = TakeOneOf(text, ":");
  if (!TakeNumber(text, 2, minutes) && has_colon) return false;
  seconds = sign * (3600 * hours + 60 * minutes);
  return hours < 24 && minutes < 60;
}

// Three letters of a name at least, and more of it.
bool TakeMonthName(std::string_view& text, int& month) {
  std::size_t length = 0;
  std::array<char, 12> name;
  while (length < text.size() && length < name.size() &&
         absl::ascii_isalpha(static_cast<unsigned char>(text[length]))) {
    name[length] = Lower(text[length]);
    ++length;
  }
  if (length < 3) return false;
  const std::string_view found(name.data(), length);
  for (std::size_t m = 0; m < kMonths.size(); ++m) {
    for (const std::string_view whole : kMonths[m]) {
      if (!whole.starts_with(found)) continue;
      month = static_cast<int>(m) + 1;
      text.remove_prefix(length);
      return true;
    }
  }
  return false;
}

// AM, PM, a.m., p.m.; 1 for the second half of the day.
bool TakeHalfDay(std::string_view& text, std::optional<int>& half) {
  if (text.empty()) return false;
  const char first = Lower(text[0]);
  if (first != 'a' && first != 'p') return false;
  std::string_view rest = text.substr(1);
  const bool has_point = TakeOneOf(rest, ".");
  if (!TakeOneOf(rest, "mM")) return false;
  if (has_point && !TakeOneOf(rest, ".")) return false;
  half = first == 'p' ? 1 : 0;
  text = rest;
  return true;
}

}  // namespace

struct TimePattern::Reading {
  std::string_view text;  // not read yet
  CivilTime time;
  std::optional<int> half_day;
};

bool TimePattern::Take(const Step& step, Reading& reading) {
  std::string_view& text = reading.text;
  CivilTime& time = reading.time;
  switch (step.field) {
    case Field::kLetter:
      if (text.empty() ||
          (text[0] != step.letter && Lower(text[0]) != step.letter)) {
        return false;
      }
      text.remove_prefix(1);
      return true;
    case Field::kBlank:
      if (!TakeOneOf(text, " \t")) return false;
      while (TakeOneOf(text, " \t")) {
      }
      return true;
    case Field::kYear:
      return TakeNumber(text, 4, time.year);
    case Field::kShortYear:
      if (!TakeNumber(text, 2, time.year)) return false;
      time.year += time.year < 69 ? 2000 : 1900;
      return true;
    case Field::kMonth:
      return TakeShortNumber(text, time.month);
    case Field::kMonthName:
      return TakeMonthName(text, time.month);
    case Field::kDay:
      return TakeShortNumber(text, time.day);
    case Field::kHour:
      return TakeShortNumber(text, time.hour);
    case Field::kMinute:
      return TakeNumber(text, 2, time.minute);
    case Field::kSecond:
      return TakeSeconds(text, time.second);
    case Field::kHalfDay:
      return TakeHalfDay(text, reading.half_day);
    case Field::kZone:
      return TakeZone(text, time.zone);
    case Field::kOptional:
      return true;
  }
  return false;
}

bool TimePattern::Match(std::size_t begin, std::size_t end,
                        Reading& reading) const {
  for (std::size_t at = begin; at < end; ++at) {
    const Step& step = steps_[at];
    if (step.field != Field::kOptional) {
      if (!Take(step, reading)) return false;
      continue;
    }
    const std::size_t after = at + 1 + step.size;
    if (reading.text.empty()) {
      at = after - 1;
      continue;
    }
    const Reading before = reading;
    if (!Match(at + 1, after, reading)) reading = before;
    at = after - 1;
  }
  return true;
}

std::optional<CivilTime> TimePattern::Read(std::string_view text) const {
  Reading reading = {text, {}, {}};
  if (!Match(0, steps_.size(), reading) || !reading.text.empty()) {
    return std::nullopt;
  }
  CivilTime& time = reading.time;
  if (reading.half_day) {
    if (time.hour < 1 || time.hour > 12) return std::nullopt;
    time.hour = time.hour % 12 + 12 * *reading.half_day;
  }
  if (!reading.half_day) time = WithoutHour24(time);
  if (!Exists(time)) return std::nullopt;
  return time;
}

absl::Status TimePattern::Compile(std::string_view pattern, std::size_t& at,
                                  int depth) {
  const auto fault = [&](std::string_view what) {
    return InvalidArgument("the form of time '", std::string(text_), "' ",
                           std::string(what));
  };
  const auto add = [&](Field field, char letter = 0) {
    steps_.push_back({field, letter, 0});
  };
  if (depth > kMaxDepth) return fault("has too many brackets in each other");
  while (at < pattern.size()) {
    const char c = pattern[at];
    const char next = at + 1 < pattern.size() ? pattern[at + 1] : '\0';
    at += c == '%' ? 2 : 1;
    if (c == ']') {
      if (depth == 0) return fault("closes a bracket that is not open");
      return absl::OkStatus();
    } else if (c == '[') {
      const std::size_t optional = steps_.size();
      add(Field::kOptional);
      MLE_RETURN_IF_ERROR(Compile(pattern, at, depth + 1));
      steps_[optional].size = static_cast<int>(steps_.size() - optional) - 1;
    } else if (c == ' ') {
      if (steps_.empty() || steps_.back().field != Field::kBlank) {
        add(Field::kBlank);
      }
    } else if (c != '%') {
      add(Field::kLetter, Lower(c));
    } else {
      constexpr std::string_view kNames = "YymbBdHIMSpz%[]";
      constexpr std::array<Field, 15> kFields = {
          Field::kYear,      Field::kShortYear, Field::kMonth,
          Field::kMonthName, Field::kMonthName, Field::kDay,
          Field::kHour,      Field::kHour,      Field::kMinute,
          Field::kSecond,    Field::kHalfDay,   Field::kZone,
          Field::kLetter,    Field::kLetter,    Field::kLetter};
      const std::size_t name = kNames.find(next);
      if (next == '\0' || name == std::string_view::npos) {
        return fault(absl::StrCat(
            "has '%", std::string(next == '\0' ? 0 : 1, next),
            "'; choose from %Y %y %m %b %d %H %I %M %S %p %z, and [ ] around "
            "what may be missing"));
      }
      add(kFields[name], next);
    }
  }
  return depth == 0 ? absl::OkStatus()
                    : fault("has a bracket that is not closed");
}

absl::StatusOr<TimePattern> TimePattern::Create(std::string_view pattern) {
  TimePattern result;
  result.text_ = std::string(pattern);
  std::size_t at = 0;
  MLE_RETURN_IF_ERROR(result.Compile(pattern, at, 0));
  const auto has = [&](Field field) {
    for (const Step& step : result.steps_) {
      if (step.field == field) return true;
    }
    return false;
  };
  const char* const missing =
      !has(Field::kYear) && !has(Field::kShortYear)    ? "year (%Y or %y)"
      : !has(Field::kMonth) && !has(Field::kMonthName) ? "month (%m or %b)"
      : !has(Field::kDay)                              ? "day (%d)"
      : !has(Field::kHour)                             ? "hour (%H)"
                                                       : nullptr;
  if (missing == nullptr) return result;
  return InvalidArgument(
      "the form of time '", result.text_, "' has no ", missing,
      "; choose from %Y %y %m %b %d %H %I %M %S %p %z, such as "
      "%d.%m.%Y %H:%M");
}

}  // namespace mle
