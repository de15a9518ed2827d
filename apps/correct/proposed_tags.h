// The text that --propose_tags prints beside the file that it writes.

#ifndef APPS_CORRECT_PROPOSED_TAGS_H_
#define APPS_CORRECT_PROPOSED_TAGS_H_

#include <string>
#include <vector>

#include "mle/data/tag_file.h"
#include "mle/model/process_model.h"

namespace mle::correct {

// Lines: what was proposed in the file `path`, the channels that still need a
// column, what there is of set points, and the flag that reads the file.
std::string DescribeProposals(const std::vector<TagProposal>& proposals,
                              const ProcessModel& model,
                              const std::string& path);

}  // namespace mle::correct

#endif  // APPS_CORRECT_PROPOSED_TAGS_H_
