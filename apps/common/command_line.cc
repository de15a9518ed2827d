#include "apps/common/command_line.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "apps/common/flag_parser.h"
#include "apps/common/process_faults.h"
#include "apps/report/text.h"
#include "glog/logging.h"
#include "mle/base/file.h"
#include "mle/base/version.h"

namespace mle {
namespace {

std::string& StoredCommandLine() {
  static std::string* const kLine = new std::string;
  return *kLine;
}

// Null where flags are defined by macros.
const OptionTable* stored_table = nullptr;

absl::string_view Absl(std::string_view text) {
  return {text.data(), text.size()};
}

std::string NameOf(const char* program) {
  const std::string path = program;
  return path.substr(path.find_last_of('/') + 1);
}

void PrintHelp(const std::string& usage, const std::string& flags) {
  std::cout << usage << "\n\nFlags (value in brackets: the default):\n"
            << flags
            << "\nFlag files\n  --flagfile\n      Reads flags from a file, one "
               "a line; later ones win.\n";
}

std::string HelpOfMacros() {
  std::string help;
  for (const FlagText& flag : CommandFlags()) {
    help += HelpOf(flag.name, flag.default_value, "", flag.description);
  }
  return help;
}

// `help` describes the flags.
void ParseCommandLine(const std::string& usage, const std::string& help,
                      int argc, char** argv) {
  PrepareForFaults();
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  std::vector<std::string> line = {NameOf(argv[0])};
  line.insert(line.end(), arguments.begin(), arguments.end());
  StoredCommandLine() = report::QuoteCommandLine(line);
  ParsedFlags parsed;
  const absl::Status status = ParseFlags(arguments, parsed);
  if (parsed.help) {
    PrintHelp(usage, help);
    std::exit(kExitDone);
  }
  if (parsed.version) {
    std::cout << NameOf(argv[0]) << " " << Version() << "\n";
    std::exit(kExitDone);
  }
  if (!status.ok()) std::exit(Fail(status));
}

}  // namespace

void StartCommand(const std::string& usage, OptionTable& table, int argc,
                  char** argv) {
  stored_table = &table;
  table.RegisterFlags();
  ParseCommandLine(usage, table.Help(), argc, argv);
  if (const absl::Status status = table.Read(); !status.ok()) {
    std::exit(Fail(status));
  }
}

void StartCommand(const std::string& usage, int argc, char** argv) {
  ParseCommandLine(usage, HelpOfMacros(), argc, argv);
}

std::string CommandLine() { return StoredCommandLine(); }

std::vector<std::pair<std::string, std::string>> GivenOptions() {
  if (stored_table != nullptr) return stored_table->Values();
  std::vector<std::pair<std::string, std::string>> values;
  for (const FlagText& flag : CommandFlags()) {
    values.emplace_back(flag.name, flag.value);
  }
  return values;
}

std::string_view Version() { return LibraryVersion(); }

int Fail(const absl::Status& status) {
  std::cerr << "error: " << status.message() << "\n";
  switch (status.code()) {
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kResourceExhausted:
      return kExitNotUsable;
    default:
      return kExitBadInput;
  }
}

absl::StatusOr<FolderLock> ClaimOutputFolder(const std::string& folder) {
  const auto wrong = [](const absl::Status& status) {
    return absl::InvalidArgumentError(
        absl::StrCat("--out: ", status.message()));
  };
  if (const absl::Status made = MakeWritableFolder(folder); !made.ok()) {
    return wrong(made);
  }
  absl::StatusOr<FolderLock> lock = FolderLock::Take(folder);
  if (!lock.ok()) return wrong(lock.status());
  return lock;
}

absl::StatusOr<Eigen::VectorXd> ParseNumbers(std::string_view flag,
                                             std::string_view value,
                                             int count) {
  // Empty parts stay: they are typing errors.
  const std::vector<std::string> parts = absl::StrSplit(Absl(value), ',');
  Eigen::VectorXd numbers(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double number = 0.0;
    if (!absl::SimpleAtod(parts[i], &number) || !std::isfinite(number)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "--%s=%s: '%s' is not a number", Absl(flag), Absl(value), parts[i]));
    }
    numbers(i) = number;
  }
  if (numbers.size() == 1) {
    return Eigen::VectorXd::Constant(count, numbers(0)).eval();
  }
  if (numbers.size() != count) {
    return absl::InvalidArgumentError(absl::StrFormat(
        "--%s=%s has %d values; one is needed, or one for each of %d channels",
        Absl(flag), Absl(value), numbers.size(), count));
  }
  return numbers;
}

int UsableThreads(int asked) {
  return static_cast<int>(
      std::min(static_cast<unsigned>(asked),
               std::max(std::thread::hardware_concurrency(), 1u)));
}

}  // namespace mle
