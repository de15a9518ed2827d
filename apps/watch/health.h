// The report of a watch on its controller: the health of the model, of its
// outputs and of its elements, each from 0 to 1 (HealthOf() in
// mle/monitor/change_evidence.h): the probability that nothing has changed. An
// alarm is raised where it falls to one half.

#ifndef APPS_WATCH_HEALTH_H_
#define APPS_WATCH_HEALTH_H_

#include <string>
#include <string_view>
#include <vector>

#include "apps/watch/ageing_cost.h"
#include "apps/watch/outlook.h"
#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "mle/model/process_model.h"

namespace mle::watch {

enum class Status {
  kFailed,      // the records or the model could not be read
  kLearning,    // the reference is being gathered
  kAged,        // an alarm was raised
  kCannotTell,  // no day of the last month could be used
  kHealthy,
};

// "failed", "learning", "aged", "cannot_tell", "healthy"; the same in words.
std::string_view NameOf(Status status);
std::string_view WordsFor(Status status);

struct HealthPoint {
  int day = 0;  // since 1970
  double health = 1.0;
};

struct ElementHealth {
  int output = 0;
  int input = 0;
  double health = 1.0;
  double log_evidence = 0.0;
};

struct Report {
  std::string name;
  const Watch* watch = nullptr;
  ProcessModel model;  // no channels where it could not be read
  Status status = Status::kFailed;
  double health = 1.0;  // the least of all
  int last_day = 0;     // since 1970; 0 without days
  int used_days = 0;    // days in which anything could be learnt
  int unused_days = 0;  // days of which it cannot be told
  std::vector<ElementHealth> elements;
  std::vector<double> output_health;             // p
  std::vector<std::vector<HealthPoint>> trends;  // p, of outputs
  Outlook outlook;
  AgeingCost cost;
  std::string sentence;
};

// `watch` must outlive the report. Outlook and costs, which take some
// milliseconds and more, are those of `known`, a report of the same watch with
// the same controller and model, if there is one.
Report MakeReport(const Controller& controller, const ProcessModel& model,
                  const Watch& watch, const Report* known = nullptr);

}  // namespace mle::watch

#endif  // APPS_WATCH_HEALTH_H_
