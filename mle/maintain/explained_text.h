// What explanations are in words. Internal to mle/maintain.

#ifndef MLE_MAINTAIN_EXPLAINED_TEXT_H_
#define MLE_MAINTAIN_EXPLAINED_TEXT_H_

#include <string>

#include "mle/explain/competition.h"
#include "mle/maintain/candidates.h"
#include "mle/model/process_model.h"

namespace mle {

// Sentences, one after the other, or empty: what no corrected model holds of
// output i, and what would settle it; its elements that another output
// contradicts; what explains as much as ageing.
std::string Others(const Candidates& candidates, int i);
std::string Contested(const ProcessModel& model, const Competition& competition,
                      int i);
std::string Ties(const ProcessModel& model, const OutputExplanation& output,
                 int i);

// "its error 3 min ahead is 0.4 after 0.7, simulated …", of blocks held out.
std::string ErrorsText(const OutputExplanation& output,
                       const ProcessModel& model, int i);

}  // namespace mle

#endif  // MLE_MAINTAIN_EXPLAINED_TEXT_H_
