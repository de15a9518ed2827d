#include "apps/correct/result_json.h"

#include <string>
#include <utility>
#include <vector>

#include "apps/correct/report.h"
#include "mle/correction/correction.h"
#include "mle/data/segments.h"
#include "mle/model/json_text.h"

namespace mle::correct {
namespace {

using Json = nlohmann::ordered_json;

Json StateSpaceJson(const StateSpaceForm& form) {
  Json json = {{"written", form.model.has_value()}};
  if (!form.model.has_value()) {
    json["reason"] = form.reason;
    return json;
  }
  json["order"] = form.model->system.order();
  json["error_bound"] = form.error_bound();
  json["largest_difference"] = form.largest_difference();
  return json;
}

// The form of the model given, and what describes it.
Json GivenModelJson(const Result& result) {
  const ModelFile& file = result.request.model_file;
  Json json = {{"form", std::string(NameOf(file.form))}};
  if (file.form == ModelForm::kTransferFunctions) return json;
  json["corrected"] = CorrectedName(file);
  if (file.descriptions.empty()) return json;
  json["descriptions"] = Json::array();
  for (const PairDescription& pair : file.descriptions) {
    json["descriptions"].push_back(
        {{"output", file.process.outputs()[pair.output].name},
         {"input", file.process.inputs()[pair.input].name},
         {"relative_rms", pair.relative_rms},
         {"largest_difference", pair.largest_difference},
         {"time", pair.time}});
  }
  return json;
}

Json NoiseJson(const Result& result, int i) {
  const NoiseEstimate& estimate = result.estimate.setting.noise[i];
  const double sample_time = result.initial_response.sample_time;
  const TimeNames times = result.data.Times(result.initial);
  Json json = {{"output", result.initial.outputs()[i].name},
               {"variance", estimate.variance},
               {"increment_variance", estimate.increment_variance()},
               {"window_offsets", estimate.offset},
               {"inflation", estimate.inflation},
               {"samples_at_rest", estimate.samples_at_rest}};
  if (estimate.ar_ratio > 0.0) {
    json["coloured_variance"] = estimate.ar_variance();
    json["coloured_time_constant"] = estimate.ar_memory() * sample_time;
    if (estimate.ar_damping > 0.0) {
      json["coloured_damping"] = estimate.ar_damping;
    }
  }
  Json lines = Json::array();
  for (const PeriodicLine& line : estimate.lines) {
    lines.push_back({{"period", line.period}, {"amplitude", line.amplitude}});
  }
  if (!lines.empty()) json["lines"] = std::move(lines);
  Json steps = Json::array();
  const Segments stretches = estimate.steps.empty()
                                 ? Segments()
                                 : JoinAdjoining(result.data.Records());
  for (const LevelStep& step : estimate.steps) {
    Json one = {{"window", stretches.WindowAt(step.record, step.time) + 1},
                {"time", step.time},
                {"size", step.size},
                {"time_constant", step.lag}};
    AddDate(times, "date", step.time, one);
    steps.push_back(std::move(one));
  }
  if (!steps.empty()) json["steps"] = std::move(steps);
  return json;
}

Json DistanceJson(const ResponseDistance& distance) {
  return {{"E", distance.total},
          {"relative", distance.relative},
          {"elements", MatrixJson(distance.elements)}};
}

Json ScoreJson(const HorizonScore& score) {
  return {{"initial", score.initial},
          {"corrected", score.corrected},
          {"gain", score.gain},
          {"standard_error", score.error}};
}

Json ScoresJson(const std::vector<OutputScores>& outputs,
                const ProcessModel& model) {
  Json json = Json::array();
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    json.push_back({{"output", model.outputs()[i].name},
                    {"one_step", ScoreJson(outputs[i].one_step)},
                    {"several_steps", ScoreJson(outputs[i].several_steps)},
                    {"simulated", ScoreJson(outputs[i].simulated)}});
  }
  return json;
}

Json ValidationJson(const Result& result) {
  const Validation& validation = result.validation;
  const ProcessModel& model = result.initial;
  Json json = {{"held_out", validation.folds},
               {"several_steps_samples", validation.horizon},
               {"outputs", ScoresJson(validation.outputs, model)}};
  if (!validation.missing.empty()) json["missing"] = validation.missing;
  json["windows"] = Json::array();
  for (const std::vector<OutputScores>& window : validation.windows) {
    json["windows"].push_back(ScoresJson(window, model));
  }
  return json;
}

Json ResidualJson(const ResidualReport& report, const ProcessModel& model,
                  int output) {
  Json inputs = Json::array();
  for (std::size_t j = 0; j < report.inputs.size(); ++j) {
    const InputCorrelation& input = report.inputs[j];
    inputs.push_back({{"input", model.inputs()[j].name},
                      {"statistic", input.statistic},
                      {"degrees_of_freedom", input.degrees_of_freedom},
                      {"p_value", input.p_value},
                      {"limit", input.limit},
                      {"largest", input.largest},
                      {"largest_lag", input.largest_lag},
                      {"correlated", input.correlated()}});
  }
  return {{"output", model.outputs()[output].name},
          {"samples", report.samples},
          {"variance", report.variance},
          {"ljung_box", report.ljung_box},
          {"degrees_of_freedom", report.degrees_of_freedom},
          {"p_value", report.p_value},
          {"limit", report.limit},
          {"share_outside", report.outside},
          {"white", report.white()},
          {"inputs", std::move(inputs)}};
}

Json ResidualsJson(const std::vector<ResidualReport>& reports,
                   const ProcessModel& model) {
  Json json = Json::array();
  for (std::size_t i = 0; i < reports.size(); ++i) {
    json.push_back(ResidualJson(reports[i], model, static_cast<int>(i)));
  }
  return json;
}

Json MessagesJson(const std::vector<Message>& messages) {
  Json json = Json::array();
  for (const Message& message : messages) {
    json.push_back({{"code", std::string(NameOf(message.code))},
                    {"place", message.place},
                    {"text", message.text},
                    {"options", message.options}});
  }
  return json;
}

Json FindingsJson(const std::vector<Finding>& findings) {
  Json json = Json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"name", finding.name},
                    {"place", finding.place},
                    {"value", finding.value},
                    {"unit", finding.unit},
                    {"lower", finding.lower},
                    {"upper", finding.upper},
                    {"text", finding.text}});
  }
  return json;
}

