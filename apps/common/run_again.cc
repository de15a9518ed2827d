#include "apps/common/run_again.h"

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"

namespace mle {

NamesAndValues ShapingResults(NamesAndValues options) {
  std::erase_if(options, [](const auto& option) {
    return option.first == "out" || option.first == "threads" ||
           option.first == "verbose" || option.first == "json" ||
           option.first == "part";
  });
  return options;
}

NamesAndValues ResultFlags() { return ShapingResults(GivenOptions()); }

report::RunAgain HowToRunAgain(const std::vector<std::uint64_t>& seeds,
                               NamesAndValues checksums) {
  NamesAndValues flags;
  for (const auto& [name, value] : ResultFlags()) {
    flags.emplace_back(absl::StrCat("--", name), value);
  }
  report::RunAgain again =
      HowToCallAgain(CommandLine(), flags, std::move(checksums));
  if (!seeds.empty()) again.seeds = absl::StrCat(seeds.front());
  if (seeds.size() > 1) absl::StrAppend(&again.seeds, " … ", seeds.back());
  return again;
}

report::RunAgain HowToCallAgain(const std::string& call,
                                const NamesAndValues& options,
                                NamesAndValues checksums) {
  report::RunAgain again;
  again.command = call;
  again.version = std::string(Version());
  again.more = std::move(checksums);
  again.more.insert(again.more.end(), options.begin(), options.end());
  return again;
}

}  // namespace mle
