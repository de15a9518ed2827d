// The figures of a campaign.

#ifndef APPS_STUDY_FIGURES_H_
#define APPS_STUDY_FIGURES_H_

#include <vector>

#include "apps/report/drawing.h"
#include "apps/study/campaign.h"
#include "apps/study/summary.h"

namespace mle::study {

// Scenarios have a panel each, the first kMaxPanels of them, and methods a
// curve:
//   E over the axis of numbers that has the most values, where one has three
//   how E is distributed over the seeds
//   λ chosen over the best λ
//   how far E is above that of the best λ
// What a campaign has no values for is left out.
inline constexpr int kMaxPanels = 6;
std::vector<report::NamedFigure> MakeFigures(
    const experiment::Campaign& campaign, const StudySummary& summary);

}  // namespace mle::study

#endif  // APPS_STUDY_FIGURES_H_
