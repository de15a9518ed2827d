#include "mle/exchange/model_conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "mle/base/status.h"
#include "mle/exchange/description.h"
#include "mle/exchange/mat_file.h"
#include "mle/model/balanced_reduction.h"

namespace mle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kCoefficients = 60;
constexpr int kMostCoefficients = 100'000;
constexpr double kMostSamples = 1e6;
constexpr double kSameInterval = 1e-9;
constexpr std::array<ModelForm, 5> kForms = {
    ModelForm::kTransferFunctions, ModelForm::kElementTable,
    ModelForm::kStepResponses, ModelForm::kDiscreteTransferFunctions,
    ModelForm::kStateSpace};

bool Holds(ModelFileType type, ModelForm form) {
  switch (type) {
    case ModelFileType::kJson:
      return form != ModelForm::kElementTable;
    case ModelFileType::kCsv:
      return form == ModelForm::kElementTable ||
             form == ModelForm::kStepResponses;
    case ModelFileType::kMat:
      return form == ModelForm::kTransferFunctions ||
             form == ModelForm::kStepResponses;
  }
  return false;
}

double IntervalOf(const ModelFile& file) {
  switch (file.form) {
    case ModelForm::kStepResponses:
      return file.step_responses.interval;
    case ModelForm::kDiscreteTransferFunctions:
      return file.discrete.sample_time;
    case ModelForm::kStateSpace:
      return file.state_space.system.sample_time;
    default:
      return 0.0;
  }
}

// 1, 2 or 5 times a power of ten, no less than `value` > 0.
double RoundedUp(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0}) {
    if (digit * power >= value) return digit * power;
  }
  return 10.0 * power;
}

// Settling time of the slowest element: many lags in series are slower than the
// slowest of them, by which SettlingTime() goes.
double TimeToSettle(const ProcessModel& model) {
  double longest = SettlingTime(model);
  for (const auto& [i, j] : Pairs(model)) {
    const TransferFunction& g = model.element(i, j);
    if (!g.IsIntegrating()) longest = std::max(longest, g.TimeToSettle());
  }
  return longest;
}

double ChooseInterval(const ModelFile& file, const ModelConversion& to) {
  if (to.interval > 0.0) return to.interval;
  if (const double interval = IntervalOf(file); interval > 0.0) return interval;
  const double settling = TimeToSettle(file.process);
  return settling > 0.0 ? RoundedUp(settling / kCoefficients) : 1.0;
}

// How far a response still moves after its last coefficient, relative to its
// range; for a ramp, the relative difference of its slope.
double LeftAfter(const TransferFunction& g, const PairResponse& pair,
                 double interval) {
  const VectorXd& c = pair.coefficients;
  const double gain = g.StaticGain();
  if (pair.is_ramp) {
    const double slope = (c(c.size() - 1) - c(c.size() - 2)) / interval;
    return std::abs(slope - gain) / std::abs(gain);
  }
  const double range = std::max(RangeOf(c), std::abs(gain));
  return range > 0.0 ? std::abs(gain - c(c.size() - 1)) / range : 0.0;
}

class Converter {
 public:
  Converter(const ModelFile& file, const ModelConversion& to)
      : file_(file), to_(to), model_(file.process) {
    result_.differences =
        MatrixXd::Zero(model_.num_outputs(), model_.num_inputs());
    for (const PairDescription& pair : file.descriptions) {
      result_.differences(pair.output, pair.input) =
          std::max(pair.largest_difference, pair.moves_on);
    }
  }

  absl::StatusOr<ConvertedModel> Convert();

 private:
  ProcessModel Channels() const {
    return {model_.name(), model_.time_unit(), model_.inputs(),
            model_.outputs()};
  }
  bool HasElements() const;
  // The file already holds what is asked for.
  bool IsSame() const;
  absl::Status ToTransferFunctions();
  absl::Status ToElementTable();
  absl::Status ToStepResponses();
  absl::Status CheckText() const;
  absl::Status CheckRead(const absl::Status& read) const;
  absl::Status ToDiscrete();
  absl::Status ToStateSpace();
  // The responses of a file that is sampled, or discrete, where `interval` is a
  // multiple of its own.
  std::optional<StepResponse> OwnResponse(double interval, int length) const;
  // Those, or those of what describes the file.
  StepResponseModel Sampled();
  absl::Status Write(const StepResponseModel& steps);

