#include "apps/watch/proposal.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/time/time.h"
#include "apps/common/option_table.h"
#include "apps/report/process.h"
#include "apps/watch/days.h"
#include "apps/watch/source.h"
#include "mle/base/file.h"
#include "nlohmann/json.hpp"

namespace mle::watch {
namespace {

constexpr int kMostDays = 60;
constexpr int kAgainAfter = 14;
constexpr absl::Duration kLongest = absl::Hours(1);

std::string CommandBesideThis() {
  std::error_code error;
  const std::filesystem::path self =
      std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? "mle_correct" : (self.parent_path() / "mle_correct").string();
}

std::vector<std::string> ArgumentsFor(const Controller& controller,
                                      const std::vector<std::string>& files,
                                      int from, const std::string& out) {
  std::vector<std::string> arguments = {
      absl::StrCat("--model=", controller.model),
      absl::StrCat("--data=", absl::StrJoin(files, ",")),
      absl::StrCat("--out=", out),
      absl::StrCat("--begin=", NameOfDay(from)),
      "--ignore_other_columns",
      "--any_word_is_bad",
      "--skip_repeated_times",
      "--threads=1"};
  if (!controller.tag_file.empty()) {
    arguments.push_back(absl::StrCat("--tag_file=", controller.tag_file));
  }
  if (!controller.time_zone.empty()) {
    arguments.push_back(absl::StrCat("--time_zone=", controller.time_zone));
  }
  if (controller.sample_time > 0.0) {
    arguments.push_back(
        absl::StrCat("--sample_time=", ReadableNumber(controller.sample_time)));
  }
  return arguments;
}

// What result.json says.
void ReadConclusion(Proposal& proposal) {
  const absl::StatusOr<std::string> text =
      ReadFile(absl::StrCat(proposal.folder, "/result.json"));
  if (!text.ok()) return;
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("decision") ||
      !json["decision"].is_string()) {
    return;
  }
  proposal.decision = json["decision"].get<std::string>();
  proposal.conclusion.clear();
  if (!json.contains("verdict") || !json["verdict"].is_array()) return;
  for (const auto& sentence : json["verdict"]) {
    if (!sentence.is_string()) continue;
    if (!proposal.conclusion.empty()) proposal.conclusion += " ";
    proposal.conclusion += sentence.get<std::string>();
  }
}

}  // namespace

bool NeedsProposal(const Watch& watch) {
  if (watch.alarms.empty()) return false;
  if (watch.proposals.empty()) return true;
  const Proposal& last = watch.proposals.back();
  return last.decision != "corrected" &&
         watch.last_day() >= last.day + kAgainAfter;
}

void MakeProposal(const Controller& controller, const std::string& folder,
                  Watch& watch) {
  const int day = watch.last_day();
  Proposal proposal{.day = day, .decision = "failed"};
  proposal.folder = absl::StrCat(folder, "/", FileNameOf(controller.name), "/",
                                 NameOfDay(day));
  // Not of a time before the change: a plant that changes within the records
  // has no one model.
  int from = day - kMostDays;
  for (const Alarm& alarm : watch.alarms) from = std::max(from, alarm.began);
  const std::vector<std::string> files =
      FilesBetween(watch, from * kSecondsOfDay, (day + 1) * kSecondsOfDay);
  if (const absl::Status status = MakeWritableFolder(proposal.folder);
      !status.ok()) {
    proposal.conclusion = std::string(status.message());
  } else {
    const absl::StatusOr<report::ProcessResult> run = report::RunProcess(
        CommandBesideThis(),
        ArgumentsFor(controller, files, from, proposal.folder), "",
        {.time_limit = kLongest});
    proposal.conclusion =
        run.ok() ? std::string(absl::StripAsciiWhitespace(run->err))
                 : std::string(run.status().message());
    if (run.ok() && run->exit_code <= 1) ReadConclusion(proposal);
  }
  watch.proposals.push_back(std::move(proposal));
}

std::string FileNameOf(const std::string& controller) {
  std::string name;
  for (const char c : controller) {
    const auto byte = static_cast<unsigned char>(c);
    if (absl::ascii_isalnum(byte) || c == '-') {
      name += c;
    } else {
      absl::StrAppendFormat(&name, "_%02x", byte);
    }
  }
  return name;
}

}  // namespace mle::watch
