// The options of a command: one table that binds each option's name, field,
// unit, range and help text. From it come the flags, --help, the checks with
// their messages, and the list of values in results.
//
//   Request request;
//   OptionTable table;
//   table.Add("Decision", {
//       {"confidence", &request.confidence, "Of the intervals.", "",
//        kProbability},
//       {"order", &request.order, "Order of the model; 0: chosen.", "samples",
//        kNotNegative}});
//   StartCommand(usage, table, argc, argv);     // values are in the fields
//   MLE_RETURN_IF_ERROR(table.FitTo(model));    // a value for each channel
//
// The default of an option is what its field holds when it is added. Structs
// that several commands have come with a function that makes their options, so
// that an option stands once: see controller_options.h, correct_options.h.

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

class OptionTable {
 public:
  // Options of one group, which --help shows under its heading.
  void Add(const std::string& group, std::vector<Option> options);

  // Makes a flag (gflags) of each option. Fields and table must then live as
  // long as the program.
  void RegisterFlags();

  // Checks values against their ranges, and reads those that are texts.
  // InvalidArgument: "--name=value: what is wrong, what would be right".
  absl::Status Read();

  // Gives options with a value for each channel as many as `model` has.
  absl::Status FitTo(const ProcessModel& model);

  // Names and values, in the order of the table.
  std::vector<std::pair<std::string, std::string>> Values() const;

  // Groups, options, defaults, units, ranges and texts, in lines of at most 78
  // characters.
  std::string Help() const;

 private:
  struct Row {
    Option option;
    std::string group;
    std::variant<bool, int, std::uint64_t, double, std::string> default_value;
    std::string default_text;
  };

  std::deque<Row> rows_;  // which do not move
};

// "--name=value: message" as an InvalidArgument error.
absl::Status RefuseOption(std::string_view name, std::string_view value,
                          std::string_view message);

// A part of --help: an option with its default, what kind of value it has and
// its text.
std::string HelpOf(std::string_view name, std::string_view default_text,
                   std::string_view kind, std::string_view help);

// The shortest text that reads as `number`: gflags writes 1e-6 as
// 9.9999999999999995e-07.
std::string ReadableNumber(double number);

}  // namespace mle

#endif  // APPS_COMMON_OPTION_TABLE_H_
