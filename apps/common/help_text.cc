#include "apps/common/help_text.h"

#include <algorithm>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "apps/common/option_values.h"
#include "apps/report/text.h"
#include "mle/base/absl_view.h"
#include "mle/base/status.h"

namespace mle {
namespace {

constexpr int kLineWidth = 78;
constexpr std::size_t kLongestShown = 30;  // of a default in the short help

// The flags that the parser itself answers.
const std::vector<OptionText>& EveryCommandsOptions() {
  static const auto* const kOptions = new std::vector<OptionText>{
      {.group = "Every command",
       .name = "flagfile",
       .help = "Reads flags from a file, one a line; later ones win."},
      {.group = "Every command",
       .name = "help",
       .help = "The flags most needed; --help=all: all of them; --help=WORD: "
               "those whose names contain the word; --help=man: the manual "
               "page; --help=bash: the completion of bash.",
       .values = {"all", "man", "bash"},
       .is_switch = true},
      {.group = "Every command",
       .name = "version",
       .help = "The version of the program.",
       .is_switch = true}};
  return *kOptions;
}

std::vector<OptionText> AllOptions(const OptionTable& table) {
  std::vector<OptionText> all = table.Texts();
  const std::vector<OptionText>& every = EveryCommandsOptions();
  all.insert(all.end(), every.begin(), every.end());
  return all;
}

// `text` in lines of at most kLineWidth columns, each behind `indent` blanks;
// the first behind `lead` instead, which must not be wider.
std::string Wrapped(std::string_view text, int indent, std::string lead) {
  std::string wrapped;
  std::string line = std::move(lead);
  line.resize(line.size() + static_cast<std::size_t>(std::max(
                                0, indent - report::DisplayWidth(line))),
              ' ');
  bool empty = true;
  for (const absl::string_view word :
       absl::StrSplit(AbslView(text), ' ', absl::SkipEmpty())) {
    const std::string_view added(word.data(), word.size());
    if (!empty && report::DisplayWidth(line) + 1 + report::DisplayWidth(added) >
                      kLineWidth) {
      absl::StrAppend(&wrapped, line, "\n");
      line = std::string(static_cast<std::size_t>(indent), ' ');
      empty = true;
    }
    absl::StrAppend(&line, empty ? "" : " ", word);
    empty = false;
  }
  return absl::StrCat(wrapped, line, "\n");
}

// Up to the first full stop that ends a word.
std::string FirstSentence(const std::string& text) {
  const std::size_t end = text.find(". ");
  return end == std::string::npos ? text : text.substr(0, end + 1);
}

std::string InFull(const OptionText& option) {
  return absl::StrCat("  --", option.name, " [", option.default_text, "]",
                      option.kind.empty() ? "" : " ", option.kind, "\n",
                      Wrapped(option.help, 6, ""));
}

// With a heading where the group changes.
std::string InGroups(const std::vector<OptionText>& options) {
  std::string text;
  std::string group;
  for (const OptionText& option : options) {
    if (option.group != group) {
      group = option.group;
      absl::StrAppend(&text, "\n", group, "\n");
    }
    absl::StrAppend(&text, InFull(option));
  }
  return text;
}

// Text of a manual page: nothing that troff takes for a request.
std::string Troff(std::string_view text) {
  std::string safe =
      absl::StrReplaceAll(AbslView(text), {{"\\", "\\e"}, {"-", "\\-"}});
  return safe.starts_with('.') || safe.starts_with('\'')
             ? absl::StrCat("\\&", safe)
             : safe;
}

// "--name (default x; min, > 0)" and its text.
std::string ManualEntry(const OptionText& option) {
  std::vector<std::string> about;
  if (!option.default_text.empty()) {
    about.push_back(absl::StrCat("default ", option.default_text));
  }
  if (!option.kind.empty()) about.push_back(option.kind);
  const std::string value =
      about.empty() ? "" : absl::StrCat(" (", absl::StrJoin(about, "; "), ")");
  return absl::StrCat(".TP\n\\fB\\-\\-", Troff(option.name), "\\fR",
                      Troff(value), "\n", Troff(option.help), "\n");
}

// The first paragraph of a usage up to its first colon or full stop, with a
// small first letter.
std::string FirstStatement(std::string_view usage) {
  const std::string text = absl::StrReplaceAll(
      AbslView(usage.substr(0, usage.find("\n\n"))), {{"\n", " "}});
  const std::size_t end = text.find_first_of(".:");
  return absl::StrCat(absl::AsciiStrToLower(text.substr(0, 1)),
                      text.substr(1, end == std::string::npos ? end : end - 1));
}

// A word for the shell, without quotes of its own.
std::string Quoted(const std::vector<std::string>& words) {
  return absl::StrCat("\"", absl::StrJoin(words, " "), "\"");
}

}  // namespace

std::string ShortHelp(std::string_view usage, const OptionTable& table) {
  const std::vector<OptionText> first = table.Texts(true);
  std::size_t longest = 0;
  for (const OptionText& option : first) {
    longest = std::max(longest, option.name.size());
  }
  const auto indent = static_cast<int>(longest) + 6;
  std::string text =
      absl::StrCat(AbslView(usage),
                   "\n\nFlags most needed (value in brackets: the default):\n");
  for (const OptionText& option : first) {
    const bool shows = !option.default_text.empty() && !option.is_switch &&
                       option.default_text.size() <= kLongestShown;
    absl::StrAppend(
        &text, Wrapped(absl::StrCat(
                           FirstSentence(option.help), shows ? " [" : "",
                           shows ? option.default_text : "", shows ? "]" : ""),
                       indent, absl::StrCat("  --", option.name)));
  }
  return absl::StrCat(text, "\n--help=all: all ", AllOptions(table).size(),
                      " flags, in groups; --help=", first.front().name,
                      ": those with this word.\n");
}

std::string FullHelp(std::string_view usage, const OptionTable& table) {
  return absl::StrCat(AbslView(usage),
                      "\n\nFlags (value in brackets: the default):\n",
                      InGroups(AllOptions(table)));
}

absl::StatusOr<std::string> HelpOn(const std::string& topic,
                                   const OptionTable& table) {
  std::vector<OptionText> found;
  std::vector<std::string> names;
  for (OptionText& option : AllOptions(table)) {
    names.push_back(option.name);
    if (option.name.find(topic) != std::string::npos) {
      found.push_back(std::move(option));
    }
  }
  if (!found.empty()) return InGroups(found).substr(1);
  return InvalidArgument("--help=", topic, ": ", DidYouMean(topic, names),
                         "no flag has this in its name (see --help=all)");
}

std::string ManualPage(std::string_view command, std::string_view version,
                       std::string_view usage, const OptionTable& table) {
  std::string page = absl::StrCat(
      ".TH ", absl::AsciiStrToUpper(AbslView(command)), " 1 \"\" \"mle ",
      AbslView(version), "\" \"User Commands\"\n.SH NAME\n", Troff(command),
      " \\- ", Troff(FirstStatement(usage)), "\n.SH SYNOPSIS\n.B ",
      Troff(command), "\n.RI [ \\-\\-name=value \\ ...]\n.SH DESCRIPTION\n");
  bool in_example = false;
  for (const absl::string_view line : absl::StrSplit(AbslView(usage), '\n')) {
    const bool example = line.substr(0, 2) == "  ";
    if (example != in_example) page += example ? ".EX\n" : ".EE\n";
    in_example = example;
    absl::StrAppend(
        &page, line.empty() ? ".PP" : Troff({line.data(), line.size()}), "\n");
  }
  if (in_example) page += ".EE\n";
  page += ".SH OPTIONS\n";
  std::string group;
  for (const OptionText& option : AllOptions(table)) {
    if (option.group != group) {
      group = option.group;
      absl::StrAppend(&page, ".SS ", Troff(group), "\n");
    }
    page += ManualEntry(option);
  }
  return page;
}

std::string BashCompletion(std::string_view command, const OptionTable& table) {
  std::vector<std::string> flags;
  std::string cases;
  for (const OptionText& option : AllOptions(table)) {
    flags.push_back(
        absl::StrCat("--", option.name, option.is_switch ? "" : "="));
    if (option.is_switch && option.values.empty()) {
      if (option.group != EveryCommandsOptions().front().group) {
        flags.push_back(absl::StrCat("--no", option.name));
      }
      continue;
    }
    if (option.values.empty()) continue;
    absl::StrAppend(&cases, "    --", option.name,
                    ") words=", Quoted(option.values), " ;;\n");
  }
  return absl::StrReplaceAll(AbslView(CompletionTemplate()),
                             {{"@command@", AbslView(command)},
                              {"@flags@", Quoted(flags)},
                              {"@cases@", cases}});
}

}  // namespace mle
