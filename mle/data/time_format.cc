#include "mle/data/time_format.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "glog/logging.h"

namespace mle {
namespace {

constexpr double kSecondsPerDay = 86400.0;
// 1899-12-30, from which Excel's days count: it takes 1900 for a leap year.
constexpr double kExcelOrigin = -25569.0 * kSecondsPerDay;
constexpr char kClock[] = "%H:%M[:%S][[ ]%p][[ ]%z]";

// Each date with each of the clocks.
TimeForm DatesOf(TimeFormat format, const char* name, const char* example,
                 bool is_certain, const std::vector<std::string>& dates,
                 const std::vector<std::string>& clocks) {
  TimeForm form;
  form.format = format;
  form.name = name;
  form.example = example;
  form.is_certain = is_certain;
  for (const std::string& date : dates) {
    for (const std::string& clock : clocks) {
      absl::StatusOr<TimePattern> pattern =
          TimePattern::Create(absl::StrCat(date, clock));
      CHECK(pattern.ok()) << pattern.status();
      form.patterns.push_back(*std::move(pattern));
    }
  }
  return form;
}

TimeForm NumbersOf(TimeFormat format, const char* name, const char* example,
                   std::optional<SerialTime> serial) {
  TimeForm form;
  form.format = format;
  form.name = name;
  form.example = example;
  form.is_certain = format == TimeFormat::kNumbers;
  form.serial = serial;
  return form;
}

std::vector<TimeForm> MakeForms() {
  const std::string clock = kClock;
  const std::vector<std::string> clocks = {" " + clock, "T" + clock};
  const std::string iso = "%H:%M[:%S][[ ]%z]";
  TimeForm recognise;
  recognise.format = TimeFormat::kRecognise;
  recognise.name = "recognise";
  recognise.example = "any of these but day_first, month_first and excel";
  return {
      recognise,
      NumbersOf(TimeFormat::kNumbers, "numbers", "in number_unit", {}),
      DatesOf(TimeFormat::kIso, "iso", "2024-02-29T12:34:56Z", true,
              {"%Y-%m-%d"}, {" " + iso, "T" + iso}),
      DatesOf(TimeFormat::kDayFirst, "day_first", "29.02.2024 12:34", false,
              {"%d.%m.%Y", "%d/%m/%Y", "%d-%m-%Y", "%d.%m.%y", "%d/%m/%y",
               "%d-%m-%y"},
              clocks),
      DatesOf(TimeFormat::kMonthFirst, "month_first", "2/29/2024 12:34 PM",
              false,
              {"%m/%d/%Y", "%m-%d-%Y", "%m.%d.%Y", "%m/%d/%y", "%m-%d-%y",
               "%m.%d.%y"},
              clocks),
      DatesOf(TimeFormat::kYearFirst, "year_first", "2024/02/29 12:34", true,
              {"%Y/%m/%d", "%Y.%m.%d"}, clocks),
      DatesOf(TimeFormat::kMonthName, "month_name", "29-Feb-24 12:34:56.0",
              true,
              {"%d-%b-%y", "%d-%b-%Y", "%d/%b/%y", "%d/%b/%Y", "%d[.] %b[.] %Y",
               "%d[.] %b[.] %y", "%d.%b.%Y", "%b[.] %d, %Y", "%b[.] %d %Y"},
              clocks),
      NumbersOf(TimeFormat::kExcel, "excel", "45351.5242",
                SerialTime{kSecondsPerDay, kExcelOrigin}),
      NumbersOf(TimeFormat::kUnix, "unix", "1709210096", SerialTime{1.0, 0.0}),
      NumbersOf(TimeFormat::kUnixMilliseconds, "unix_ms", "1709210096000",
                SerialTime{1e-3, 0.0}),
  };
}

}  // namespace

const std::vector<TimeForm>& TimeForms() {
  static const std::vector<TimeForm>& forms =
      *new std::vector<TimeForm>(MakeForms());
  return forms;
}

const TimeForm& FormOf(TimeFormat format) {
  for (const TimeForm& form : TimeForms()) {
    if (form.format == format) return form;
  }
  LOG(FATAL) << "no form " << static_cast<int>(format);
}

std::optional<CivilTime> ReadCivilTime(std::string_view text,
                                       const TimeForm& form) {
  for (const TimePattern& pattern : form.patterns) {
    if (const auto civil = pattern.Read(text)) return civil;
  }
  return std::nullopt;
}

absl::StatusOr<TimeForm> FormOfPattern(std::string_view pattern) {
  absl::StatusOr<TimePattern> compiled = TimePattern::Create(pattern);
  if (!compiled.ok()) return compiled.status();
  TimeForm form;
  form.format = TimeFormat::kPattern;
  form.name = std::string(pattern);
  form.patterns.push_back(*std::move(compiled));
  return form;
}

}  // namespace mle
