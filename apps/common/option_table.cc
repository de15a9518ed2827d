#include "apps/common/option_table.h"

#include <algorithm>
#include <type_traits>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "gflags/gflags.h"
#include "glog/logging.h"
#include "mle/base/absl_view.h"
#include "mle/base/status.h"

namespace mle {
namespace {

template <typename Value>
constexpr bool kIsNumber =
    std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>;

std::string TextOf(bool value) { return value ? "true" : "false"; }
std::string TextOf(int value) { return absl::StrCat(value); }
std::string TextOf(std::uint64_t value) { return absl::StrCat(value); }
std::string TextOf(double value) { return ReadableNumber(value); }
std::string TextOf(const std::string& value) { return value; }

std::string CurrentText(const Option& option) {
  return std::visit(
      [](const auto& value) {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, TextValue>) {
          return value.text;
        } else {
          return TextOf(*value);
        }
      },
      option.value);
}

// "min, > 0".
std::string KindOf(const Option& option) {
  std::vector<std::string> parts = {option.unit, option.range.Describe()};
  std::erase(parts, "");
  return absl::StrJoin(parts, ", ");
}

std::string HelpText(const Option& option) {
  const TextValue* const text = std::get_if<TextValue>(&option.value);
  return text == nullptr || text->known.empty()
             ? option.help
             : absl::StrCat(option.help, " One of ", text->known, ".");
}

absl::Status ReadFlagOption(Option& option) {
  return std::visit(
      [&option](auto& value) -> absl::Status {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, TextValue>) {
          return value.read(value.text, option.range);
        } else if constexpr (kIsNumber<std::remove_pointer_t<Value>>) {
          if (option.range.Contains(static_cast<double>(*value))) {
            return absl::OkStatus();
          }
          const bool whole = !std::is_same_v<Value, double*>;
          const std::string bounds = option.range.Describe();
          return InvalidArgument("it must be a ", whole ? "whole" : "finite",
                                 " number", bounds.empty() ? "" : " ", bounds);
        } else {
          return absl::OkStatus();
        }
      },
      option.value);
}

// Reads a flag's text by the type of its field; false where it does not fit.
bool Parse(const std::string& text, bool* field) {
  return absl::SimpleAtob(text, field);
}
bool Parse(const std::string& text, int* field) {
  return absl::SimpleAtoi(text, field);
}
bool Parse(const std::string& text, std::uint64_t* field) {
  return absl::SimpleAtoi(text, field);
}
bool Parse(const std::string& text, double* field) {
  return absl::SimpleAtod(text, field);
}

const char* KindOfField(const bool* /*field*/) { return "true or false"; }
const char* KindOfField(const int* /*field*/) {
  return "a whole number from -2147483648 to 2147483647";
}
const char* KindOfField(const std::uint64_t* /*field*/) {
  return "a whole number from 0 to 18446744073709551615";
}
const char* KindOfField(const double* /*field*/) { return "a number"; }

absl::Status SetOption(const std::string& text, Option& option) {
  return std::visit(
      [&](auto& value) -> absl::Status {
        using Value = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<Value, TextValue>) {
          value.text = text;
        } else if constexpr (std::is_same_v<Value, std::string*>) {
          *value = text;
        } else if (!Parse(text, value)) {
          return RefuseOption(option.name, text,
                              absl::StrCat("it must be ", KindOfField(value)));
        }
        return absl::OkStatus();
      },
      option.value);
}

}  // namespace

std::vector<Option> Only(const std::vector<Option>& options,
                         const std::vector<std::string>& names) {
  std::vector<Option> some;
  for (const Option& option : options) {
    if (std::count(names.begin(), names.end(), option.name) > 0) {
      some.push_back(option);
    }
  }
  CHECK_EQ(some.size(), names.size()) << "an option has another name";
  return some;
}

Option& Find(std::vector<Option>& options, std::string_view name) {
  const auto found =
      std::find_if(options.begin(), options.end(),
                   [&](const Option& option) { return option.name == name; });
  CHECK(found != options.end()) << "no option " << name;
  return *found;
}

void OptionTable::Add(const std::string& group, std::vector<Option> options) {
  for (Option& option : options) {
    Row& row = rows_.emplace_back();
    row.group = group;
    row.option = std::move(option);
    row.default_text = CurrentText(row.option);
  }
}

