// A file of tags, the proposal of one for an export, and the import of a long
// table by it.

#include <cmath>
#include <set>

#include "mle/data/historian.h"
#include "mle/data/tag_file.h"
#include "tests/fuzz/fuzz.h"
#include "tests/fuzz/tank.h"

namespace mle {
namespace {

constexpr std::int64_t kMaxSamples = 2000;

void CheckTags(const std::vector<TagMapping>& tags) {
  std::set<std::string> channels;
  for (const TagMapping& tag : tags) {
    FUZZ_EXPECT(channels.insert(tag.channel).second, tag.channel);
    FUZZ_EXPECT(!tag.tag.empty());
    FUZZ_EXPECT(std::isfinite(tag.scale) && tag.scale != 0.0);
    FUZZ_EXPECT(std::isfinite(tag.offset));
  }
}

}  // namespace
}  // namespace mle

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  mle::fuzz::Bytes bytes(data, size);
  const std::string text(bytes.Until("\n====\n"));
  const mle::ProcessModel& tank = mle::fuzz::Tank();
  const auto tags = mle::ParseTagFile("tags.csv", text, tank);
  mle::HistorianOptions options;
  options.max_samples = mle::kMaxSamples;
  if (tags.ok()) {
    mle::CheckTags(tags->tags);
    options.columns.tags = tags->tags;
    options.columns.unused_tags = tags->unused;
  } else {
    FUZZ_EXPECT(tags.status().message().find("tags.csv") != std::string::npos,
                tags.status().ToString());
  }
  const std::vector<mle::HistorianSource> sources = {
      mle::TextSource("export.csv", std::string(bytes.Rest()))};
  const auto import = mle::ImportHistorianSources(sources, tank, options);
  FUZZ_EXPECT(import.ok() || !import.status().message().empty());
  const auto proposals = mle::ProposeTags(sources, tank, options);
  if (!proposals.ok()) return 0;
  // What is proposed is a file of tags.
  const std::string proposed = mle::FormatTagFile(*proposals);
  const auto again = mle::ParseTagFile("proposed.csv", proposed, tank);
  if (again.ok()) mle::CheckTags(again->tags);
  return 0;
}
