// A model from the form of one file to that of another, with the error stated:
//
//   MLE_ASSIGN_OR_RETURN(const ModelFile file, ReadModelFile("column.csv"));
//   ModelConversion to;
//   to.form = ModelForm::kStateSpace;
//   MLE_ASSIGN_OR_RETURN(const ConvertedModel converted,
//                        ConvertModel(file, to));
//   Write(converted.text, converted.differences.maxCoeff());
//
// Transfer functions are in the middle: `file.process`, exact or the
// description of step responses. From there
//
//   transfer functions, discrete ones   are exact (held inputs);
//   step responses                      exact to the last coefficient;
//   a state space                       is reduced (balanced_reduction.h);
//   a table                             has the nearest of second order.
//
// Step responses of a discrete form are taken from it itself. ARX models are
// written by mle_correct alone: their order follows from the noise that they
// are to predict under, which no other form has.

#ifndef MLE_EXCHANGE_MODEL_CONVERSION_H_
#define MLE_EXCHANGE_MODEL_CONVERSION_H_

#include <optional>
#include <string>
#include <string_view>

#include "Eigen/Core"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "mle/exchange/model_file.h"

namespace mle {

// The form that is named "step_responses" …; nothing for other names.
std::optional<ModelForm> ModelFormOf(std::string_view name);

struct ModelConversion {
  ModelForm form = ModelForm::kTransferFunctions;
  ModelFileType type = ModelFileType::kJson;
  // Interval of coefficients, sample time of discrete forms, in the unit of
  // time, ≥ 0; 0: that of the file, where it has one, else a sixtieth of the
  // settling time, rounded up to 1, 2 or 5 times a power of ten.
  double interval = 0.0;
  // Number of coefficients of step responses, 0 or from kFewestCoefficients to
  // 100,000; 0: as many as the file has, else up to the settling time.
  int coefficients = 0;
  // Largest error of an element of a state space, relative to the element's
  // largest response, in (0, 1).
  double tolerance = 1e-3;

  // Names the field, its value and the constraint broken; a form that the type
  // of file does not hold.
  absl::Status Validate() const;
};

struct ConvertedModel {
  std::string text;       // of the file
  double interval = 0.0;  // that was taken; 0 where the form has none
  int states = 0;         // of a state space
  // p × m: the largest difference of a step response, relative to its range, at
  // most: what the description misses of the file's and what the form misses of
  // the description. Of coefficients also what the response still moves after
  // the last one. 0 where pairs are exact, to rounding, or zero.
  Eigen::MatrixXd differences;
};

// InvalidArgument for options and models that do not fit, FailedPrecondition
// where there is no state space within the tolerance, Internal as FormatMat().
absl::StatusOr<ConvertedModel> ConvertModel(const ModelFile& file,
                                            const ModelConversion& conversion);

}  // namespace mle

#endif  // MLE_EXCHANGE_MODEL_CONVERSION_H_
