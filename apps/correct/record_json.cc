// Windows and channels in result.json.

#include <utility>

#include "apps/correct/result_json.h"

namespace mle::correct {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

void AddDate(const TimeNames& times, const char* key, double time, Json& json) {
  if (const auto date = times.Iso(time)) json[key] = *date;
}

Json WindowsJson(const Result& result) {
  const TimeNames times = result.data.Times(result.initial);
  Json windows = Json::array();
  for (const SetPointWindow& window : result.data.windows) {
    Json changes = Json::array();
    for (const SetPointChange& change : window.changes) {
      const double time = window.record.time(change.sample);
      Json one = {{"time", time}};
      AddDate(times, "date", time, one);
      if (change.output >= 0) {
        one["output"] = result.initial.outputs()[change.output].name;
        one["from"] = change.from;
        one["to"] = change.to;
      }
      changes.push_back(std::move(one));
    }
    Json one = {{"from", BeginOf(window)},
                {"to", EndOf(window)},
                {"non_stationary", NonStationaryIn(window, result.initial)},
                {"samples", window.record.samples()},
                {"set_point_changes", std::move(changes)}};
    AddDate(times, "from_date", BeginOf(window), one);
    AddDate(times, "to_date", EndOf(window), one);
    windows.push_back(std::move(one));
  }
  return windows;
}

Json ChannelsJson(const Result& result) {
  Json channels = Json::array();
  for (const ChannelHealth& channel : result.data.health.channels) {
    channels.push_back({{"channel", channel.name},
                        {"samples", channel.samples},
                        {"bad", channel.bad},
                        {"constant", channel.is_constant},
                        {"frozen_samples", channel.frozen_samples()},
                        {"saturated_samples", channel.saturated_samples()},
                        {"outliers", channel.outliers.size()},
                        {"quantum", channel.quantum},
                        {"noise_deviation", channel.noise}});
    if (channel.is_output && !result.data.outliers_by_model.empty()) {
      channels.back()["outliers_by_model"] =
          result.data.outliers_by_model[channel.channel];
    }
  }
  return channels;
}

}  // namespace mle::correct