  const ModelFile& file_;
  const ModelConversion& to_;
  const ProcessModel& model_;
  ConvertedModel result_;
};

bool Converter::HasElements() const {
  for (const auto& [i, j] : Pairs(model_)) {
    if (!model_.element(i, j).IsZero()) return true;
  }
  return false;
}

bool Converter::IsSame() const {
  if (to_.form != file_.form) return false;
  const bool same_interval =
      to_.interval == 0.0 || to_.interval == IntervalOf(file_);
  return same_interval &&
         (file_.form != ModelForm::kStepResponses || to_.coefficients == 0 ||
          to_.coefficients == file_.step_responses.length());
}

absl::Status Converter::ToTransferFunctions() {
  if (to_.type == ModelFileType::kMat) {
    MLE_ASSIGN_OR_RETURN(result_.text, FormatMat(model_));
  } else {
    result_.text = FormatProcessModel(model_);
  }
  return absl::OkStatus();
}

absl::Status Converter::ToElementTable() {
  ElementTable empty;
  empty.channels = Channels();
  const ElementTable table = WithElements(empty, model_);
  for (const ElementRow& row : table.rows) {
    result_.differences(row.output, row.input) += row.largest_difference;
  }
  result_.text = FormatElementTable(table);
  return absl::OkStatus();
}

std::optional<StepResponse> Converter::OwnResponse(double interval,
                                                   int length) const {
  const double own = IntervalOf(file_);
  if (!(own > 0.0)) return std::nullopt;
  const double ratio = std::round(interval / own);
  if (!(ratio >= 1.0) || ratio * length > kMostSamples ||
      std::abs(ratio * own - interval) > kSameInterval * interval) {
    return std::nullopt;
  }
  const auto stride = static_cast<int>(ratio);
  const int samples = stride * length + 1;
  StepResponse all;
  if (file_.form == ModelForm::kDiscreteTransferFunctions) {
    all = ComputeStepResponse(file_.discrete, samples);
  } else if (file_.form == ModelForm::kStateSpace) {
    all = file_.state_space.system.ComputeStepResponse(samples);
  } else if (file_.step_responses.length() >= stride * length) {
    all = StepResponse(own, model_.num_outputs(), model_.num_inputs(), samples);
    for (const PairResponse& pair : file_.step_responses.pairs) {
      all.element(pair.output, pair.input).tail(samples - 1) =
          pair.coefficients.head(samples - 1);
    }
  } else {
    return std::nullopt;
  }
  StepResponse thinned(interval, all.num_outputs, all.num_inputs, length + 1);
  for (int i = 0; i < all.num_outputs; ++i) {
    for (int j = 0; j < all.num_inputs; ++j) {
      thinned.element(i, j) =
          all.element(i, j)(Eigen::seqN(0, length + 1, stride));
    }
  }
  return thinned;
}

StepResponseModel Converter::Sampled() {
  StepResponseModel steps;
  steps.channels = Channels();
  steps.interval = ChooseInterval(file_, to_);
  int length = to_.coefficients;
  if (length == 0) {
    const double settling = file_.form == ModelForm::kStepResponses
                                ? file_.step_responses.time_to_steady_state()
                                : TimeToSettle(model_);
    length = std::clamp(
        static_cast<int>(std::min(std::ceil(settling / steps.interval),
                                  1.0 * kMostCoefficients)),
        kFewestCoefficients, kMostCoefficients);
  }
  const std::optional<StepResponse> own = OwnResponse(steps.interval, length);
  if (own.has_value()) result_.differences.setZero();
  const StepResponse response =
      own.has_value() ? *own
                      : model_.ComputeStepResponse(steps.interval, length + 1);
  for (const auto& [i, j] : Pairs(model_)) {
    const TransferFunction& g = model_.element(i, j);
    if (g.IsZero()) continue;
    steps.pairs.push_back(
        {i, j, response.element(i, j).tail(length), g.IsIntegrating()});
  }
  return steps;
}

