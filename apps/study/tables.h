// The tables of mle_study: of methods, and with a row for each cell.

#ifndef APPS_STUDY_TABLES_H_
#define APPS_STUDY_TABLES_H_

#include <cstddef>

#include "apps/report/table.h"
#include "apps/study/campaign.h"
#include "apps/study/summary.h"

namespace mle::study {

// The cells of a table: `most` of them from the `first` on.
struct Rows {
  std::size_t first = 0;
  std::size_t most = 0;
};

// In how many scenarios each method ends closer to the plant.
report::Table MethodTable(const experiment::Campaign& campaign,
                          const StudySummary& summary);

// E before and after.
report::Table ErrorTable(const experiment::Campaign& campaign,
                         const StudySummary& summary, Rows rows);
// Mean and extremes of E.
report::Table MeanTable(const experiment::Campaign& campaign,
                        const StudySummary& summary, Rows rows);
// λ chosen and best.
report::Table LambdaTable(const experiment::Campaign& campaign,
                          const StudySummary& summary, Rows rows);
// Gains and dead times.
report::Table ElementTable(const experiment::Campaign& campaign,
                           const StudySummary& summary, Rows rows);

// How often each failure occurred.
report::Table FailureTable(const StudySummary& summary);

}  // namespace mle::study

#endif  // APPS_STUDY_TABLES_H_
