#include "apps/common/command_line.h"

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "gflags/gflags.h"
#include "glog/logging.h"

DECLARE_bool(help);
DECLARE_bool(helpfull);
DECLARE_bool(helpshort);
DECLARE_bool(version);

namespace GFLAGS_NAMESPACE {
// What gflags calls when a flag cannot be read.
extern void (*gflags_exitfunc)(int);
}  // namespace GFLAGS_NAMESPACE

namespace mle {
namespace {

std::string& StoredCommandLine() {
  static std::string* const line = new std::string;
  return *line;
}

std::string QuoteForShell(std::string_view argument) {
  const bool plain =
      !argument.empty() &&
      argument.find_first_not_of(
          "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
          "-_=./,:+@%") == std::string_view::npos;
  if (plain) return std::string(argument);
  std::string quoted = "'";
  for (const char c : argument)
    quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

absl::string_view Absl(std::string_view text) {
  return {text.data(), text.size()};
}

// "apps/mle_reproduce" as gflags knows the file of the flags of this command.
std::string NameOf(const char* program) {
  const std::string path = program;
  return path.substr(path.find_last_of('/') + 1);
}

void PrintHelp(const std::string& name) {
  std::vector<gflags::CommandLineFlagInfo> flags;
  gflags::GetAllFlags(&flags);
  std::cout << gflags::ProgramUsage()
            << "\n\nFlags (value in brackets: the default):\n";
  for (const gflags::CommandLineFlagInfo& flag : flags) {
    if (flag.filename.find(name) == std::string::npos) continue;
    std::cout << "  --" << flag.name << " [" << flag.default_value << "]\n";
    std::string line = "     ";
    for (const absl::string_view word :
         absl::StrSplit(flag.description, ' ', absl::SkipEmpty())) {
      if (line.size() + word.size() > 78) {
        std::cout << line << "\n";
        line = "     ";
      }
      absl::StrAppend(&line, " ", word);
    }
    std::cout << line << "\n";
  }
  std::cout << "  --flagfile\n      Reads flags from a file, one a line; later "
               "ones win.\n";
}

}  // namespace

void StartCommand(const std::string& usage, int& argc, char**& argv) {
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  for (int i = 0; i < argc; ++i) {
    if (i > 0) StoredCommandLine() += ' ';
    StoredCommandLine() += QuoteForShell(i == 0 ? NameOf(argv[0]) : argv[i]);
  }
  gflags::SetUsageMessage(usage);
  gflags::SetVersionString(std::string(Version()));
  GFLAGS_NAMESPACE::gflags_exitfunc = [](int) { std::exit(kExitBadInput); };
  gflags::ParseCommandLineNonHelpFlags(&argc, &argv, /*remove_flags=*/true);
  if (FLAGS_version) {
    std::cout << NameOf(argv[0]) << " " << Version() << "\n";
    std::exit(kExitDone);
  }
  if (FLAGS_help || FLAGS_helpshort || FLAGS_helpfull) {
    PrintHelp(NameOf(argv[0]));
    std::exit(kExitDone);
  }
  if (argc > 1) {
    std::cerr << "error: '" << argv[1]
              << "' is no flag; flags begin with -- (see --help)\n";
    std::exit(kExitBadInput);
  }
}

std::string CommandLine() { return StoredCommandLine(); }

std::string_view Version() { return MLE_VERSION; }

int Fail(const absl::Status& status) {
  std::cerr << "error: " << status.message() << "\n";
  switch (status.code()) {
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kInternal:
      return kExitNotUsable;
    default:
      return kExitBadInput;
  }
}

absl::StatusOr<Eigen::VectorXd> ParseNumbers(std::string_view flag,
                                             std::string_view value,
                                             int count) {
  const std::vector<std::string> parts = ParseList(value);
  Eigen::VectorXd numbers(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    double number = 0.0;
    if (!absl::SimpleAtod(parts[i], &number) || !std::isfinite(number)) {
      return absl::InvalidArgumentError(absl::StrFormat(
          "--%s=%s: '%s' is no number", Absl(flag), Absl(value), parts[i]));
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

std::vector<std::string> ParseList(std::string_view value) {
  std::vector<std::string> parts;
  for (const absl::string_view part :
       absl::StrSplit(Absl(value), ',', absl::SkipWhitespace())) {
    parts.emplace_back(absl::StripAsciiWhitespace(part));
  }
  return parts;
}

}  // namespace mle
