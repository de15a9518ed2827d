#include <string>

#include "absl/strings/str_cat.h"
#include "mle/data/set_point_windows.h"

namespace mle {
namespace {

using Verdict = QuietPart::Verdict;

bool Any(const SetPointWindow& window, Verdict verdict) {
  for (const std::vector<QuietPart>* parts : {&window.before, &window.after}) {
    for (const QuietPart& part : *parts) {
      if (part.verdict == verdict) return true;
    }
  }
  return false;
}

std::string DescribeChange(const SetPointChange& change, double time,
                           const ProcessModel& channels) {
  if (change.output < 0) return absl::StrCat("a change at ", time);
  return absl::StrCat("set point of '", channels.outputs()[change.output].name,
                      "' from ", change.from, " to ", change.to, " at ", time);
}

void AppendParts(const std::vector<QuietPart>& parts, const char* where,
                 const ProcessModel& channels, std::string& text) {
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const QuietPart& part = parts[i];
    if (part.verdict != Verdict::kDrifting &&
        part.verdict != Verdict::kDisturbed) {
      continue;
    }
    const bool drifts = part.verdict == Verdict::kDrifting;
    absl::StrAppend(&text, "  '", channels.outputs()[i].name,
                    drifts ? "' drifts " : "' is disturbed ", where, ": by ",
                    part.size);
    if (!drifts) absl::StrAppend(&text, " at ", part.time);
    absl::StrAppend(&text, ", its noise being ", part.noise, " (",
                    part.deviations, " standard errors)\n");
  }
}

}  // namespace

bool SetPointWindow::drifting() const { return Any(*this, Verdict::kDrifting); }

bool SetPointWindow::disturbed() const {
  return Any(*this, Verdict::kDisturbed);
}

std::string SetPointWindow::Report(const ProcessModel& channels) const {
  const std::string& unit = channels.time_unit();
  std::string text =
      absl::StrCat(record.start_time, " … ", record.time(record.samples() - 1),
                   " ", unit, ", ", record.samples(), " samples: ");
  for (std::size_t c = 0; c < changes.size(); ++c) {
    if (c > 0) text += ", ";
    text +=
        DescribeChange(changes[c], record.time(changes[c].sample), channels);
  }
  text += '\n';
  if (clipped_before || clipped_after) {
    absl::StrAppend(&text, "  shorter than wanted ",
                    clipped_before && clipped_after ? "on both sides"
                    : clipped_before                ? "before the change"
                                                    : "after the change",
                    ": the record ends or another window is there\n");
  }
  absl::StrAppend(&text, "  operating point (mean of ", operating_point.samples,
                  " samples):");
  for (int i = 0; i < record.num_outputs(); ++i) {
    absl::StrAppend(&text, i > 0 ? ", " : " ", channels.outputs()[i].name, " ",
                    operating_point.outputs(i));
  }
  for (int j = 0; j < record.num_inputs(); ++j) {
    absl::StrAppend(&text, ", ", channels.inputs()[j].name, " ",
                    operating_point.inputs(j));
  }
  text += '\n';
  AppendParts(before, "before the change", channels, text);
  AppendParts(after, "after it has settled", channels, text);
  for (int c = 0; c < bad_share.size(); ++c) {
    if (!(bad_share(c) > 0.0)) continue;
    const int p = record.num_outputs();
    absl::StrAppend(
        &text, "  ", 100.0 * bad_share(c), " % of '",
        c < p ? channels.outputs()[c].name : channels.inputs()[c - p].name,
        "' is bad\n");
  }
  return text;
}

std::vector<Record> WindowSet::Records() const {
  std::vector<Record> records;
  for (const SetPointWindow& window : windows) records.push_back(window.record);
  return records;
}

std::string WindowSet::BriefReport() const {
  int drifting = 0;
  int disturbed = 0;
  int clipped = 0;
  for (const SetPointWindow& window : windows) {
    drifting += window.drifting() ? 1 : 0;
    disturbed += window.disturbed() ? 1 : 0;
    clipped += window.clipped_before || window.clipped_after ? 1 : 0;
  }
  return absl::StrCat(windows.size(), " windows from ", changes,
                      " changes: ", clipped, " clipped, ", drifting,
                      " drifting, ", disturbed, " disturbed");
}

std::string WindowSet::FullReport(const ProcessModel& channels) const {
  std::string text = BriefReport() + "\n";
  for (std::size_t w = 0; w < windows.size(); ++w) {
    absl::StrAppend(&text, "window ", w + 1, ": ", windows[w].Report(channels));
  }
  for (const std::string& warning : warnings) {
    absl::StrAppend(&text, "warning: ", warning, "\n");
  }
  return text;
}

}  // namespace mle
