// A password asked for on the terminal.

#ifndef APPS_COMMON_PASSWORD_PROMPT_H_
#define APPS_COMMON_PASSWORD_PROMPT_H_

#include <optional>
#include <string>

namespace mle {

// The line typed after `prompt`, which the terminal does not show; nothing
// without a terminal, and where no line is typed.
std::optional<std::string> AskPassword(const std::string& prompt);

}  // namespace mle

#endif  // APPS_COMMON_PASSWORD_PROMPT_H_
