// Responses of each element of a model to each input, in the parts of records
// around changes of set points: the material of tests that ask whether another
// assignment of tags, other units or another clock explain the records better.

#ifndef MLE_MAINTAIN_ELEMENT_RESPONSES_H_
#define MLE_MAINTAIN_ELEMENT_RESPONSES_H_

#include <vector>

#include "Eigen/Core"
#include "absl/status/statusor.h"
#include "mle/data/record.h"
#include "mle/maintain/whitened_fit.h"
#include "mle/model/process_model.h"

namespace mle {

// Up to 1,000 samples on each side of every change, 8,000 or `most_samples` in
// all (the first ones), whatever the model's time constants: these may be in
// another unit. Records without changes are taken as they are. Gaps of outputs
// are bridged by straight lines, those of inputs by holding.
std::vector<Record> AroundSetPointChanges(const std::vector<Record>& records,
                                          double most_samples);

// The record with its gaps bridged so.
Record WithoutGaps(const Record& record);

class ElementResponses {
 public:
  // Responses of the elements of one input: for each part N × as many as are
  // not zero.
  using OfInput = std::vector<Eigen::MatrixXd>;

  // N E numbers are held, of N samples and E elements that are not zero.
  // `parts` must outlive this; the model's times are multiplied by
  // `time_scale`. Errors as of SimulateResponse().
  static absl::StatusOr<ElementResponses> Create(
      const ProcessModel& model, const std::vector<Record>& parts,
      double time_scale = 1.0);

  const OfInput& Of(int input) const { return responses_[input]; }
  // Responses of the elements of `input` to another recorded input.
  absl::StatusOr<OfInput> Of(int input, int recorded) const;
  // The column of element (output, input) there; -1: it is zero.
  int ColumnOf(int output, int input) const {
    return columns_[output * num_inputs_ + input];
  }
  bool integrates(int output) const { return integrating_[output]; }

  // Output `output` and what its elements, zero ones included, make of the
  // inputs; of an output that integrates the increments of both.
  WhitenedData Row(int output) const;

 private:
  const std::vector<Record>* parts_ = nullptr;
  double time_scale_ = 1.0;
  int num_inputs_ = 0;
  std::vector<bool> integrating_;       // p
  std::vector<int> columns_;            // p m
  std::vector<ProcessModel> of_input_;  // m: its elements, in turn
  std::vector<OfInput> responses_;      // m
};

}  // namespace mle

#endif  // MLE_MAINTAIN_ELEMENT_RESPONSES_H_