const char* TerminationName(FitTermination termination) {
  switch (termination) {
    case FitTermination::kNotRun:
      return "not_run";
    case FitTermination::kConverged:
      return "converged";
    case FitTermination::kIterationLimit:
      return "iteration_limit";
    case FitTermination::kFailed:
      return "failed";
  }
  return "";
}

Json CertificateJson(const Result& result) {
  Json fits = Json::array();
  const OutputErrorFit& fit = result.estimate.fit.output_error.corrected;
  for (std::size_t i = 0; i < fit.certificates.size(); ++i) {
    const FitCertificate& certificate = fit.certificates[i];
    fits.push_back({{"output", result.initial.outputs()[i].name},
                    {"termination", TerminationName(certificate.termination)},
                    {"message", certificate.message},
                    {"gradient", certificate.gradient},
                    {"condition", certificate.condition},
                    {"rank", certificate.rank},
                    {"num_parameters", certificate.num_parameters},
                    {"iterations", certificate.iterations},
                    {"search_confirmed", certificate.search_confirmed},
                    {"at_bound", certificate.at_bound}});
  }
  return {{"output_error", std::move(fits)},
          {"max_relative_duality_gap", result.corrected.max_relative_gap}};
}

// The explanations that were taken, output by output.
Json ExplanationsJson(const Result& result) {
  const ProcessModel& model = result.initial;
  Json json = Json::array();
  const auto entry = [&](int i, const TakenExplanation& one) {
    const ExplanationType& type = TypeOf(one.explanation.kind);
    Json row = {{"output", model.outputs()[i].name},
                {"explanation", std::string(type.code)}};
    if (type.place != ExplanationPlace::kOutput) {
      row["input"] = model.inputs()[one.explanation.index].name;
    }
    row["value"] = one.explanation.value;
    row["standard_error"] = one.standard_error;
    row["evidence"] = one.evidence;
    return row;
  };
  for (int i = 0; i < static_cast<int>(result.explanations.size()); ++i) {
    for (const TakenExplanation& one : result.explanations[i].taken) {
      json.push_back(entry(i, one));
    }
  }
  return json;
}

Json JudgesJson(const Result& result) {
  const ProcessModel& model = result.initial;
  Json json = Json::array();
  for (int i = 0; i < static_cast<int>(result.explanations.size()); ++i) {
    const OutputExplanation& output = result.explanations[i];
    Json row = {{"output", model.outputs()[i].name}};
    if (!output.judged()) {
      row["missing"] = output.unjudged;
      json.push_back(std::move(row));
      continue;
    }
    row["instruments"] = output.by_set_points ? "set_points" : "inputs";
    if (output.feedback_p_value.has_value()) {
      row["feedback_p_value"] = *output.feedback_p_value;
    }
    row["moves"] = output.moves;
    if (output.together) row["together"] = true;
    row["before"] = output.before();
    row["left"] = output.left();
    if (output.next.has_value()) {
      row["next"] = {{"explanation",
                      std::string(TypeOf(output.next->explanation.kind).code)},
                     {"value", output.next->explanation.value},
                     {"evidence", output.next->evidence}};
    }
    Json held_out = Json::array();
    for (const HorizonErrors& error : output.held_out) {
      held_out.push_back({{"horizon", error.horizon},
                          {"initial", error.initial},
                          {"corrected", error.explained},
                          {"deviations", error.deviations}});
    }
    row["held_out"] = std::move(held_out);
    json.push_back(std::move(row));
  }
  return json;
}

