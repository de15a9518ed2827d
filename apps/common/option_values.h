// Values of options that are written as text: names that stand for something,
// lists, a number for each channel. Each maker binds a field and gives the
// default as text.
//
//   {"selection", OneOf(&selection.rule, {{"blocks", Rule::kBlocks}, …}), …}
//   {"output_weight", ForEachOutput(&mpc.output_weight, "0.2"), …}
//
// Numbers are finite and in decimal notation; blanks around them are allowed.

#ifndef APPS_COMMON_OPTION_VALUES_H_
#define APPS_COMMON_OPTION_VALUES_H_

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/base/number_range.h"

namespace mle {

// "did you mean 'huber'? ", with a blank at the end; empty where none of
// `known` is near (mle/data/nearest_names.h).
std::string DidYouMean(std::string_view given,
                       const std::vector<std::string>& known);

struct TextValue {
  std::string text = {};  // the default, then the value
  // Puts a text into the field. InvalidArgument says what is wrong with it; the
  // table adds the option's name.
  std::function<absl::Status(const std::string& text, const NumberRange&)>
      read = {};
  // For a value for each channel: once their number is known.
  std::function<absl::Status(int outputs, int inputs)> fit = {};
  std::string known = {};  // the names that are possible, for the help text
  std::vector<std::string> names = {};  // the same without what they mean
};

struct ChoiceText {
  std::string name;
  std::string meaning;  // may be empty
};

// `set` is called with the number of the name.
TextValue OneOfNames(std::string text, const std::vector<ChoiceText>& choices,
                     std::function<void(std::size_t)> set);

template <typename Value>
struct Choice {
  std::string name;
  Value value;
  std::string meaning;
};

// The default is the name of the field's value.
template <typename Value>
TextValue OneOf(Value* field, std::vector<Choice<Value>> choices) {
  std::vector<ChoiceText> texts;
  std::string text;
  for (const Choice<Value>& choice : choices) {
    texts.push_back({choice.name, choice.meaning});
    if (choice.value == *field) text = choice.name;
  }
  return OneOfNames(std::move(text), texts,
                    [field, choices = std::move(choices)](std::size_t number) {
                      *field = choices[number].value;
                    });
}

// "a,b": the parts that are not blank.
TextValue Words(std::vector<std::string>* words);
// "1,2.5"; blank: none.
TextValue Numbers(std::vector<double>* numbers);
// Blank: none.
TextValue OptionalNumber(std::optional<double>* number);
// 0 stands for an infinite value, which is the default where the field has it.
TextValue ZeroForInfinity(double* number);

// "0.2" or "0.2,0.3": one number for all channels, or one for each; as many as
// are given until `fit` is called. Of a matrix the diagonal.
TextValue ForEachOutput(Eigen::VectorXd* values, std::string text);
TextValue ForEachOutput(Eigen::MatrixXd* diagonal, std::string text);
TextValue ForEachInput(Eigen::VectorXd* values, std::string text);
TextValue ForEachInput(Eigen::MatrixXd* diagonal, std::string text);
// The same, where a blank text, the default, leaves the values empty.
TextValue OptionalForEachOutput(Eigen::VectorXd* values);
TextValue OptionalForEachInput(Eigen::VectorXd* values);
// The same, where `none` stands for `unlimited` too.
TextValue LimitOfEachOutput(Eigen::VectorXd* limits, double unlimited);
TextValue LimitOfEachInput(Eigen::VectorXd* limits, double unlimited);

// The parts of a comma-separated list, without empty ones.
std::vector<std::string> ParseList(std::string_view text);

// A list of numbers in the range; `none` stands for `unlimited`, if that is
// given.
absl::StatusOr<Eigen::VectorXd> ParseNumbers(
    std::string_view text, const NumberRange& range,
    std::optional<double> unlimited = {});

// One value stands for `count`; none stay none.
absl::StatusOr<Eigen::VectorXd> FitToChannels(const Eigen::VectorXd& values,
                                              int count);

}  // namespace mle

#endif  // APPS_COMMON_OPTION_VALUES_H_