absl::Status Converter::CheckRead(const absl::Status& read) const {
  if (read.ok()) return read;
  return InvalidArgument(
      "the model in this form",
      result_.interval > 0.0 ? absl::StrCat(", every ", result_.interval, " ",
                                            model_.time_unit(), ",")
                             : "",
      " could not be read again: ", absl::StripPrefix(read.message(), "it: "));
}

absl::Status Converter::Write(const StepResponseModel& steps) {
  if (to_.type == ModelFileType::kMat) {
    MLE_RETURN_IF_ERROR(CheckRead(OfStepResponses(steps, "it").status()));
    MLE_ASSIGN_OR_RETURN(result_.text, FormatMat(steps));
  } else if (to_.type == ModelFileType::kCsv) {
    result_.text = FormatStepResponseCsv(steps);
  } else {
    result_.text = FormatStepResponseJson(steps);
  }
  return absl::OkStatus();
}

absl::Status Converter::ToStepResponses() {
  const StepResponseModel steps = Sampled();
  if (std::all_of(steps.pairs.begin(), steps.pairs.end(),
                  [](const PairResponse& pair) {
                    return pair.coefficients.isZero(0.0);
                  })) {
    return InvalidArgument(
        "no output moves within ", steps.length(), " coefficients every ",
        steps.interval, " ", model_.time_unit(),
        ": more coefficients or a longer interval must cover the dead times");
  }
  MLE_RETURN_IF_ERROR(steps.Validate());
  result_.interval = steps.interval;
  for (const PairResponse& pair : steps.pairs) {
    result_.differences(pair.output, pair.input) += LeftAfter(
        model_.element(pair.output, pair.input), pair, steps.interval);
  }
  return Write(steps);
}

// Checks that the text can be read again. A model that was near noisy step
// responses may be sampled to ones that no description is near, and not every
// form can hold every name. MAT files hold the names that they are given.
absl::Status Converter::CheckText() const {
  if (to_.type == ModelFileType::kMat) return absl::OkStatus();
  const absl::StatusOr<ModelFile> read = ParseModelFile(result_.text, "it");
  MLE_RETURN_IF_ERROR(CheckRead(read.status()));
  const auto same = [](const auto& ours, const auto& theirs) {
    return ours.name == theirs.name && ours.unit == theirs.unit;
  };
  const ProcessModel& written = read->process;
  if (std::equal(model_.inputs().begin(), model_.inputs().end(),
                 written.inputs().begin(), written.inputs().end(), same) &&
      std::equal(model_.outputs().begin(), model_.outputs().end(),
                 written.outputs().begin(), written.outputs().end(), same)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      "names or units of channels would be others when they are read again: "
      "blanks at their ends and line breaks are lost in this form; JSON keeps "
      "them");
}

absl::Status Converter::ToDiscrete() {
  DiscreteModel discrete;
  discrete.channels = Channels();
  discrete.sample_time = result_.interval = ChooseInterval(file_, to_);
  MLE_ASSIGN_OR_RETURN(discrete,
                       WithChange(discrete, discrete.channels, model_));
  MLE_RETURN_IF_ERROR(discrete.Validate());
  result_.text = FormatDiscreteModel(discrete);
  return absl::OkStatus();
}

