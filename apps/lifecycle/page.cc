#include "apps/lifecycle/page.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "apps/report/number.h"

namespace mle::lifecycle {
namespace {

using report::Align;
using report::FormatFixed;
using report::FormatSignificant;
using report::Table;

std::string Money(double value) {
  if (!std::isfinite(value)) return "–";
  return std::abs(value) < 100.0 ? FormatSignificant(value)
                                 : FormatSignificant(std::round(value), 3);
}

std::string WithInterval(const MeanOfSeeds& value) {
  if (!std::isfinite(value.half_width)) return Money(value.mean);
  return absl::StrCat(Money(value.mean), " ± ", Money(value.half_width));
}

std::string Percent(double share) {
  return std::isfinite(share) ? FormatFixed(100.0 * share, 0) + " %" : "–";
}

std::string RateTitle(const RateSummary& rate) {
  return absl::StrCat("Ageing rate ", rate.rate);
}

std::string BreakEvenSentence(const BreakEven& break_even) {
  if (break_even.test.empty()) return "";
  const std::string rivals =
      absl::StrCat(break_even.test, " against ", break_even.correction);
  if (break_even.price < 0.0) {
    return absl::StrCat(
        " Step tests would not pay even if their hours were "
        "free (",
        rivals, ").");
  }
  return absl::StrCat(
      " Step tests are cheaper if an hour of them costs less than ",
      Money(break_even.price), " (", rivals, ").");
}

}  // namespace

std::vector<std::string> Findings(const Campaign& campaign,
                                  const std::vector<RateSummary>& summaries) {
  std::vector<std::string> sentences;
  for (const RateSummary& rate : summaries) {
    const PolicySummary* cheapest = rate.Cheapest();
    if (cheapest == nullptr) {
      sentences.push_back(absl::StrCat(
          RateTitle(rate), ": the loop diverged under every policy."));
      continue;
    }
    std::string sentence = absl::StrCat(
        RateTitle(rate), ": ", cheapest->policy.name, " is cheapest, at ",
        WithInterval(cheapest->cost), " a year");
    const PolicySummary* never = rate.Find(Policy::Kind::kNever);
    if (never != nullptr && never != cheapest) {
      absl::StrAppend(&sentence, "; never updating costs ",
                      WithInterval(cheapest->saving), " more");
      if (cheapest->saving.mean <= cheapest->saving.half_width) {
        absl::StrAppend(&sentence,
                        ", which is not significant with these seeds");
      }
      const PolicySummary* perfect = rate.Find(Policy::Kind::kPerfect);
      if (perfect != nullptr && std::isfinite(cheapest->share_saved)) {
        absl::StrAppend(&sentence, "; a perfect model would save ",
                        Money(never->cost.mean - perfect->cost.mean));
      }
    }
    sentences.push_back(
        absl::StrCat(sentence, ".", BreakEvenSentence(rate.break_even)));
  }
  const std::size_t seeds = campaign.seeds.size();
  sentences.push_back(absl::StrCat(
      "Means of ", seeds, seeds == 1 ? " seed" : " seeds",
      seeds == 1 ? "; with one seed there are no intervals."
                 : " with 95 % intervals; savings are compared seed by seed."));
  return sentences;
}

Table PolicyTable(const RateSummary& rate) {
  Table table{.caption = absl::StrCat(RateTitle(rate),
                                      ": what each policy costs and does"),
              .columns = {{"policy", Align::kLeft},
                          {"cost a year"},
                          {"saving against never"},
                          {"share of possible saving"},
                          {"updates"},
                          {"refused"},
                          {"reverted"},
                          {"no change found"},
                          {"step tests"},
                          {"mean E"},
                          {"mean gain error"},
                          {"mean dead-time error"}}};
  for (const PolicySummary& policy : rate.policies) {
    std::vector<std::string> cells = {policy.policy.name};
    if (policy.ran_away > 0) {
      cells.push_back(
          absl::StrCat("the loop diverged in ", policy.ran_away, " lives"));
    } else {
      cells.push_back(WithInterval(policy.cost));
    }
    cells.push_back(policy.policy.kind == Policy::Kind::kNever
                        ? "–"
                        : WithInterval(policy.saving));
    cells.push_back(policy.policy.kind == Policy::Kind::kNever
                        ? "–"
                        : Percent(policy.share_saved));
    cells.push_back(FormatFixed(policy.updates, 1));
    cells.push_back(FormatFixed(policy.refusals, 1));
    cells.push_back(FormatFixed(policy.reverted, 1));
    cells.push_back(FormatFixed(policy.unchanged, 1));
    cells.push_back(FormatFixed(policy.tests, 1));
    cells.push_back(FormatSignificant(policy.distance));
    cells.push_back(Percent(policy.gain_error));
    cells.push_back(FormatSignificant(policy.delay_error));
    table.AddRow(std::move(cells));
  }
  return table;
}

Table CostTable(const RateSummary& rate) {
  Table table{
      .caption = absl::StrCat(RateTitle(rate), ": parts of the cost of a year"),
      .columns = {{"policy", Align::kLeft},
                  {"off set point"},
                  {"beyond limits"},
                  {"input moves"},
                  {"hours of step test"},
                  {"engineers"},
                  {"all"}}};
  for (const PolicySummary& policy : rate.policies) {
    const Cost& parts = policy.parts;
    table.AddRow({policy.policy.name, Money(parts.product),
                  Money(parts.violation), Money(parts.movement),
                  Money(parts.test_hours), Money(parts.engineering),
                  Money(parts.total())});
  }
  return table;
}

Table SavingTable(const std::vector<RateSummary>& summaries) {
  Table table{.caption =
                  "Share of the avoidable cost (never less perfect) that each "
                  "policy saves, by rate of ageing; negative: the policy costs "
                  "more than never",
              .columns = {{"policy", Align::kLeft}}};
  for (const RateSummary& rate : summaries) {
    table.columns.push_back({absl::StrCat("rate ", rate.rate)});
  }
  for (std::size_t p = 0; p < summaries.front().policies.size(); ++p) {
    const Policy& policy = summaries.front().policies[p].policy;
    if (policy.kind == Policy::Kind::kNever ||
        policy.kind == Policy::Kind::kPerfect) {
      continue;
    }
    std::vector<std::string> cells = {policy.name};
    for (const RateSummary& rate : summaries) {
      cells.push_back(Percent(rate.policies[p].share_saved));
    }
    table.AddRow(std::move(cells));
  }
  return table;
}

std::string FormatPage(const Campaign& campaign,
                       const std::vector<RateSummary>& summaries,
                       const std::vector<report::DrawnFigure>& figures,
                       const report::RunAgain& run_again) {
  report::HtmlPage page(
      absl::StrCat("The life of a model: ", campaign.model.name()));
  page.AddSummary(Findings(campaign, summaries));
  for (const RateSummary& rate : summaries) {
    for (const PolicySummary& policy : rate.policies) {
      if (policy.ran_away == 0) continue;
      page.AddWarning(absl::StrCat(RateTitle(rate), ", ", policy.policy.name,
                                   ": the loop diverged in ", policy.ran_away,
                                   " lives; its cost is not known."));
    }
  }
  if (!figures.empty()) page.AddHeading("Figures");
  for (const report::DrawnFigure& figure : figures) {
    report::AddFigure(figures, figure.named.name, page);
  }
  page.AddHeading("Policies");
  page.AddParagraph(
      "All policies have the same plant, set points, noise and disturbances. "
      "Mean errors are of the model in use at each set-point "
      "change: squared distance E of its step responses from the plant's, its "
      "largest relative gain error and its largest dead-time error. Updates, "
      "refusals and step tests are counted over a whole life.");
  if (summaries.size() > 1) page.AddTable(SavingTable(summaries));
  for (const RateSummary& rate : summaries) page.AddTable(PolicyTable(rate));
  page.AddHeading("Cost");
  page.AddParagraph(
      "Deviations from the set points and beyond limits are those of the true "
      "outputs, without measurement noise, including the quiet times between "
      "changes. The price of the hours of a step test is added to the cost of "
      "the product made in them.");
  for (const RateSummary& rate : summaries) page.AddTable(CostTable(rate));
  page.AddHeading("Files");
  page.AddFiles(
      {{"result.json", "result.json"}, {"lifecycle.csv", "lifecycle.csv"}});
  page.AddRunAgain(run_again);
  return page.Render();
}

}  // namespace mle::lifecycle
