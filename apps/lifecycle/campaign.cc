#include "apps/lifecycle/campaign.h"

#include <atomic>
#include <iostream>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "mle/base/file.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"

namespace mle::lifecycle {
namespace {

struct Task {
  std::size_t rate = 0;
  std::size_t seed = 0;
  std::size_t policy = 0;
};

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

LifeKey KeyOf(const Campaign& campaign, const Task& task) {
  return {campaign.policies[task.policy].name, campaign.rates[task.rate],
          campaign.seeds[task.seed]};
}

// Fills in the lives that the folder holds; what remains to be done.
absl::StatusOr<std::vector<Task>> TakeWhatIsThere(const Campaign& campaign,
                                                  Lives& lives) {
  std::vector<Task> tasks;
  std::size_t found = 0;
  for (std::size_t r = 0; r < campaign.rates.size(); ++r) {
    for (std::size_t s = 0; s < campaign.seeds.size(); ++s) {
      for (std::size_t p = 0; p < campaign.policies.size(); ++p) {
        const Task task = {r, s, p};
        absl::StatusOr<std::optional<Life>> life =
            LoadLife(campaign.folder, KeyOf(campaign, task), campaign.settings);
        if (absl::IsDataLoss(life.status())) {
          std::cerr << "warning: " << life.status().message()
                    << "; this life is simulated again\n";
          life = std::nullopt;
        }
        MLE_RETURN_IF_ERROR(life.status());
        if (life->has_value()) {
          lives[r][s][p] = **std::move(life);
          ++found;
        } else {
          tasks.push_back(task);
        }
      }
    }
  }
  if (found > 0) {
    std::cerr << campaign.folder << "/runs: " << found << " of "
              << found + tasks.size() << " lives are there already\n";
  }
  return tasks;
}

}  // namespace

absl::StatusOr<Lives> RunCampaign(const Campaign& campaign,
                                  const std::function<bool()>& stop,
                                  const ProgressFunction& told) {
  MLE_RETURN_IF_ERROR(MakeWritableFolder(campaign.folder + "/runs"));
  Lives lives(
      campaign.rates.size(),
      std::vector<std::vector<Life>>(
          campaign.seeds.size(), std::vector<Life>(campaign.policies.size())));
  MLE_ASSIGN_OR_RETURN(const std::vector<Task> tasks,
                       TakeWhatIsThere(campaign, lives));
  const auto total = static_cast<std::int64_t>(tasks.size());
  std::atomic<std::int64_t> made = 0;
  told(0, total);
  std::vector<absl::Status> status(tasks.size());
  ParallelFor(static_cast<int>(tasks.size()), campaign.threads, [&](int i) {
    const Task& task = tasks[i];
    const LifeKey key = KeyOf(campaign, task);
    status[i] = [&]() -> absl::Status {
      if (stop()) return absl::CancelledError("stopped");
      MLE_ASSIGN_OR_RETURN(const Scenario scenario,
                           MakeScenario(campaign, key.ageing_rate, key.seed));
      MLE_ASSIGN_OR_RETURN(Life life,
                           LiveThrough(scenario, campaign.policies[task.policy],
                                       campaign.life, stop));
      MLE_RETURN_IF_ERROR(
          StoreLife(campaign.folder, key, campaign.settings, life));
      lives[task.rate][task.seed][task.policy] = std::move(life);
      return absl::OkStatus();
    }();
    if (status[i].ok()) told(++made, total);
  });
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (status[i].code() == absl::StatusCode::kCancelled) {
      return absl::CancelledError("stopped");
    }
    if (!status[i].ok()) return At(KeyOf(campaign, tasks[i]), status[i]);
  }
  return lives;
}

}  // namespace mle::lifecycle
