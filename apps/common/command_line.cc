#include "apps/common/command_line.h"

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/common/clean_output.h"
#include "apps/common/flag_parser.h"
#include "apps/common/help_text.h"
#include "apps/common/process_faults.h"
#include "apps/report/text.h"
#include "glog/logging.h"
#include "mle/base/file.h"
#include "mle/base/status.h"
#include "mle/base/version.h"

namespace mle {
namespace {

std::string& StoredCommandLine() {
  static std::string* const kLine = new std::string;
  return *kLine;
}

const OptionTable* stored_table = nullptr;

std::string NameOf(const char* program) {
  const std::string path = program;
  return path.substr(path.find_last_of('/') + 1);
}

// Answers --help, --help=all, --help=man, --help=bash and --help=WORD; gives
// the exit code.
int PrintHelp(const std::string& command, const std::string& topic,
              const std::string& usage, const OptionTable& table) {
  if (topic.empty()) {
    std::cout << ShortHelp(usage, table);
  } else if (topic == "all") {
    std::cout << FullHelp(usage, table);
  } else if (topic == "man") {
    std::cout << ManualPage(command, LibraryVersion(), usage, table);
  } else if (topic == "bash") {
    std::cout << BashCompletion(command, table);
  } else {
    const absl::StatusOr<std::string> found = HelpOn(topic, table);
    if (!found.ok()) return Fail(found.status());
    std::cout << *found;
  }
  return kExitDone;
}

void ParseCommandLine(const std::string& usage, const OptionTable& table,
                      int argc, char** argv) {
  PrepareForFaults();
  CleanOutput();
  google::InitGoogleLogging(argv[0]);
  FLAGS_logtostderr = true;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  std::vector<std::string> line = {NameOf(argv[0])};
  line.insert(line.end(), arguments.begin(), arguments.end());
  StoredCommandLine() = report::QuoteCommandLine(line);
  ParsedFlags parsed;
  const absl::Status status = ParseFlags(arguments, parsed);
  if (parsed.help) {
    std::exit(PrintHelp(NameOf(argv[0]), parsed.help_topic, usage, table));
  }
  if (parsed.version) {
    std::cout << NameOf(argv[0]) << " " << LibraryVersion() << "\n";
    std::exit(kExitDone);
  }
  if (!status.ok()) std::exit(Fail(status));
}

}  // namespace

void StartCommand(const std::string& usage, OptionTable& table, int argc,
                  char** argv) {
  stored_table = &table;
  table.RegisterFlags();
  ParseCommandLine(usage, table, argc, argv);
  if (const absl::Status status = table.Read(); !status.ok()) {
    std::exit(Fail(status));
  }
}

std::string CommandLine() { return StoredCommandLine(); }

void SayError(const std::string& message) {
  std::cerr << "error: "
            << absl::StrReplaceAll(message, {{"\n", "\\n"}, {"\r", "\\r"}})
            << "\n";
}

int Fail(const absl::Status& status) {
  SayError(std::string(status.message()));
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
  MLE_RETURN_IF_ERROR(AboutOption("out", MakeWritableFolder(folder)));
  MLE_ASSIGN_OR_RETURN(FolderLock lock,
                       AboutOption("out", FolderLock::Take(folder)));
  RemoveLeftovers(folder);
  MLE_RETURN_IF_ERROR(AboutOption(
      "out", CheckNothingInTheWay(folder, {".csv", ".html", ".json", ".mat",
                                           ".pdf", ".png", ".svg"})));
  return lock;
}

int UsableThreads(int asked) {
  return static_cast<int>(
      std::min(static_cast<unsigned>(asked),
               std::max(std::thread::hardware_concurrency(), 1u)));
}

NamesAndValues ShapingResults(NamesAndValues options) {
  std::erase_if(options, [](const auto& option) {
    return option.first == "out" || option.first == "threads" ||
           option.first == "verbose" || option.first == "json" ||
           option.first == "part";
  });
  return options;
}

NamesAndValues ResultFlags() { return ShapingResults(stored_table->Values()); }

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
  again.version = std::string(LibraryVersion());
  again.more = std::move(checksums);
  again.more.insert(again.more.end(), options.begin(), options.end());
  return again;
}

}  // namespace mle
