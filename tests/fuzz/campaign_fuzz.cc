// A campaign's JSON: an error that names its file, or a grid whose runs can be
// counted and are dealt out once each. Files that it names lie in no folder.

#include <cmath>
#include <cstdint>

#include "apps/experiment/campaign_json.h"
#include "apps/experiment/grid.h"
#include "tests/fuzz/fuzz.h"

namespace mle::experiment {
namespace {

void CheckGrid(const Campaign& campaign) {
  FUZZ_EXPECT(!campaign.seeds.empty() && !campaign.methods.empty());
  FUZZ_EXPECT(campaign.settings.correction.lambdas.allFinite());
  FUZZ_EXPECT(std::isfinite(campaign.settings.sample_time) &&
              campaign.settings.sample_time > 0.0);
  const Grid grid(campaign);
  if (!grid.IsCountable() || grid.num_runs() > 2000) return;
  std::int64_t runs = 0;
  for (std::int64_t unit = 0; unit < grid.num_units(); ++unit) {
    for (const std::int64_t run : grid.RunsOf(unit)) {
      FUZZ_EXPECT(run >= 0 && run < grid.num_runs());
      ++runs;
    }
  }
  FUZZ_EXPECT(runs == grid.num_runs());
}

}  // namespace
}  // namespace mle::experiment

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  const std::string_view text = mle::fuzz::Bytes(data, size).Rest();
  const auto resolved =
      mle::experiment::ResolveCampaign(text, "fuzz.json", "/nonexistent");
  if (!resolved.ok()) {
    FUZZ_EXPECT(
        resolved.status().message().find("fuzz.json") != std::string_view::npos,
        resolved.status().ToString());
    return 0;
  }
  const auto campaign = mle::experiment::ParseCampaign(*resolved, "fuzz.json");
  if (!campaign.ok()) {
    FUZZ_EXPECT(
        campaign.status().message().find("fuzz.json") != std::string_view::npos,
        campaign.status().ToString());
    return 0;
  }
  mle::experiment::CheckGrid(*campaign);
  return 0;
}
