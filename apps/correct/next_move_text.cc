// The next move in sentences, as a table and a figure, on the page and in
// result.json.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "apps/correct/figure_parts.h"
#include "apps/correct/report.h"
#include "apps/correct/result_json.h"
#include "apps/report/text.h"

namespace mle::correct {
namespace {

using report::Align;
using report::FormatSignificant;
using report::Panel;
using report::Role;

using MoveJson = nlohmann::ordered_json;

// More gains than these are counted, not named.
constexpr std::size_t kMostNamedGains = 3;
// More channels than these are not drawn.
constexpr int kMostPlanPanels = 12;

std::string Percent(double share) {
  return absl::StrCat(FormatSignificant(100.0 * share, 2), " %");
}

std::string Duration(const Result& result, double time) {
  return absl::StrCat(FormatSignificant(time, 3), " ",
                      result.initial.time_unit());
}

std::string WithUnit(double value, const std::string& unit) {
  return unit.empty() ? FormatSignificant(value, 3)
                      : absl::StrCat(FormatSignificant(value, 3), " ", unit);
}

// "Raise the set point of top by 0.4 and lower that of bottom by 0.1"
std::string FirstMove(const Result& result, const Plan& plan) {
  const Eigen::VectorXd move =
      plan.steps.front().set_points - plan.steps.back().set_points;
  std::vector<std::string> parts;
  for (Eigen::Index i = 0; i < move.size(); ++i) {
    if (move(i) == 0.0) continue;
    const OutputChannel& output = result.initial.outputs()[i];
    const bool first = parts.empty();
    parts.push_back(absl::StrCat(move(i) > 0.0 ? (first ? "Raise " : "raise ")
                                               : (first ? "Lower " : "lower "),
                                 first ? "the set point of " : "that of ",
                                 output.name, " by ",
                                 WithUnit(std::abs(move(i)), output.unit)));
  }
  if (parts.size() == 1) return parts.front();
  const std::string last = std::move(parts.back());
  parts.pop_back();
  return absl::StrCat(absl::StrJoin(parts, ", "), " and ", last);
}

std::string WhatToMove(const Result& result, const Plan& plan) {
  const std::size_t held = plan.steps.size() - 1;
  const std::string first = absl::StrCat(FirstMove(result, plan), " for ",
                                         Duration(result, plan.steps[1].time));
  if (held == 1) return absl::StrCat(first, ", then back.");
  return absl::StrCat(first, ", then go on as the plan says: ", held,
                      " values in turn, back after ",
                      Duration(result, plan.duration), ".");
}

std::string WhatItCosts(const Result& result, const NextMove& move) {
  if (move.priced) {
    return absl::StrCat("Expected cost: ", report::FormatMoney(move.plan->cost),
                        ", in the money of the prices.");
  }
  return absl::StrCat("Its squared deviations are expected to be those of ",
                      Duration(result, move.usual), " of usual operation.");
}

// "8 % for top ← reflux (now 40 %), …", of the least known first.
std::string ErrorsAfter(const Result& result, const Plan& plan) {
  std::vector<const PlanAnswer*> answers;
  for (const PlanAnswer& answer : plan.answers) answers.push_back(&answer);
  std::stable_sort(answers.begin(), answers.end(),
                   [](const PlanAnswer* a, const PlanAnswer* b) {
                     return a->after > b->after;
                   });
  std::vector<std::string> parts;
  for (const PlanAnswer* answer : answers) {
    if (parts.size() == kMostNamedGains) break;
    const PlanQuestion& question = answer->question;
    const bool told = std::isfinite(answer->before) && !question.alone;
    parts.push_back(absl::StrCat(
        Percent(answer->after), " for ",
        PairName(result.initial, question.output, question.input),
        told ? absl::StrCat(" (now ", Percent(answer->before), ")") : ""));
  }
  const std::size_t others = answers.size() - parts.size();
  if (others > 0) parts.push_back(absl::StrCat("less for ", others, " more"));
  return absl::StrJoin(parts, ", ");
}

std::string WhenItMayBegin(const Result& result, const NextMove& move) {
  const TimeNames times = result.data.Times(result.initial);
  if (move.at_once) {
    return absl::StrCat("It may begin at once after the records (",
                        times.At(move.earliest), ").");
  }
  return absl::StrCat("It may not begin before ", times.At(move.earliest),
                      ": the last change of ", move.settling,
                      " has to settle first.");
}

bool MovesChannel(const Eigen::MatrixXd& rows, Eigen::Index row) {
  return rows.row(row).maxCoeff() > rows.row(row).minCoeff();
}

void AddLimit(double limit, Panel& panel) {
  panel.lines.push_back(
      report::HorizontalLine(Role::kReference, "limit", limit));
}

MoveJson FiniteOrNull(double value) {
  return std::isfinite(value) ? MoveJson(value) : MoveJson(nullptr);
}

MoveJson ChannelJson(const std::string& name, const Eigen::MatrixXd& expected,
                     const Eigen::MatrixXd& low, const Eigen::MatrixXd& high,
                     const Eigen::VectorXd& min, const Eigen::VectorXd& max,
                     Eigen::Index row) {
  return {{"name", name},
          {"expected",
           {expected.row(row).minCoeff(), expected.row(row).maxCoeff()}},
          {"band", {low.row(row).minCoeff(), high.row(row).maxCoeff()}},
          {"limits", {FiniteOrNull(min(row)), FiniteOrNull(max(row))}}};
}

const char* PlanStateName(const NextMove& move) {
  if (!move.plan.has_value()) return "impossible";
  switch (move.plan->state) {
    case Plan::State::kNothingNeeded:
      return "nothing_needed";
    case Plan::State::kFound:
      return "found";
    case Plan::State::kOutOfReach:
      break;
  }
  return "out_of_reach";
}

}  // namespace

std::vector<std::string> DescribeNextMove(const Result& result) {
  if (!result.next_move.has_value()) return {};
  const NextMove& move = *result.next_move;
  if (!move.plan.has_value()) {
    return {absl::StrCat("No next move is planned. ", move.reason)};
  }
  const Plan& plan = *move.plan;
  const std::string wanted = Percent(result.request.next_move.error);
  if (plan.state == Plan::State::kNothingNeeded) {
    return {
        absl::StrCat("Nothing has to be moved: each gain is known with a "
                     "standard error of ",
                     wanted, " or less.")};
  }
  if (plan.state == Plan::State::kOutOfReach) {
    return {absl::StrCat("No plan within the limits and ",
                         Duration(result, move.options.longest),
                         " brings standard errors of ", wanted,
                         ". The best one brings ", ErrorsAfter(result, plan),
                         "; what hinders is ", plan.hindrance, ".")};
  }
  return {WhatToMove(result, plan), WhatItCosts(result, move),
          absl::StrCat("Standard errors of gains will then be ",
                       ErrorsAfter(result, plan), "."),
          WhenItMayBegin(result, move)};
}

report::Table NextMoveTable(const Result& result) {
  const NextMove& move = *result.next_move;
  const ProcessModel& model = result.initial;
  report::Table table{
      .caption = "Set points of the plan, from the first move on",
      .columns = {{absl::StrCat("after (", model.time_unit(), ")")}}};
  std::vector<Eigen::Index> moved;
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (!MovesChannel(move.plan->expected.set_points, i)) continue;
    moved.push_back(i);
    const OutputChannel& output = model.outputs()[i];
    table.columns.push_back(
        {output.unit.empty()
             ? output.name
             : absl::StrCat(output.name, " (", output.unit, ")")});
  }
  for (const PlanStep& step : move.plan->steps) {
    std::vector<std::string> row = {FormatSignificant(step.time, 4)};
    for (const Eigen::Index i : moved) {
      row.push_back(FormatSignificant(step.set_points(i), 5));
    }
    table.AddRow(std::move(row));
  }
  return table;
}

