#include <algorithm>
#include <cmath>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/lifecycle/report.h"
#include "apps/report/text.h"

namespace mle::lifecycle {
namespace {

using report::Badge;

// Beyond so many lives nobody runs more of them.
constexpr double kMostLives = 1000.0;

bool IsReal(const PolicySummary& policy) {
  return policy.policy.kind != Policy::Kind::kPerfect;
}

bool Updates(const PolicySummary& policy) {
  return IsReal(policy) && policy.policy.kind != Policy::Kind::kNever;
}

std::string CountOfLives(std::size_t count) {
  return count == 1 ? std::string("one life") : absl::StrCat(count, " lives");
}

// "Leave it" within a sentence.
std::string WithSmallLetter(std::string text) {
  text.front() = absl::ascii_tolower(text.front());
  return text;
}

// The badge of each answer, in their order.
struct AnswerBadge {
  Badge badge;
  const char* label;
};
constexpr AnswerBadge kBadges[] = {
    {Badge::kChanged, "update"},      {Badge::kGood, "leave it"},
    {Badge::kUnknown, "cannot tell"}, {Badge::kUnknown, "no answer"},
    {Badge::kUnknown, "no answer"},   {Badge::kUnknown, "diverged"}};

std::string HeadlineAt(const RateSummary& rate, Answer answer,
                       std::size_t lives) {
  switch (answer) {
    case Answer::kUpdate:
      return Instruction(rate.Cheapest()->policy);
    case Answer::kKeep:
      return "Leave the model as it is: no update saves money";
    case Answer::kCannotTell:
      return absl::StrCat(
          "Whether updating the model pays cannot be told from ",
          CountOfLives(lives));
    case Answer::kNoNever:
      return absl::StrCat("Cheapest of the updates compared: ",
                          ShortName(rate.Cheapest()->policy));
    case Answer::kNoUpdates:
      return "No way of updating the model was compared";
    case Answer::kDiverged:
      break;
  }
  return "The loop diverged under every policy";
}

// "Two lives (--seeds=2) would tell": the interval shrinks as one over the root
// of their number. Empty where that says nothing.
std::string LivesThatWouldTell(const MeanOfSeeds& difference,
                               std::size_t lives) {
  if (lives == 1) return " Several lives (--seeds=5) have intervals.";
  const double ratio = difference.half_width / difference.mean;
  const double needed = std::ceil(static_cast<double>(lives) * ratio * ratio);
  if (!(needed <= kMostLives)) return "";
  return absl::StrCat(" About ", needed, " lives (--seeds=", needed,
                      ") would tell if that difference stays.");
}

// The saving of the cheapest policy against never updating, and its share of
// what a perfect model would save.
std::string SavingSentence(const RateSummary& rate, const std::string& currency,
                           std::size_t lives, Answer answer) {
  const PolicySummary* best = rate.Cheapest();
  const PolicySummary* never = rate.Find(Policy::Kind::kNever);
  if (best == nullptr || never == nullptr || never == best) return "";
  if (never->ran_away > 0) {
    return absl::StrCat("Without updates the loop diverged in ",
                        never->ran_away, " of ", CountOfLives(lives), ".");
  }
  const std::string saved = Money(best->saving, currency);
  if (answer == Answer::kCannotTell) {
    return absl::StrCat(
        "Leave the model as it is for now. The cheapest policy, ",
        ShortName(best->policy), ", saved ", saved,
        " a year against never updating",
        lives > 1 ? ", an interval that holds zero." : ", without an interval.",
        LivesThatWouldTell(best->saving, lives));
  }
  std::string sentence =
      absl::StrCat("That saves ", saved, " a year against never updating");
  if (std::isfinite(best->share_saved)) {
    absl::StrAppend(&sentence, ", ",
                    report::FormatFixed(100.0 * best->share_saved, 0),
                    " % of what a perfect model would save");
  }
  return sentence + ".";
}

// The saving of a perfect model, where no policy that updates was compared.
std::string PossibleSaving(const RateSummary& rate,
                           const std::string& currency) {
  const std::string more = "Add policies that update it to --policies.";
  const PolicySummary* perfect = rate.Find(Policy::Kind::kPerfect);
  if (perfect == nullptr || !std::isfinite(perfect->saving.mean)) return more;
  return absl::StrCat("A perfect model would save ",
                      Money(perfect->saving, currency),
                      " a year against never updating",
                      ToldApart(perfect->saving)
                          ? ". "
                          : ", which cannot be told apart from nothing. ",
                      more);
}

// The updates whose costs may be the same as the cheapest one's.
std::string AsGood(const RateSummary& rate, std::size_t lives) {
  const PolicySummary* best = rate.Cheapest();
  std::vector<std::string> names;
  int others = 0;
  for (const PolicySummary& policy : rate.policies) {
    if (!Updates(policy) || &policy == best) continue;
    ++others;
    if (std::isfinite(policy.over_cheapest.mean) &&
        !ToldApart(policy.over_cheapest)) {
      names.push_back(ShortName(policy.policy));
    }
  }
  if (others == 0 || lives == 1) return "";
  if (!names.empty()) {
    return absl::StrCat("Cannot be told apart from the cheapest: ",
                        absl::StrJoin(names, "; "), ".");
  }
  return others == 1 ? "The other update costs more."
                     : "Every other update costs more.";
}

// In words, of a name as --policies has it.
std::string NameInWords(const RateSummary& rate, const std::string& name) {
  const auto named = std::find_if(
      rate.policies.begin(), rate.policies.end(),
      [&](const PolicySummary& p) { return p.policy.name == name; });
  return named == rate.policies.end() ? name : ShortName(named->policy);
}

std::string BreakEvenSentence(const RateSummary& rate,
                              const std::string& currency) {
  const BreakEven& found = rate.break_even;
  if (found.test.empty()) return "";
  const std::string rivals =
      absl::StrCat(" (", NameInWords(rate, found.test), ", against ",
                   NameInWords(rate, found.correction), ").");
  if (found.price < 0.0) {
    return absl::StrCat(
        "Step tests would not pay even if their hours were free", rivals);
  }
  return absl::StrCat("Step tests pay if an hour of them costs less than ",
                      Money({found.price, NAN}, currency), rivals);
}

std::string OtherRates(const std::vector<RateSummary>& summaries,
                       const RateSummary& nominal, std::size_t lives) {
  std::vector<std::string> answers;
  for (const RateSummary& rate : summaries) {
    if (&rate == &nominal) continue;
    answers.push_back(
        absl::StrCat(rate.rate, ": ",
                     WithSmallLetter(HeadlineAt(rate, AnswerAt(rate), lives))));
  }
  if (answers.empty()) return "";
  return absl::StrCat("At other rates of ageing (1 is the schedule's): at ",
                      absl::StrJoin(answers, "; at "), ".");
}

std::string HowCompared(std::size_t lives, const Valuation& valuation) {
  const std::string years = valuation.years == 1.0
                                ? std::string("a year")
                                : absl::StrCat(valuation.years, " years");
  if (lives == 1) {
    return absl::StrCat("One life of ", years, "; there are no intervals.");
  }
  return absl::StrCat(
      "Means of ", lives, " lives of ", years,
      "; ± is half a 95 % interval. Policies are compared over the same lives: "
      "the same plant, set points, noise and disturbances.");
}

}  // namespace

Answer AnswerAt(const RateSummary& rate) {
  if (std::none_of(rate.policies.begin(), rate.policies.end(), Updates)) {
    return Answer::kNoUpdates;
  }
  const PolicySummary* best = rate.Cheapest();
  if (best == nullptr) return Answer::kDiverged;
  const PolicySummary* never = rate.Find(Policy::Kind::kNever);
  if (never == nullptr) return Answer::kNoNever;
  if (never->ran_away > 0) return Answer::kUpdate;
  if (std::isnan(best->cost.half_width)) return Answer::kCannotTell;
  if (never->over_cheapest.mean == 0.0) return Answer::kKeep;
  return ToldApart(never->over_cheapest) ? Answer::kUpdate
                                         : Answer::kCannotTell;
}

const RateSummary& NominalRate(const std::vector<RateSummary>& summaries) {
  return *std::min_element(summaries.begin(), summaries.end(),
                           [](const RateSummary& a, const RateSummary& b) {
                             return std::abs(a.rate - 1.0) <
                                    std::abs(b.rate - 1.0);
                           });
}

report::Verdict VerdictOf(const Campaign& campaign,
                          const std::vector<RateSummary>& summaries,
                          const Valuation& valuation) {
  const RateSummary& rate = NominalRate(summaries);
  const Answer answer = AnswerAt(rate);
  const std::size_t lives = campaign.seeds.size();
  const auto& [badge, label] = kBadges[static_cast<int>(answer)];
  report::Verdict verdict = {badge, label, HeadlineAt(rate, answer, lives), {}};
  const std::string& currency = valuation.currency;
  if (answer == Answer::kNoUpdates) {
    verdict.sentences = {PossibleSaving(rate, currency)};
  } else {
    verdict.sentences = {SavingSentence(rate, currency, lives, answer),
                         AsGood(rate, lives),
                         BreakEvenSentence(rate, currency)};
  }
  if (answer == Answer::kNoNever) {
    verdict.sentences.emplace_back(
        "Add never to --policies to see whether updating pays.");
  }
  verdict.sentences.push_back(OtherRates(summaries, rate, lives));
  verdict.sentences.push_back(HowCompared(lives, valuation));
  std::erase(verdict.sentences, "");
  return verdict;
}

}  // namespace mle::lifecycle
