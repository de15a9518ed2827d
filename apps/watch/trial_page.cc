// The trial of a correction in words and as a figure.

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "apps/report/figure.h"
#include "apps/report/text.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"
#include "apps/watch/trial.h"
#include "mle/trial/model_trial.h"

namespace mle::watch {
namespace {

constexpr double kLn10 = 2.302585092994046;

void AddHistory(const TrialVerdict& verdict, double seconds_per_unit,
                std::vector<TrialReport::Point>& history) {
  for (const TrialEvidencePoint& point : verdict.evidence) {
    history.push_back({.day = point.time * seconds_per_unit / kSecondsOfDay,
                       .log10_for = point.log_for / kLn10,
                       .log10_against = point.log_against / kLn10});
  }
}

// "0.31", "12", "2.4e+08".
std::string EvidenceText(double log) {
  const double value = std::exp(log);
  if (value < 0.01) return "less than 0.01";
  return value < 1000.0 ? absl::StrFormat("%.2g", value)
                        : absl::StrFormat("%.0e", value);
}

std::string SeenText(const TrialVerdict& verdict) {
  return absl::StrCat(
      Counted(verdict.changes, "change"), " of set points",
      verdict.not_judged > 0
          ? absl::StrCat(" (", verdict.not_judged, " of ", verdict.responses,
                         " responses could not be judged yet)")
          : "");
}

std::string LeftText(const TrialVerdict& verdict) {
  return absl::StrFormat(
      "%.0f %%", 100.0 * std::max(verdict.left_share, verdict.left_before));
}

bool IsBetter(const TrialReport& report) {
  return !report.verdict.evidence.empty() &&
         report.verdict.evidence.back().log_for >= -std::log(report.level);
}

std::string WhyDropped(const TrialReport& report) {
  return IsBetter(report)
             ? absl::StrCat("It is better than the model in use, but leaves ",
                            LeftText(report.verdict),
                            " of what set points drive of its errors: a "
                            "correction from the new records will be nearer.")
             : "It does not predict the responses to set points better than "
               "the model in use.";
}

// "since 2026-02-04, by Ann at 2026-02-03 09:30 UTC: loaded at ten".
std::string AdoptedText(const Acknowledgement& adopted, int day) {
  return absl::StrCat(
      "since ", NameOfDay(day), ", by ", adopted.who,
      adopted.at > 0 ? absl::StrCat(" at ", TimeText(adopted.at)) : "",
      adopted.note.empty() ? "" : ": ", adopted.note);
}

std::string BeforeText(const Trial& trial) {
  const std::string ended = absl::StrReplaceAll(trial.ended, {{"_", " "}});
  return absl::StrCat(
      "Correction of ", NameOfDay(trial.day), ": ",
      ended.empty() ? "not decided" : ended,
      trial.adopted.has_value()
          ? absl::StrCat("; in use ",
                         AdoptedText(*trial.adopted, trial.adopted_day))
          : "",
      ".");
}

std::string Limit(const TrialReport& report) {
  return absl::StrFormat("%.0f", 1.0 / report.level);
}

// "100 with a probability of at most 1 %".
std::string ErrorText(const TrialReport& report) {
  return absl::StrCat(Limit(report), " with a probability of at most ",
                      absl::StrFormat("%g", 100.0 * report.level), " %");
}

std::vector<std::string> WaitingSentences(const TrialReport& report,
                                          const std::string& correction,
                                          const std::string& seen,
                                          const std::string& evidence) {
  if (report.verdict.responses == 0 && !report.fault.empty()) {
    return {absl::StrCat("Wait: ", correction, " is not on trial yet."),
            report.fault};
  }
  std::string sentence =
      absl::StrCat("After ", seen, " the evidence for it is ", evidence, " of ",
                   Limit(report), ".");
  if (IsBetter(report)) {
    absl::StrAppend(&sentence, " It leaves ", LeftText(report.verdict),
                    " of what set points drive of the errors of the model in "
                    "use; to adopt it, that has to be less.");
  }
  return {absl::StrCat("Wait: it is not known yet whether ", correction,
                       " is better than the model in use."),
          sentence};
}

report::Figure EvidenceFigure(const TrialReport& report) {
  report::Figure figure{.height_cm = 6.0};
  report::Panel& panel = figure.AddPanel("");
  panel.x = DayAxis();
  panel.y = {.label = "evidence, powers of ten"};
  report::Series better = report::MakeSeries(report::Role::kCorrected,
                                             "for the other model", {}, {});
  report::Series worse =
      report::MakeSeries(report::Role::kInitial, "against it", {}, {});
  for (const TrialReport::Point& point : report.history) {
    better.x.push_back(point.day);
    better.y.push_back(std::max(point.log10_for, -3.0));
    worse.x.push_back(point.day);
    worse.y.push_back(-std::max(point.log10_against, -3.0));
  }
  panel.series = {std::move(better), std::move(worse)};
  const double limit = -std::log10(report.level);
  panel.lines = {
      report::HorizontalLine(report::Role::kReference, "adopt, roll back",
                             limit),
      report::HorizontalLine(report::Role::kReference, "drop", -limit)};
  if (report.adopted.has_value()) {
    panel.lines.push_back(report::VerticalLine(
        report::Role::kChosen, "in use from here on", report.adopted_day));
  }
  return figure;
}

}  // namespace

std::optional<TrialReport> MakeTrialReport(const Watch& watch,
                                           double seconds_per_unit) {
  if (watch.trials.empty()) return std::nullopt;
  const Trial& trial = watch.trials.back();
  const TrialOptions options;
  TrialReport report = {.day = trial.day,
                        .last_day = trial.last_day,
                        .level = options.level,
                        .verdict = JudgeTrial(trial.state, options),
                        .loss_ratio = LossRatio(trial.state.losses),
                        .ended = trial.ended,
                        .fault = trial.fault,
                        .adopted = trial.adopted,
                        .adopted_day = trial.adopted_day};
  AddHistory(JudgeResponses(trial.state.before, {}, false, options),
             seconds_per_unit, report.history);
  AddHistory(report.verdict, seconds_per_unit, report.history);
  for (std::size_t k = 0; k + 1 < watch.trials.size(); ++k) {
    report.before.push_back(BeforeText(watch.trials[k]));
  }
  return report;
}

std::vector<std::string> TrialSentences(const TrialReport& report) {
  const TrialVerdict& verdict = report.verdict;
  const std::string correction =
      absl::StrCat("the correction of ", NameOfDay(report.day));
  const double log_for =
      verdict.evidence.empty() ? 0.0 : verdict.evidence.back().log_for;
  const std::string evidence = EvidenceText(log_for);
  const std::string seen = SeenText(verdict);
  if (report.ended == "replaced" || report.ended == "rolled_back") {
    return {absl::StrCat("Nothing to do: ",
                         report.ended == "replaced" ? "another" : "the former",
                         " model is in use in place of ", correction, "."),
            "The trial has ended."};
  }
  switch (verdict.advice) {
    case TrialAdvice::kAdopt:
      return {absl::StrCat("Adopt ", correction, "."),
              absl::StrCat("After ", seen, " the evidence for it is ", evidence,
                           "; a model that is no better would ever reach ",
                           ErrorText(report), ". It leaves ", LeftText(verdict),
                           " of what set points drive of the errors of the "
                           "model in use. Acknowledge the alarm once it is in "
                           "use.")};
    case TrialAdvice::kDrop:
      return {absl::StrCat("Drop ", correction, "."),
              absl::StrCat(WhyDropped(report), " This rests on ", seen, ".")};
    case TrialAdvice::kRollBack:
      return {absl::StrCat("Roll back to the model before ", correction, "."),
              absl::StrCat("Since ", NameOfDay(report.adopted_day), ", after ",
                           seen,
                           ", the evidence that the former model is "
                           "better is ",
                           evidence, "; if it were not, it would ever reach ",
                           ErrorText(report),
                           ". Find out why, with the records since.")};
    case TrialAdvice::kKeep:
      return {absl::StrCat("Keep ", correction, "."),
              absl::StrCat("In use since ", NameOfDay(report.adopted_day),
                           "; after ", seen,
                           " the evidence that the former model is better is ",
                           evidence, " of ", Limit(report), ".")};
    case TrialAdvice::kWait:
      break;
  }
  return WaitingSentences(report, correction, seen, evidence);
}

std::string ShortTrial(const std::optional<TrialReport>& report) {
  if (!report.has_value()) return "–";
  if (report->IsOver() && report->ended != "dropped") return "ended";
  constexpr const char* kWords[] = {"wait", "adopt", "drop", "keep",
                                    "roll back"};
  return kWords[static_cast<int>(report->verdict.advice)];
}

void AddTrial(const TrialReport& report, report::HtmlPage& page) {
  page.AddHeading("Trial of the correction");
  for (const std::string& sentence : TrialSentences(report)) {
    page.AddParagraph(sentence);
  }
  std::vector<std::pair<std::string, std::string>> terms = {
      {"Correction", absl::StrCat("of ", NameOfDay(report.day))},
      {"Last day", NameOfDay(report.last_day)},
      {"Changes of set points", SeenText(report.verdict)}};
  if (report.adopted.has_value()) {
    terms.emplace_back("In use",
                       AdoptedText(*report.adopted, report.adopted_day));
  }
  terms.emplace_back(
      "Errors several steps ahead",
      absl::StrFormat(
          "those of the model that is not in use are %.2f times those of the "
          "one that is, on all records since; controllers that answer "
          "disturbances "
          "are part of this, so that nothing rests on it",
          report.loss_ratio));
  if (!report.fault.empty()) terms.emplace_back("Left out", report.fault);
  page.AddTerms(terms);
  if (!report.history.empty()) {
    page.AddFigure(EvidenceFigure(report),
                   "Evidence after each response to set points: for the model "
                   "that is not in use, upwards, against it, downwards.",
                   "Two curves over dates, with lines at the limits where the "
                   "advice is to adopt or roll back, and to drop.");
  }
  if (report.before.empty()) return;
  page.OpenFold("Trials before");
  for (const std::string& sentence : report.before) page.AddParagraph(sentence);
  page.CloseFold();
}

}  // namespace mle::watch