std::optional<report::NamedFigure> NextMoveFigure(const Result& result) {
  if (!result.next_move.has_value() || !result.next_move->plan.has_value() ||
      result.next_move->plan->steps.empty()) {
    return std::nullopt;
  }
  const NextMove& move = *result.next_move;
  const Plan& plan = *move.plan;
  const ProcessModel& model = result.initial;
  const int panels =
      std::min(model.num_outputs() + model.num_inputs(), kMostPlanPanels);
  report::NamedFigure named = NewFigure(
      "next_move",
      "The plan: set points, outputs and inputs as expected, with the band in "
      "which plants that the records allow, and disturbances, keep them, and "
      "the limits.",
      (panels + 1) / 2, 2, 4.6);
  const std::vector<double> time =
      Times(0.0, plan.expected.sample_time, plan.expected.samples());
  const auto add = [&](const std::string& name, const std::string& unit,
                       const Eigen::MatrixXd& expected,
                       const Eigen::MatrixXd& low, const Eigen::MatrixXd& high,
                       double min, double max, Eigen::Index row) -> Panel& {
    Panel& panel = named.figure.AddPanel(name);
    panel.x.label = TimeLabel(result, "time from the first move");
    panel.y.label = unit;
    report::Series& series =
        AddCurve(Role::kCorrected, "expected", time,
                 ToVector(expected.row(row).transpose()), panel);
    series.lower = ToVector(low.row(row).transpose());
    series.upper = ToVector(high.row(row).transpose());
    AddLimit(min, panel);
    AddLimit(max, panel);
    return panel;
  };
  for (int i = 0; i < model.num_outputs(); ++i) {
    if (std::ssize(named.figure.panels) >= kMostPlanPanels) break;
    Panel& panel =
        add(model.outputs()[i].name, model.outputs()[i].unit,
            plan.expected.outputs, plan.low_outputs, plan.high_outputs,
            move.options.min_output(i), move.options.max_output(i), i);
    AddCurve(Role::kSetPoint, "set point", time,
             ToVector(plan.expected.set_points.row(i).transpose()), panel)
        .steps = true;
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    if (std::ssize(named.figure.panels) >= kMostPlanPanels) break;
    add(model.inputs()[j].name, model.inputs()[j].unit, plan.expected.inputs,
        plan.low_inputs, plan.high_inputs, move.options.min_input(j),
        move.options.max_input(j), j);
  }
  return named;
}

