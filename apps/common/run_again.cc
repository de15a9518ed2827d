#include "apps/common/run_again.h"

#include "absl/strings/str_cat.h"
#include "apps/common/command_line.h"

namespace mle {

std::vector<std::pair<std::string, std::string>> ResultFlags() {
  std::vector<std::pair<std::string, std::string>> values = GivenOptions();
  std::erase_if(values, [](const auto& option) {
    return option.first == "out" || option.first == "threads" ||
           option.first == "verbose" || option.first == "json";
  });
  return values;
}

report::RunAgain HowToRunAgain(
    const std::vector<std::uint64_t>& seeds,
    std::vector<std::pair<std::string, std::string>> checksums) {
  report::RunAgain again;
  again.command = CommandLine();
  again.version = std::string(Version());
  if (!seeds.empty()) again.seeds = absl::StrCat(seeds.front());
  if (seeds.size() > 1) absl::StrAppend(&again.seeds, " … ", seeds.back());
  again.more = std::move(checksums);
  for (const auto& [name, value] : ResultFlags()) {
    again.more.emplace_back(absl::StrCat("--", name), value);
  }
  return again;
}

}  // namespace mle
