// The help on a command's flags, made from its table of options: --help, the
// manual page, and the completion of bash.
//
//   std::cout << ShortHelp(usage, table);     // --help
//   std::cout << FullHelp(usage, table);      // --help=all
//   std::cout << HelpOn("window", table);     // --help=window
//
// A usage text opens with a paragraph that says what the command does; lines
// that begin with two blanks are examples.

#ifndef APPS_COMMON_HELP_TEXT_H_
#define APPS_COMMON_HELP_TEXT_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/common/option_table.h"

namespace mle {

// The usage and the first sentence about each flag that was put first.
std::string ShortHelp(std::string_view usage, const OptionTable& table);

// The usage and every flag: group, default, unit, range and text, in lines of
// at most 78 characters.
std::string FullHelp(std::string_view usage, const OptionTable& table);

// The flags whose names contain `topic`, in full. InvalidArgument where there
// are none.
absl::StatusOr<std::string> HelpOn(const std::string& topic,
                                   const OptionTable& table);

// man(7), section 1.
std::string ManualPage(std::string_view command, std::string_view version,
                       std::string_view usage, const OptionTable& table);

// A script for bash's programmable completion: flags, the values of those that
// have names, and files.
std::string BashCompletion(std::string_view command, const OptionTable& table);
// The same with @command@, @flags@ and @cases@ in their places
// (completion.bash). In it the name and the value may be three words, where =
// splits them, or one.
std::string_view CompletionTemplate();

}  // namespace mle

#endif  // APPS_COMMON_HELP_TEXT_H_
