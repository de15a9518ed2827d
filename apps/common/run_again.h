// How the results of a command are had again: what its page and its JSON say.

#ifndef APPS_COMMON_RUN_AGAIN_H_
#define APPS_COMMON_RUN_AGAIN_H_

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "apps/report/html.h"

namespace mle {

using NamesAndValues = std::vector<std::pair<std::string, std::string>>;

// The options that shape results: all but out, part, threads, verbose and json.
NamesAndValues ShapingResults(NamesAndValues options);

// The same of the flags of the command that was started.
NamesAndValues ResultFlags();

// Command line, version, seeds (the first and the last, if there are any) and
// flags. `checksums`: names and values that come before the flags.
report::RunAgain HowToRunAgain(const std::vector<std::uint64_t>& seeds,
                               NamesAndValues checksums = {});

// The same for a run that was not started as a command: the call and its
// options.
report::RunAgain HowToCallAgain(const std::string& call,
                                const NamesAndValues& options,
                                NamesAndValues checksums);

}  // namespace mle

#endif  // APPS_COMMON_RUN_AGAIN_H_
