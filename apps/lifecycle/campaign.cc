#include "apps/lifecycle/campaign.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "apps/common/sha256.h"
#include "mle/base/double_limits.h"
#include "mle/base/option_error.h"
#include "mle/base/status.h"
#include "mle/base/version.h"
#include "nlohmann/json.hpp"

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
  return WithPrefix(status,
                    absl::StrCat("policy ", key.policy, ", ageing rate ",
                                 key.ageing_rate, ", seed ", key.seed, ": "));
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

namespace {

using Json = nlohmann::ordered_json;

Json StoredJson(const Eigen::VectorXd& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(value);
  return list;
}

Json StoredJson(const control::OperationSums& sums) {
  return {{"time", sums.time},
          {"squared_error", StoredJson(sums.squared_error)},
          {"absolute_error", StoredJson(sums.absolute_error)},
          {"violation", StoredJson(sums.violation)},
          {"movement", StoredJson(sums.movement)}};
}

Json StoredJson(const ChangeRow& row) {
  return {{"time", row.event.time},
          {"output", row.event.output},
          {"before", StoredJson(row.event.before)},
          {"after", StoredJson(row.event.after)},
          {"quiet", StoredJson(row.quiet)},
          {"transient", StoredJson(row.transient)},
          {"test", StoredJson(row.test)},
          {"watch", StoredJson(row.watch)},
          {"distance", row.error.distance},
          {"gain_error", row.error.gain},
          {"delay_error", row.error.delay},
          {"index", row.index},
          {"outcome", std::string(NameOf(row.outcome))},
          {"reason", row.reason},
          {"held_out_gain", row.held_out_gain}};
}

Eigen::VectorXd ToVector(const Json& json) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(json.size()));
  for (std::size_t i = 0; i < json.size(); ++i) {
    values[static_cast<Eigen::Index>(i)] = json.at(i).get<double>();
  }
  return values;
}

double ToNumber(const Json& json) {
  return json.is_null() ? kNaN : json.get<double>();
}

control::OperationSums ToSums(const Json& json) {
  control::OperationSums sums;
  sums.time = json.at("time").get<double>();
  sums.squared_error = ToVector(json.at("squared_error"));
  sums.absolute_error = ToVector(json.at("absolute_error"));
  sums.violation = ToVector(json.at("violation"));
  sums.movement = ToVector(json.at("movement"));
  return sums;
}

absl::StatusOr<ChangeRow> ToRow(const Json& json) {
  ChangeRow row;
  row.event.time = json.at("time").get<double>();
  row.event.output = json.at("output").get<int>();
  row.event.before = ToVector(json.at("before"));
  row.event.after = ToVector(json.at("after"));
  row.quiet = ToSums(json.at("quiet"));
  row.transient = ToSums(json.at("transient"));
  row.test = ToSums(json.at("test"));
  row.watch = ToSums(json.at("watch"));
  row.error.distance = json.at("distance").get<double>();
  row.error.gain = ToNumber(json.at("gain_error"));
  row.error.delay = ToNumber(json.at("delay_error"));
  row.index = ToNumber(json.at("index"));
  MLE_ASSIGN_OR_RETURN(row.outcome,
                       ParseOutcome(json.at("outcome").get<std::string>()));
  row.reason = json.at("reason").get<std::string>();
  row.held_out_gain = ToNumber(json.at("held_out_gain"));
  return row;
}

}  // namespace

std::string LifeKey::LineStart(const Settings& settings) const {
  std::string text;
  for (const auto& [name, value] : settings) {
    // With their lengths, so that no two settings are the same text.
    absl::StrAppend(&text, name.size(), " ", name, value.size(), " ", value);
  }
  return absl::StrFormat("%s,%.17g,%d,%s,", policy, ageing_rate, seed,
                         Sha256Of(text).substr(0, 16));
}

std::string FormatLife(const std::string& line_start, const Life& life) {
  Json rows = Json::array();
  for (const ChangeRow& row : life.rows) rows.push_back(StoredJson(row));
  const Json json = {{"ended", life.ended}, {"rows", std::move(rows)}};
  return absl::StrCat(
      line_start, json.dump(-1, ' ', false, Json::error_handler_t::replace));
}

absl::StatusOr<Life> ParseLife(std::string_view line) {
  // The only file format here that we write and read ourselves: whatever else
  // is found is said to be damaged, and why.
  try {
    const Json parsed =
        Json::parse(line.substr(std::min(line.find('{'), line.size())));
    Life life;
    life.ended = parsed.at("ended").get<std::string>();
    for (const Json& row : parsed.at("rows")) {
      MLE_ASSIGN_OR_RETURN(ChangeRow read, ToRow(row));
      life.rows.push_back(std::move(read));
    }
    return life;
  } catch (const Json::exception& error) {
    return absl::DataLossError(
        absl::StrCat("is not a stored life of a policy: ", error.what()));
  }
}

}  // namespace mle::lifecycle
