#include "apps/correct/proposed_tags.h"

#include <set>

#include "absl/strings/str_cat.h"
#include "mle/data/nearest_names.h"
#include "mle/data/record_columns.h"

namespace mle::correct {
namespace {

// The channels of these names that no column is proposed for.
std::vector<std::string> WithoutColumn(
    const std::vector<std::string>& channels,
    const std::vector<TagProposal>& proposals) {
  std::set<std::string> proposed;
  for (const TagProposal& proposal : proposals) {
    proposed.insert(proposal.channel);
  }
  std::vector<std::string> missing;
  for (const std::string& channel : channels) {
    if (!proposed.contains(channel)) missing.push_back(channel);
  }
  return missing;
}

std::string OnSetPoints(const std::vector<std::string>& set_points,
                        const std::vector<TagProposal>& proposals) {
  const std::vector<std::string> missing = WithoutColumn(set_points, proposals);
  if (missing.empty()) return "";
  std::vector<std::string> likely;
  for (const TagProposal& proposal : proposals) {
    if (proposal.channel.empty() && IsSetPointTag(proposal.tag)) {
      likely.push_back(proposal.tag);
    }
  }
  if (!likely.empty()) {
    return absl::StrCat("Set points are probably ", ListOfNames(likely),
                        "; their channels are ", ListOfNames(missing), ".\n");
  }
  if (missing.size() < set_points.size()) return "";
  return absl::StrCat(
      "No column looks like a set point. If one is, its channel is among ",
      ListOfNames(missing),
      "; if none is, --change_times names when set points were changed.\n");
}

}  // namespace

std::string DescribeProposals(const std::vector<TagProposal>& proposals,
                              const ProcessModel& model,
                              const std::string& path) {
  std::vector<std::string> needed;
  std::vector<std::string> set_points;
  for (const OutputChannel& output : model.outputs()) {
    needed.push_back(output.name);
    set_points.push_back(SetPointName(output.name));
  }
  for (const InputChannel& input : model.inputs()) {
    needed.push_back(input.name);
  }
  std::size_t mapped = 0;
  for (const TagProposal& proposal : proposals) {
    if (!proposal.channel.empty()) ++mapped;
  }
  const std::vector<std::string> missing = WithoutColumn(needed, proposals);
  return absl::StrCat(
      path, ": a channel is proposed for ", mapped, " of ", proposals.size(),
      " columns. Check each line; scale and offset convert units",
      mapped < proposals.size()
          ? ", and a column without a channel is ignored.\n"
          : ".\n",
      missing.empty()
          ? ""
          : absl::StrCat(
                "Write into the column channel: ", ListOfNames(missing), ".\n"),
      OnSetPoints(set_points, proposals), "Then use it: --tag_file=", path,
      "\n");
}

}  // namespace mle::correct
