// The report of mle_lifecycle on lives: amounts, words, tables, figures, the
// verdict, the page and the files.

#ifndef APPS_LIFECYCLE_REPORT_H_
#define APPS_LIFECYCLE_REPORT_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/command_line.h"
#include "apps/lifecycle/campaign.h"
#include "apps/lifecycle/request.h"
#include "apps/lifecycle/summary.h"
#include "apps/report/drawing.h"
#include "apps/report/html.h"
#include "apps/report/table.h"

namespace mle::lifecycle {

// Amounts of money as they are shown: whole numbers from 100 on, three digits
// below.

// "8,610 ± 1,107 EUR"; the mean alone without an interval, no currency where it
// has no name.
std::string Money(const MeanOfSeeds& amount, const std::string& currency = "");

// ", EUR" for captions and axes; empty without a name.
std::string InCurrency(const std::string& currency);

// The tables of mle_lifecycle.

// The cost of a year under each policy, the cheapest first and the perfect
// model last, and the difference from the cheapest.
report::Table ComparisonTable(const RateSummary& rate, std::size_t lives,
                              const std::string& currency);

// How often each policy acts, and how good its model is; in the order and with
// the names of --policies.
report::Table ActivityTable(const RateSummary& rate);

// Parts of the cost of a year.
report::Table CostTable(const RateSummary& rate, const std::string& currency);

// Policies by rates of ageing: what is saved a year against never. The larger a
// part of the largest saving at that rate, the darker. `never` is among the
// policies, and others too.
report::Table SavingTable(const std::vector<RateSummary>& summaries,
                          const std::string& currency);

// The figures of mle_lifecycle.

inline constexpr char kReferenceLabel[] = "perfect model: the reference";

// The cost of each policy a year at one rate, with its interval: that above the
// perfect model's cost, or the whole cost where there is no perfect model.
report::NamedFigure CostFigure(const RateSummary& rate,
                               const std::string& currency);

// The cost of each policy, and for the first seed cost and model error over
// time, both at the rate nearest to 1.
std::vector<report::NamedFigure> MakeFigures(
    const Campaign& campaign, const Lives& lives,
    const std::vector<RateSummary>& summaries, const Valuation& valuation);

// The advice that follows from the costs of the policies: at the top of the
// page and at the end on the terminal.
//
// Two policies are told apart where the 95 % interval of the difference of
// their costs over the same lives does not hold zero.

enum class Answer {
  kUpdate,      // the cheapest policy updates, and costs less than never
  kKeep,        // never is the cheapest
  kCannotTell,  // one life, or never cannot be told apart from the cheapest
  kNoNever,     // updates were compared without never
  kNoUpdates,   // never and perfect alone
  kDiverged,    // the loop diverged in a life of every policy but perfect
};

Answer AnswerAt(const RateSummary& rate);

// The rate nearest to 1, the ageing as its file has it. `summaries` is not
// empty.
const RateSummary& NominalRate(const std::vector<RateSummary>& summaries);

// Badge, headline and sentences for the nominal rate, with the answers at the
// other rates.
report::Verdict VerdictOf(const Campaign& campaign,
                          const std::vector<RateSummary>& summaries,
                          const Valuation& valuation);

// The files that a life cycle leaves in its folder: result.json, lifecycle.csv,
// the figures and report.html.

struct Results {
  Lives lives;
  std::vector<RateSummary> summaries;
  Valuation valuation;
};

// The results of lives at the prices asked for.
Results Evaluate(const Request& request, Lives lives);

// How the results were asked for: a command or a call, its options, and how the
// page says it.
struct Asked {
  std::string call;
  NamesAndValues options;
  report::RunAgain run_again;
};

// Into the campaign's folder, whose lock is held (run_folder.h), all or none.
absl::Status WriteResults(const Request& request, const Results& results,
                          const Asked& asked);

}  // namespace mle::lifecycle

#endif  // APPS_LIFECYCLE_REPORT_H_
