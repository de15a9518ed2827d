// The command line, read into the flags (gflags) of a command.
//
//   --name=value, --name value, --switch, --noswitch, with one dash or two
//   --flagfile=FILE   a flag a line, written as above; empty lines and
//                     lines that begin with # are skipped; later flags win
//
// gflags' own parser ignores unknown flags in a flag file, so that a misspelled
// flag would silently keep its default, and its messages do not say what would
// be right.
//
//   --help, -h, --help=TOPIC, --version   are noted, and not answered here

#ifndef APPS_COMMON_FLAG_PARSER_H_
#define APPS_COMMON_FLAG_PARSER_H_

#include <string>
#include <vector>

#include "absl/status/status.h"

namespace mle {

// The requests of a command line for help or the version.
struct ParsedFlags {
  bool help = false;
  std::string help_topic;  // of --help=all or --help=window; empty: none
  bool version = false;
};

// Sets the flags named in `arguments` (without the program's name). On an error
// some of them may be set: InvalidArgument names the flag, or the line of the
// flag file, what was found and what would be right.
absl::Status ParseFlags(const std::vector<std::string>& arguments,
                        ParsedFlags& parsed);

}  // namespace mle

#endif  // APPS_COMMON_FLAG_PARSER_H_