void AddNextMove(const Result& result,
                 const std::vector<report::DrawnFigure>& figures,
                 report::HtmlPage& page) {
  if (!result.next_move.has_value()) return;
  page.AddHeading("The next move");
  page.AddParagraph(absl::StrJoin(DescribeNextMove(result), " "));
  const NextMove& move = *result.next_move;
  if (!move.plan.has_value() || move.plan->steps.empty()) return;
  page.AddTable(NextMoveTable(result));
  AddFigure(figures, "next_move", page);
  std::vector<std::string> notes = move.assumptions;
  notes.push_back(absl::StrCat(
      "The band holds ", move.options.draws - move.plan->left_out,
      " plants drawn from what the records leave open and what ageing may have "
      "done since, and ",
      FormatSignificant(move.options.deviations, 2),
      " standard deviations of usual operation; ", move.plan->left_out,
      " more were left out, which this loop would not hold."));
  page.AddList(notes);
}

nlohmann::ordered_json NextMoveJson(const Result& result) {
  const NextMove& move = *result.next_move;
  const ProcessModel& model = result.initial;
  MoveJson json = {{"state", PlanStateName(move)},
                   {"sentences", DescribeNextMove(result)}};
  if (!move.plan.has_value() || move.plan->steps.empty()) return json;
  const Plan& plan = *move.plan;
  json["earliest"] = move.earliest;
  AddDate(result.data.Times(model), "earliest_date", move.earliest, json);
  json["duration"] = plan.duration;
  json["cost"] = plan.cost;
  json["priced"] = move.priced;
  json["hindrance"] = plan.hindrance;
  json["steps"] = MoveJson::array();
  for (const PlanStep& step : plan.steps) {
    MoveJson set_points = MoveJson::object();
    for (int i = 0; i < model.num_outputs(); ++i) {
      if (!MovesChannel(plan.expected.set_points, i)) continue;
      set_points[model.outputs()[i].name] = step.set_points(i);
    }
    json["steps"].push_back(
        {{"time", step.time}, {"set_points", std::move(set_points)}});
  }
  json["gains"] = MoveJson::array();
  for (const PlanAnswer& answer : plan.answers) {
    json["gains"].push_back(
        {{"output", model.outputs()[answer.question.output].name},
         {"input", model.inputs()[answer.question.input].name},
         {"alone", answer.question.alone},
         {"wanted", answer.question.error},
         {"before", FiniteOrNull(answer.before)},
         {"after", FiniteOrNull(answer.after)}});
  }
  json["channels"] = MoveJson::array();
  for (int i = 0; i < model.num_outputs(); ++i) {
    json["channels"].push_back(
        ChannelJson(model.outputs()[i].name, plan.expected.outputs,
                    plan.low_outputs, plan.high_outputs,
                    move.options.min_output, move.options.max_output, i));
  }
  for (int j = 0; j < model.num_inputs(); ++j) {
    json["channels"].push_back(ChannelJson(
        model.inputs()[j].name, plan.expected.inputs, plan.low_inputs,
        plan.high_inputs, move.options.min_input, move.options.max_input, j));
  }
  json["plants"] = move.options.draws;
  json["plants_left_out"] = plan.left_out;
  json["assumptions"] = move.assumptions;
  return json;
}

}  // namespace mle::correct
