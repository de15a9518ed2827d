#include "apps/common/flag_parser.h"

#include <cstddef>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "apps/common/option_table.h"
#include "apps/common/option_values.h"
#include "gflags/gflags.h"
#include "mle/base/file.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr int kMaxDepth = 10;  // of flag files that name flag files

// A flag file may name another.
absl::Status ParseAll(const std::vector<std::string>& arguments, int depth,
                      ParsedFlags& parsed);

// The end of the message on a value that does not fit `type`: "'x' is …".
std::string Wanted(const std::string& type) {
  if (type == "bool") return "neither true nor false";
  if (type == "double") return "not a number";
  if (type == "int32")
    return "not a whole number from -2147483648 to 2147483647";
  if (type == "uint64") {
    return "not a whole number from 0 to 18446744073709551615";
  }
  return absl::StrCat("no ", type);
}

absl::Status SetFlag(const gflags::CommandLineFlagInfo& flag,
                     const std::string& value) {
  const std::string set =
      gflags::SetCommandLineOption(flag.name.c_str(), value.c_str());
  if (!set.empty()) return absl::OkStatus();
  return InvalidArgument("--", flag.name, "=", value, ": '", value, "' is ",
                         Wanted(flag.type));
}

absl::Status ParseFlagFile(const std::string& path, int depth,
                           ParsedFlags& parsed) {
  if (depth > kMaxDepth) {
    return InvalidArgument("--flagfile=", path,
                           ": flag files name each other more than ", kMaxDepth,
                           " deep");
  }
  MLE_ASSIGN_OR_RETURN(const std::string content,
                       AboutOption("flagfile", ReadFile(path)));
  int number = 0;
  for (const absl::string_view text : absl::StrSplit(content, '\n')) {
    ++number;
    const std::string line(absl::StripAsciiWhitespace(text));
    if (line.empty() || line[0] == '#') continue;
    const absl::Status status = ParseAll({line}, depth, parsed);
    if (!status.ok()) {
      return InvalidArgument(path, ":", number, ": ", status.message());
    }
  }
  return absl::OkStatus();
}

// "--name=value" as its parts.
struct Argument {
  std::string name;
  std::string value;
  bool has_value = false;
};

absl::StatusOr<Argument> Split(const std::string& text) {
  const std::size_t dashes = text.find_first_not_of('-');
  if (dashes == std::string::npos || dashes == 0 || dashes > 2) {
    return InvalidArgument("'", text,
                           "' is not a flag; flags begin with -- (see --help)");
  }
  Argument argument;
  const std::size_t equals = text.find('=');
  argument.has_value = equals != std::string::npos;
  if (argument.has_value) {
    argument.name = text.substr(dashes, equals - dashes);
    argument.value = text.substr(equals + 1);
  } else {
    argument.name = text.substr(dashes);
  }
  return argument;
}

// Names of the flags of the command, without those of the libraries it uses.
std::vector<std::string> OwnFlags() {
  std::vector<gflags::CommandLineFlagInfo> all;
  gflags::GetAllFlags(&all);
  std::vector<std::string> names;
  for (const gflags::CommandLineFlagInfo& flag : all) {
    const bool of_library = flag.filename.find("gflags") != std::string::npos ||
                            flag.filename.find("glog") != std::string::npos ||
                            flag.filename.find("src/") == 0 ||
                            flag.filename.find("./src/") == 0;
    if (!of_library) names.push_back(flag.name);
  }
  return names;
}

// The flag of that name; for "noname", the switch "name", turned off.
absl::StatusOr<gflags::CommandLineFlagInfo> FindFlag(Argument& argument) {
  gflags::CommandLineFlagInfo flag;
  if (gflags::GetCommandLineFlagInfo(argument.name.c_str(), &flag)) {
    return flag;
  }
  if (argument.name.starts_with("no") && !argument.has_value &&
      gflags::GetCommandLineFlagInfo(argument.name.substr(2).c_str(), &flag) &&
      flag.type == "bool") {
    argument.value = "false";
    argument.has_value = true;
    return flag;
  }
  return InvalidArgument("--", argument.name, ": there is no such flag; ",
                         DidYouMean(argument.name, OwnFlags()),
                         "(see --help=all)");
}

absl::Status ParseAll(const std::vector<std::string>& arguments, int depth,
                      ParsedFlags& parsed) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    MLE_ASSIGN_OR_RETURN(Argument argument, Split(arguments[i]));
    if (argument.name == "h" || argument.name.starts_with("help")) {
      parsed.help = true;
      if (argument.has_value) parsed.help_topic = argument.value;
      if (argument.name == "helpfull") parsed.help_topic = "all";
      continue;
    }
    if (argument.name == "version") {
      parsed.version = true;
      continue;
    }
    MLE_ASSIGN_OR_RETURN(const gflags::CommandLineFlagInfo flag,
                         FindFlag(argument));
    if (!argument.has_value && flag.type == "bool") {
      argument.value = "true";
    } else if (!argument.has_value) {
      if (++i == arguments.size()) {
        return InvalidArgument("--", argument.name, " needs a value: --",
                               argument.name, "=…");
      }
      argument.value = arguments[i];
    }
    if (flag.name == "flagfile") {
      MLE_RETURN_IF_ERROR(ParseFlagFile(argument.value, depth + 1, parsed));
    } else {
      MLE_RETURN_IF_ERROR(SetFlag(flag, argument.value));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ParseFlags(const std::vector<std::string>& arguments,
                        ParsedFlags& parsed) {
  return ParseAll(arguments, 0, parsed);
}

}  // namespace mle
