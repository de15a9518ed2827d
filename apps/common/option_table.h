// The options of a command: one table that binds each option's name, field,
// unit, range and help text. From it come the flags, --help, the manual page
// and the completion of shells (help_text.h), the checks with their messages,
// and the list of values in results.
//
//   Request request;
//   OptionTable table;
//   table.Add("Decision", {
//       {"confidence", &request.confidence, "Of the intervals.", "",
//        kProbability},
//       {"order", &request.order, "Order of the model; 0: chosen.", "samples",
//        kNotNegative}});
//   table.PutFirst({"order"});                  // what --help shows
//   StartCommand(usage, table, argc, argv);     // values are in the fields
//   MLE_RETURN_IF_ERROR(table.FitTo(model));    // a value for each channel
//
// The default of an option is what its field holds when it is added. Structs
// that several commands have come with a function that makes their options, so
// that an option stands once: see shared_options.h.

#ifndef APPS_COMMON_OPTION_TABLE_H_
#define APPS_COMMON_OPTION_TABLE_H_

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_values.h"
#include "mle/base/number_range.h"
#include "mle/model/process_model.h"

namespace mle {

inline constexpr NumberRange kProbability{
    .min = 0.0, .max = 1.0, .open_min = true, .open_max = true};
inline constexpr NumberRange kShare = Between(0.0, 1.0);

struct Option {
  std::string name;
  // The field, or how a text is put into it.
  std::variant<bool*, int*, std::uint64_t*, double*, std::string*, TextValue>
      value;
  std::string help;
  std::string unit = "";  // "min" for the model's time unit
  NumberRange range = kAnyNumber;
};

// Those of `options` with these names, in their order.
std::vector<Option> Only(const std::vector<Option>& options,
                         const std::vector<std::string>& names);

// The option of that name, to be changed before it is added.
Option& Find(std::vector<Option>& options, std::string_view name);

// The texts on an option that users read.
struct OptionText {
  std::string group;
  std::string name;
  std::string default_text = {};
  std::string kind = {};  // unit and range: "min, > 0"
  std::string help = {};
  // The names that are possible, if few are.
  std::vector<std::string> values = {};
  bool is_switch = false;  // true or false
  bool first = false;      // among those most needed
};

class OptionTable {
 public:
  // Options of one group, which --help=all shows under its heading.
  void Add(const std::string& group, std::vector<Option> options);

  // Those that most users need, which are all that --help shows, in this order.
  void PutFirst(std::vector<std::string> names);

  // Makes a flag (gflags) of each option. Fields and table must then live as
  // long as the program.
  void RegisterFlags();

  // Gives the option `name` the value that `text` stands for, as its flag
  // would. InvalidArgument for a text that is none, NotFound for a name that is
  // not in the table. Read() checks ranges.
  absl::Status Set(std::string_view name, const std::string& text);

  // Checks values against their ranges, and reads those that are texts.
  // InvalidArgument: "--name=value: what is wrong, what would be right".
  absl::Status Read();

  // Gives options with a value for each channel as many as `model` has.
  absl::Status FitTo(const ProcessModel& model);

  // Names and values, in the order of the table.
  std::vector<std::pair<std::string, std::string>> Values() const;

  // The first option whose name begins with `prefix` and whose value is not its
  // default; empty where there is none.
  std::string FirstChanged(std::string_view prefix) const;

  // In the order of the table; Texts(true): those put first, in their order.
  std::vector<OptionText> Texts(bool only_first = false) const;

 private:
  struct Row {
    Option option;
    std::string group;
    std::variant<bool, int, std::uint64_t, double, std::string> default_value;
    std::string default_text;
  };

  std::deque<Row> rows_;  // which do not move
  std::vector<std::string> first_;
};

// "--name=value: message" as an InvalidArgument error.
absl::Status RefuseOption(std::string_view name, std::string_view value,
                          std::string_view message);

// "--name: message", as an InvalidArgument error; a good status, or the value,
// stays as it is.
absl::Status AboutOption(std::string_view name, const absl::Status& status);
template <typename Value>
absl::StatusOr<Value> AboutOption(std::string_view name,
                                  absl::StatusOr<Value> value) {
  if (value.ok()) return value;
  return AboutOption(name, value.status());
}

// That the time `value` of the option has at most 10⁷ samples, which still fit
// into the memory.
absl::Status CheckSamples(std::string_view name, double value,
                          double sample_time);

// The shortest text that reads as `number`: gflags writes 1e-6 as
// 9.9999999999999995e-07.
std::string ReadableNumber(double number);

}  // namespace mle

#endif  // APPS_COMMON_OPTION_TABLE_H_