// The curves that the records showed, gains relative to where these began.
Json CurvesJson(const Result& result) {
  constexpr int kPoints = 11;
  Json json = Json::array();
  for (const FoundCurve& curve : result.curves) {
    const ProcessModel& model = result.initial;
    Json points = Json::array();
    for (int k = 0; k < kPoints; ++k) {
      const double value =
          curve.low + (curve.high - curve.low) * k / (kPoints - 1.0);
      const FoundCurve::Gain gain = curve.GainAt(value);
      points.push_back({{"value", value},
                        {"gain", gain.value},
                        {"lower", gain.lower},
                        {"upper", gain.upper}});
    }
    json.push_back(
        {{"channel", curve.is_output ? model.outputs()[curve.channel].name
                                     : model.inputs()[curve.channel].name},
         {"is_output", curve.is_output},
         {"curvature", curve.curvature},
         {"standard_error", curve.standard_error},
         {"at", curve.at},
         {"text", DescribeCurve(model, curve)},
         {"gains", std::move(points)}});
  }
  return json;
}

}  // namespace

void AddFindings(const Result& result, Json& json) {
  const NullCalibration& calibrated = result.estimate.fit.test;
  const OutputErrorCorrection& test = result.estimate.fit.output_error;
  const ProcessModel& model = result.initial;
  json["estimator"] = std::string(NameOf(result.options.estimation.estimator));
  json["decision"] = std::string(NameOf(result.decision));
  json["verdict"] = result.verdict;
  json["reasons"] = MessagesJson(result.reasons);
  json["findings"] = FindingsJson(result.findings);
  json["explanations"] = ExplanationsJson(result);
  json["judges"] = JudgesJson(result);
  if (!result.curves.empty()) json["curves"] = CurvesJson(result);
  json["test_of_no_change"] = {
      {"p_value", calibrated.p_value},
      {"p_value_chi_square", test.p_value},
      {"calibration_factor", calibrated.factor},
      {"calibration_replicates", calibrated.replicates},
      {"statistic", test.statistic},
      {"degrees_of_freedom", test.degrees_of_freedom},
      {"false_alarm_probability",
       result.options.estimation.output_error.false_alarm_probability},
      {"change_proposed", result.estimate.fit.change_proposed}};
  Json elements = Json::array();
  for (const auto& [i, j] : Pairs(model)) {
    elements.push_back(ElementJson(result, i, j));
  }
  json["elements"] = std::move(elements);
  json["response_horizon"] = (result.initial_response.samples() - 1) *
                             result.initial_response.sample_time;
  json["distance"] = DistanceJson(result.change);
  if (result.initial_to_truth.has_value()) {
    json["truth"] = {{"E_initial", result.initial_to_truth->total},
                     {"E_corrected", result.corrected_to_truth->total},
                     {"initial", DistanceJson(*result.initial_to_truth)},
                     {"corrected", DistanceJson(*result.corrected_to_truth)}};
  }
  json["arx"] = {{"written", result.corrected.has_arx()},
                 {"order", result.corrected.arx.order},
                 {"largest_difference", result.corrected.arx_error}};
  json["state_space"] = StateSpaceJson(result.state_space);
  json["given_model"] = GivenModelJson(result);
  Json noise = Json::array();
  for (int i = 0; i < model.num_outputs(); ++i) {
    noise.push_back(NoiseJson(result, i));
  }
  json["noise"] = std::move(noise);
  if (!result.filters.empty()) json["filter"] = FilterJson(result);
  if (result.next_move.has_value()) json["plan"] = NextMoveJson(result);
  const EstimateFit& fit = result.estimate.fit;
  if (fit.arx != nullptr) {
    json["lambda_star"] = fit.arx->selection().lambda_star(0);
  }
}

void AddDiagnostics(const Result& result, Json& json) {
  json["channels"] = ChannelsJson(result);
  json["windows"] = WindowsJson(result);
  json["validation"] = ValidationJson(result);
  json["residuals"] = {
      {"initial", ResidualsJson(result.initial_residuals, result.initial)},
      {"corrected", ResidualsJson(result.corrected_residuals, result.initial)}};
  json["certificate"] = CertificateJson(result);
  json["advice"] = result.advice;
  json["tuning"] = result.tuning.reasons;
  json["notes"] = MessagesJson(result.notes);
  json["warnings"] = MessagesJson(result.warnings);
  json["failures"] = MessagesJson(result.failures);
}

}  // namespace mle::correct
