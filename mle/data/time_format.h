// The forms of times that a historian writes, each with its name.
//
// A form is a list of patterns, or a unit and an origin of
// numbers. A certain form can be recognised from one time; the others must be
// declared, since 3/4 may be the third of April or the fourth of March.

#ifndef MLE_DATA_TIME_FORMAT_H_
#define MLE_DATA_TIME_FORMAT_H_

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/civil_time.h"
#include "mle/data/import_options.h"

namespace mle {

// Points in time as text, read by patterns such as strptime(3) has.
//
//   %Y year of four digits      %y of two: 69 … 99 are 19.., 00 … 68 are 20..
//   %m %d %H  month, day and hour, of one or two digits; 24:00 ends a day
//   %b month by name: English or German, three letters at least, any case
//   %M %S     minute and second of two digits; %S with a fraction, if it has
//             one, behind a point or a comma
//   %p AM or PM (a.m., p.m.)    %z zone: Z, UTC, ±hh, ±hhmm, ±hh:mm
//   %% %[ %]  these signs       [ … ] what may be missing
//
// A blank stands for one or more of them, a letter for itself in either case.
//
//   MLE_ASSIGN_OR_RETURN(const TimePattern pattern,
//                        TimePattern::Create("%d.%m.%Y %H:%M[:%S]"));
//   pattern.Read("4.3.2024 06:00");   // 2024-03-04T06:00
//
// absl::ParseTime() has no parts that may be missing and takes three times as
// long (docs/architecture.md).

class TimePattern {
 public:
  // InvalidArgument for unknown fields, brackets that are not closed, and a
  // pattern without year, month, day or hour.
  static absl::StatusOr<TimePattern> Create(std::string_view pattern);

  // Nothing for text of another form, and for dates and times that do not
  // exist. The whole of `text` is read.
  std::optional<CivilTime> Read(std::string_view text) const;

  const std::string& text() const { return text_; }

 private:
  enum class Field {
    kLetter,
    kBlank,
    kYear,
    kShortYear,
    kMonth,
    kMonthName,
    kDay,
    kHour,
    kMinute,
    kSecond,
    kHalfDay,
    kZone,
    kOptional,  // the next `size` steps may be missing
  };
  struct Step {
    Field field;
    char letter = 0;
    int size = 0;
  };
  struct Reading;

  absl::Status Compile(std::string_view pattern, std::size_t& at, int depth);
  bool Match(std::size_t begin, std::size_t end, Reading& reading) const;
  static bool Take(const Step& step, Reading& reading);

  std::string text_;
  std::vector<Step> steps_;
};

// Numbers that stand for dates.
struct SerialTime {
  double seconds_per_unit = 1.0;
  double origin = 0.0;  // seconds since the epoch
};

struct TimeForm {
  TimeFormat format = TimeFormat::kNumbers;
  std::string name;     // "day_first"
  std::string example;  // "29.02.2024 12:34"
  bool is_certain = false;
  std::vector<TimePattern> patterns;  // of dates
  std::optional<SerialTime> serial;
};

// All but kPattern.
const std::vector<TimeForm>& TimeForms();

// The form of kPattern, whose name is the pattern. InvalidArgument as of
// TimePattern::Create().
absl::StatusOr<TimeForm> FormOfPattern(std::string_view pattern);

// By any of the form's patterns; nothing for other text.
std::optional<CivilTime> ReadCivilTime(std::string_view text,
                                       const TimeForm& form);

// One of TimeForms().
const TimeForm& FormOf(TimeFormat format);

}  // namespace mle

#endif  // MLE_DATA_TIME_FORMAT_H_
