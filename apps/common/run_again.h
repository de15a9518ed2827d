// How the results of a command are had again: what its page and its JSON say.

#ifndef APPS_COMMON_RUN_AGAIN_H_
#define APPS_COMMON_RUN_AGAIN_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "apps/report/html.h"

namespace mle {

// Names and values of the flags that shape results: not --out, --threads,
// --verbose and --json.
std::vector<std::pair<std::string, std::string>> ResultFlags();

// Command line, version, seeds (the first and the last, if there are any) and
// flags. `checksums`: names and values that come before the flags.
report::RunAgain HowToRunAgain(
    const std::vector<std::uint64_t>& seeds,
    std::vector<std::pair<std::string, std::string>> checksums = {});

}  // namespace mle

#endif  // APPS_COMMON_RUN_AGAIN_H_