void OptionTable::RegisterFlags() {
  for (Row& row : rows_) {
    const auto make = [&row](auto* storage) {
      using Value = std::remove_pointer_t<decltype(storage)>;
      row.default_value = *storage;
      gflags::FlagRegisterer(row.option.name.c_str(), row.option.help.c_str(),
                             row.group.c_str(), storage,
                             &std::get<Value>(row.default_value));
    };
    std::visit(
        [&make](auto& value) {
          using Value = std::decay_t<decltype(value)>;
          if constexpr (std::is_same_v<Value, TextValue>) {
            make(&value.text);
          } else {
            make(value);
          }
        },
        row.option.value);
  }
}

absl::Status OptionTable::Set(std::string_view name, const std::string& text) {
  for (Row& row : rows_) {
    if (row.option.name == name) return SetOption(text, row.option);
  }
  return absl::NotFoundError(
      absl::StrCat("there is no option '", AbslView(name), "'"));
}

absl::Status OptionTable::Read() {
  for (Row& row : rows_) {
    const absl::Status status = ReadFlagOption(row.option);
    if (!status.ok()) {
      return RefuseOption(row.option.name, CurrentText(row.option),
                          {status.message().data(), status.message().size()});
    }
  }
  return absl::OkStatus();
}

absl::Status OptionTable::FitTo(const ProcessModel& model) {
  for (Row& row : rows_) {
    const auto* const text = std::get_if<TextValue>(&row.option.value);
    if (text == nullptr || !text->fit) continue;
    const absl::Status status =
        text->fit(model.num_outputs(), model.num_inputs());
    if (!status.ok()) {
      return RefuseOption(row.option.name, text->text,
                          {status.message().data(), status.message().size()});
    }
  }
  return absl::OkStatus();
}

std::vector<std::pair<std::string, std::string>> OptionTable::Values() const {
  std::vector<std::pair<std::string, std::string>> values;
  for (const Row& row : rows_) {
    values.emplace_back(row.option.name, CurrentText(row.option));
  }
  return values;
}

std::string OptionTable::FirstChanged(std::string_view prefix) const {
  for (const Row& row : rows_) {
    if (row.option.name.starts_with(prefix) &&
        CurrentText(row.option) != row.default_text) {
      return row.option.name;
    }
  }
  return "";
}

void OptionTable::PutFirst(std::vector<std::string> names) {
  first_ = std::move(names);
}

std::vector<OptionText> OptionTable::Texts(bool only_first) const {
  std::vector<OptionText> texts;
  for (const Row& row : rows_) {
    const Option& option = row.option;
    const TextValue* const text = std::get_if<TextValue>(&option.value);
    texts.push_back(
        {row.group, option.name, row.default_text, KindOf(option),
         HelpText(option),
         text == nullptr ? std::vector<std::string>() : text->names,
         std::holds_alternative<bool*>(option.value),
         std::count(first_.begin(), first_.end(), option.name) > 0});
  }
  if (!only_first) return texts;
  std::vector<OptionText> first;
  for (const std::string& name : first_) {
    const auto found =
        std::find_if(texts.begin(), texts.end(),
                     [&](const OptionText& text) { return text.name == name; });
    CHECK(found != texts.end()) << "no option " << name;
    first.push_back(*found);
  }
  return first;
}

absl::Status RefuseOption(std::string_view name, std::string_view value,
                          std::string_view message) {
  return InvalidArgument("--", AbslView(name), "=", AbslView(value), ": ",
                         AbslView(message));
}

absl::Status AboutOption(std::string_view name, const absl::Status& status) {
  return status.ok()
             ? status
             : InvalidArgument("--", AbslView(name), ": ", status.message());
}

absl::Status CheckSamples(std::string_view name, double value,
                          double sample_time) {
  constexpr double kMostSamples = 1e7;
  if (value / sample_time <= kMostSamples) return absl::OkStatus();
  return RefuseOption(
      name, ReadableNumber(value),
      absl::StrFormat("it has %.3g samples of --sample_time=%s; at most %g",
                      value / sample_time, ReadableNumber(sample_time),
                      kMostSamples));
}

std::string ReadableNumber(double number) {
  const std::string readable = absl::StrFormat("%.15g", number);
  double again = 0.0;
  return absl::SimpleAtod(readable, &again) && again == number
             ? readable
             : absl::StrFormat("%.17g", number);
}

}  // namespace mle