absl::Status Converter::ToStateSpace() {
  result_.interval = ChooseInterval(file_, to_);
  ReductionOptions options;
  options.tolerance = to_.tolerance;
  MLE_ASSIGN_OR_RETURN(ReducedModel reduced,
                       ReduceModel(model_, result_.interval, options));
  NamedStateSpace named;
  named.SetChannels(model_);
  named.system = std::move(reduced.system);
  const VectorXd& bounds = reduced.error_bounds;
  const VectorXd& differences = reduced.largest_differences;
  named.accuracy = StateSpaceAccuracy{{bounds.begin(), bounds.end()},
                                      {differences.begin(), differences.end()}};
  for (const auto& [i, j] : Pairs(model_)) {
    if (model_.element(i, j).IsZero()) continue;
    result_.differences(i, j) += differences(i);
  }
  result_.states = named.system.order();
  result_.text = FormatStateSpace(named);
  return absl::OkStatus();
}

absl::StatusOr<ConvertedModel> Converter::Convert() {
  if (to_.type == ModelFileType::kCsv &&
      absl::StripAsciiWhitespace(model_.time_unit()).empty()) {
    return absl::InvalidArgumentError(
        "the model has no time unit, and a CSV file of one must name it");
  }
  if (IsSame() && file_.form != ModelForm::kTransferFunctions) {
    result_.differences.setZero();
    result_.interval = IntervalOf(file_);
    if (file_.form == ModelForm::kStateSpace) {
      result_.states = file_.state_space.system.order();
    }
    if (file_.form == ModelForm::kStepResponses) {
      MLE_RETURN_IF_ERROR(Write(file_.step_responses));
    } else {
      MLE_ASSIGN_OR_RETURN(FormattedModel same, FormatCorrected(file_, model_));
      result_.text = std::move(same.text);
    }
    MLE_RETURN_IF_ERROR(CheckText());
    return std::move(result_);
  }
  if (to_.form != ModelForm::kTransferFunctions && !HasElements()) {
    return InvalidArgument(
        "the model has no elements: there is nothing to write as ",
        std::string(NameOf(to_.form)));
  }
  switch (to_.form) {
    case ModelForm::kTransferFunctions:
      MLE_RETURN_IF_ERROR(ToTransferFunctions());
      break;
    case ModelForm::kElementTable:
      MLE_RETURN_IF_ERROR(ToElementTable());
      break;
    case ModelForm::kStepResponses:
      MLE_RETURN_IF_ERROR(ToStepResponses());
      break;
    case ModelForm::kDiscreteTransferFunctions:
      MLE_RETURN_IF_ERROR(ToDiscrete());
      break;
    case ModelForm::kStateSpace:
      MLE_RETURN_IF_ERROR(ToStateSpace());
      break;
  }
  MLE_RETURN_IF_ERROR(CheckText());
  return std::move(result_);
}

}  // namespace

std::optional<ModelForm> ModelFormOf(std::string_view name) {
  for (const ModelForm form : kForms) {
    if (NameOf(form) == name) return form;
  }
  return std::nullopt;
}

absl::Status ModelConversion::Validate() const {
  if (!(interval >= 0.0) || !std::isfinite(interval)) {
    return InvalidArgument("interval=", interval,
                           ", must be finite and not negative");
  }
  if (coefficients != 0 && (coefficients < kFewestCoefficients ||
                            coefficients > kMostCoefficients)) {
    return InvalidArgument("coefficients=", coefficients,
                           ", must be 0 or from ", kFewestCoefficients, " to ",
                           kMostCoefficients);
  }
  if (!(tolerance > 0.0) || !(tolerance < 1.0)) {
    return InvalidArgument("tolerance=", tolerance,
                           ", must be between 0 and 1");
  }
  if (Holds(type, form)) return absl::OkStatus();
  return InvalidArgument(
      "form=", std::string(NameOf(form)),
      ": a file of this type does not "
      "hold it; .json holds all forms but element_table, .csv element_table "
      "and step_responses, .mat transfer_functions and step_responses");
}

absl::StatusOr<ConvertedModel> ConvertModel(const ModelFile& file,
                                            const ModelConversion& conversion) {
  MLE_RETURN_IF_ERROR(conversion.Validate());
  return Converter(file, conversion).Convert();
}

}  // namespace mle
