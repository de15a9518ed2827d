#include "apps/lifecycle/campaign.h"

#include <atomic>
#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "apps/experiment/run_folder.h"
#include "mle/base/status.h"
#include "mle/base/version.h"

namespace mle::lifecycle {
namespace {

using experiment::JournalHead;
using experiment::RunFolder;
using experiment::Work;

absl::StatusOr<Scenario> MakeScenario(const Campaign& campaign, double rate,
                                      std::uint64_t seed) {
  Scenario scenario;
  scenario.model = campaign.model;
  scenario.plant = campaign.plant;
  MLE_ASSIGN_OR_RETURN(scenario.ageing,
                       sim::ScaleAgeing(campaign.ageing, rate));
  MLE_RETURN_IF_ERROR(scenario.ageing.Validate(scenario.plant));
  scenario.events = DrawSetPointEvents(campaign.set_points, seed);
  scenario.seed = seed;
  return scenario;
}

// An error in what the run would have shown as its place.
absl::Status At(const LifeKey& key, const absl::Status& status) {
  return absl::Status(
      status.code(),
      absl::StrCat("policy ", key.policy, ", ageing rate ", key.ageing_rate,
                   ", seed ", key.seed, ": ", status.message()));
}

// Lives by number: rate by rate, seed by seed, policy by policy.
struct Place {
  std::size_t rate = 0;
  std::size_t seed = 0;
  std::size_t policy = 0;
};

Place PlaceOfRun(const Campaign& campaign, std::int64_t run) {
  const std::size_t policies = campaign.policies.size();
  const std::size_t seeds = campaign.seeds.size();
  const auto number = static_cast<std::size_t>(run);
  return {number / policies / seeds, number / policies % seeds,
          number % policies};
}

LifeKey KeyOf(const Campaign& campaign, const Place& place) {
  return {campaign.policies[place.policy].name, campaign.rates[place.rate],
          campaign.seeds[place.seed]};
}

absl::StatusOr<Life> Live(const Campaign& campaign, const Place& place,
                          const std::atomic<bool>& stop) {
  const LifeKey key = KeyOf(campaign, place);
  MLE_ASSIGN_OR_RETURN(const Scenario scenario,
                       MakeScenario(campaign, key.ageing_rate, key.seed));
  return LiveThrough(scenario, campaign.policies[place.policy], campaign.life,
                     [&stop] { return stop.load(); });
}

}  // namespace

Work WorkOf(const Campaign& campaign) {
  Work work;
  work.file = "journal.txt";
  work.head.first_line = absl::StrCat("# mle_lifecycle journal 3, mle ",
                                      std::string(LibraryVersion()));
  work.head.runs = work.units = static_cast<std::int64_t>(
      campaign.rates.size() * campaign.seeds.size() * campaign.policies.size());
  std::map<std::string, std::int64_t> runs;
  std::vector<std::string> starts;
  for (std::int64_t run = 0; run < work.units; ++run) {
    starts.push_back(KeyOf(campaign, PlaceOfRun(campaign, run))
                         .LineStart(campaign.settings));
    runs[starts.back()] = run;
  }
  // Lives of other settings, policies, rates and seeds stay where they are.
  work.head.run_of = [runs](std::string_view line) {
    const auto found = runs.find(std::string(line.substr(0, line.find('{'))));
    return found == runs.end() ? JournalHead::kNotAskedFor : found->second;
  };
  work.runs_of = [](std::int64_t unit) {
    return std::vector<std::int64_t>{unit};
  };
  work.run = [&campaign, starts](const std::vector<std::int64_t>& asked,
                                 const std::atomic<bool>& stop,
                                 const Work::Emit& emit) -> absl::Status {
    for (const std::int64_t run : asked) {
      const Place place = PlaceOfRun(campaign, run);
      const absl::StatusOr<Life> life = Live(campaign, place, stop);
      if (absl::IsCancelled(life.status())) break;
      if (!life.ok()) return At(KeyOf(campaign, place), life.status());
      emit(run, FormatLife(starts[run], *life));
    }
    return absl::OkStatus();
  };
  return work;
}

absl::StatusOr<Lives> ReadLives(const Campaign& campaign,
                                const RunFolder& folder) {
  Lives lives(
      campaign.rates.size(),
      std::vector<std::vector<Life>>(
          campaign.seeds.size(), std::vector<Life>(campaign.policies.size())));
  for (std::int64_t run = 0; run < folder.runs(); ++run) {
    MLE_ASSIGN_OR_RETURN(const std::string line, folder.journal().Line(run));
    const Place place = PlaceOfRun(campaign, run);
    MLE_ASSIGN_OR_RETURN(lives[place.rate][place.seed][place.policy],
                         ParseLife(line));
  }
  return lives;
}

}  // namespace mle::lifecycle
