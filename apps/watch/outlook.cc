#include "apps/watch/outlook.h"

#include <utility>

#include "apps/watch/update.h"
#include "mle/monitor/model_watch.h"

namespace mle::watch {
namespace {

void Scale(double unit, CourseEstimate& estimate) {
  estimate.mean *= unit;
  estimate.low *= unit;
  estimate.high *= unit;
}

OutputTrend MakeTrend(const ModelWatch& model, int output,
                      const std::vector<ScoredBatch>& batches, int last) {
  OutputTrend trend{.course = EstimateCourse(batches, last, model.options())};
  AgeingCourse& course = trend.course;
  const std::vector<int>& inputs = model.inputs(output);
  if (inputs.empty()) return trend;
  trend.input = inputs[static_cast<std::size_t>(course.element)];
  const double unit =
      model.units(output)(3 * course.element + course.parameter);
  Scale(unit, course.change);
  Scale(unit, course.rate);
  for (CoursePoint& point : course.points) Scale(unit, point.change);
  return trend;
}

}  // namespace

Outlook MakeOutlook(const Controller& controller, const ProcessModel& model,
                    const Watch& watch) {
  Outlook outlook;
  if (!watch.reference.has_value() || watch.days.empty() ||
      watch.outputs.size() != static_cast<std::size_t>(model.num_outputs())) {
    return outlook;
  }
  const absl::StatusOr<ModelWatch> watched =
      ModelWatch::Create(model, watch.sample_time, controller.options);
  if (!watched.ok()) return outlook;
  const int last = watch.last_day() - watch.first;
  std::vector<ScoredOutput> outputs;
  for (int i = 0; i < model.num_outputs(); ++i) {
    ScoredOutput& output = outputs.emplace_back();
    for (const auto& [number, stored] : watch.outputs[i]) {
      output.batches.push_back(stored.batch);
      output.evidence = stored.evidence;
    }
    outlook.trends.push_back(MakeTrend(*watched, i, output.batches, last));
  }
  const absl::StatusOr<NextChange> next = FindNextChange(
      *watched, *watch.reference, outputs,
      {.last = last,
       .share_of_output = ShareOfOutput(model, controller.options),
       .share_of_element = ShareOfElement(model, controller.options)});
  // A state of another model: nothing can be proposed.
  if (!next.ok()) return outlook;
  ProposedChange proposed{.next = *next};
  const std::vector<int>& inputs = watched->inputs(next->output);
  if (!inputs.empty()) {
    proposed.input = inputs[static_cast<std::size_t>(next->element)];
    proposed.next.change *=
        watched->units(next->output)(3 * next->element + next->parameter);
  }
  outlook.next = std::move(proposed);
  return outlook;
}

}  // namespace mle::watch
