#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "apps/common/option_table.h"
#include "apps/report/text.h"
#include "apps/watch/report.h"
#include "apps/watch/source.h"

namespace mle::watch {
namespace {

constexpr Status kStatuses[] = {Status::kFailed, Status::kLearning,
                                Status::kAged, Status::kCannotTell,
                                Status::kHealthy};

using Labels = std::vector<std::pair<std::string_view, std::string_view>>;

class Metrics {
 public:
  void Begin(std::string_view name, std::string_view help) {
    name_ = absl::StrCat("mle_watch_", std::string(name));
    absl::StrAppend(&text_, "# HELP ", name_, " ", std::string(help),
                    "\n# TYPE ", name_, " gauge\n");
  }
  void Add(const Labels& labels, double value) {
    absl::StrAppend(&text_, name_);
    const char* mark = "{";
    for (const auto& [label, text] : labels) {
      absl::StrAppend(&text_, mark, std::string(label), "=\"",
                      EscapeLabel(text), "\"");
      mark = ",";
    }
    absl::StrAppend(&text_, labels.empty() ? " " : "} ", ReadableNumber(value),
                    "\n");
  }
  std::string Text() { return std::move(text_); }

 private:
  std::string name_;
  std::string text_;
};

// Without evidence there is no health.
bool HasHealth(const Report& report) {
  return report.status != Status::kFailed && report.status != Status::kLearning;
}

void AddHealth(const std::vector<Report>& reports, Metrics& metrics) {
  metrics.Begin("health",
                "Health of a controller's model: the probability that nothing "
                "has changed; an alarm is raised at 0.5.");
  for (const Report& report : reports) {
    if (HasHealth(report)) {
      metrics.Add({{"controller", report.name}}, report.health);
    }
  }
  metrics.Begin("element_health", "Health of an element of the model.");
  for (const Report& report : reports) {
    if (!HasHealth(report)) continue;
    for (const ElementHealth& element : report.elements) {
      metrics.Add({{"controller", report.name},
                   {"output", report.model.outputs()[element.output].name},
                   {"input", report.model.inputs()[element.input].name}},
                  element.health);
    }
  }
}

void AddCosts(const std::vector<Report>& reports, Metrics& metrics) {
  metrics.Begin("ageing_cost_per_month",
                "Costs of ageing in 30 days, in the money of the prices.");
  const auto each = [&](const auto& add) {
    for (const Report& report : reports) {
      if (report.cost.state == AgeingCost::State::kTold) add(report);
    }
  };
  each([&](const Report& report) {
    metrics.Add({{"controller", report.name}},
                report.cost.points.front().cost.mean);
  });
  metrics.Begin("update_pays_timestamp_seconds",
                "Day from which on an update is expected to pay.");
  each([&](const Report& report) {
    if (!report.cost.pays.has_value()) return;
    metrics.Add({{"controller", report.name}},
                *report.cost.pays * kSecondsOfDay);
  });
}

void AddAlarmMetrics(const std::vector<Report>& reports, Metrics& metrics) {
  metrics.Begin("alarms", "Alarms that were raised for the model.");
  for (const Report& report : reports) {
    const std::vector<Alarm>& alarms = report.watch->alarms;
    const int open = CountOpen(alarms);
    metrics.Add({{"controller", report.name}, {"acknowledged", "false"}}, open);
    metrics.Add({{"controller", report.name}, {"acknowledged", "true"}},
                static_cast<int>(alarms.size()) - open);
  }
  metrics.Begin("undelivered_alarms",
                "Alarms that a channel has not taken yet.");
  for (const Channel channel : kChannels) {
    int count = 0;
    for (const Report& report : reports) {
      for (const Alarm& alarm : report.watch->alarms) {
        count += IsUndelivered(alarm, channel) ? 1 : 0;
      }
    }
    metrics.Add({{"channel", NameOf(channel)}}, count);
  }
}

}  // namespace

std::string EscapeLabel(std::string_view text) {
  return absl::StrReplaceAll(report::CleanText(text),
                             {{"\\", "\\\\"}, {"\"", "\\\""}, {"\n", "\\n"}});
}

std::string FormatMetrics(const std::vector<Report>& reports,
                          std::int64_t read_at, const std::string& fault) {
  Metrics metrics;
  metrics.Begin("up", "1 if the state can be read, else 0.");
  metrics.Add({}, fault.empty() ? 1.0 : 0.0);
  metrics.Begin("read_timestamp_seconds", "When the state was read last.");
  metrics.Add({}, static_cast<double>(read_at));
  metrics.Begin("status", "1 for the status that the controller has.");
  for (const Report& report : reports) {
    for (const Status status : kStatuses) {
      metrics.Add({{"controller", report.name}, {"status", NameOf(status)}},
                  report.status == status ? 1.0 : 0.0);
    }
  }
  AddHealth(reports, metrics);
  AddCosts(reports, metrics);
  AddAlarmMetrics(reports, metrics);
  metrics.Begin("trial",
                "1 for the advice of the trial of a correction that goes on.");
  for (const Report& report : reports) {
    if (!report.trial.has_value() || report.trial->IsOver()) continue;
    metrics.Add({{"controller", report.name},
                 {"advice", NameOf(report.trial->verdict.advice)}},
                1.0);
  }
  metrics.Begin("last_day_timestamp_seconds",
                "Begin of the last day that was looked at.");
  for (const Report& report : reports) {
    if (report.last_day == 0) continue;
    metrics.Add({{"controller", report.name}}, report.last_day * kSecondsOfDay);
  }
  metrics.Begin("days", "Days with records, by what they were good for.");
  for (const Report& report : reports) {
    metrics.Add({{"controller", report.name}, {"use", "used"}},
                report.used_days);
    metrics.Add({{"controller", report.name}, {"use", "cannot_tell"}},
                report.unused_days);
  }
  return metrics.Text();
}

}  // namespace mle::watch
