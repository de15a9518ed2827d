// What each element of a model makes of each input, in the parts of records
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

// Samples × outputs × inputs² of all records, above which such tests are left
// out: their time would not be worth it.
inline constexpr double kMostProducts = 2e7;

// Up to 1,000 samples on each side of every change, 8,000 in all (the first
// ones), whatever the model's time constants: these may be in another unit.
// Records without changes are taken as they are. Gaps of outputs are bridged by
// straight lines, those of inputs by holding.
std::vector<Record> AroundSetPointChanges(const std::vector<Record>& records);

// The record with its gaps bridged so.
Record WithoutGaps(const Record& record);

// Which tag of the records is taken for each channel of the model, and by what
// all of the model's times are multiplied.
struct Assignment {
  std::vector<int> outputs;  // p
  std::vector<int> inputs;   // m
  double time_scale = 1.0;

  static Assignment AsRecorded(const ProcessModel& model);
};

class ElementResponses {
 public:
  // Which inputs an element is driven by: its own, or every one in turn, for
  // assignments of other tags to the inputs. For N samples and E elements that
  // are not zero N E numbers are held of the former and N E m of the latter,
  // and as many samples simulated.
  enum class Inputs { kOwn, kAll };

  // `parts` must outlive this. Errors as of SimulateResponse().
  static absl::StatusOr<ElementResponses> Create(
      const ProcessModel& model, const std::vector<Record>& parts,
      double time_scale, Inputs inputs = Inputs::kAll);

  // Output `output` of the model and what its elements, zero ones included,
  // make of the inputs; of an output that integrates the increments of both.
  // Of kOwn the inputs are as recorded.
  WhitenedData Row(const Assignment& assignment, int output) const;

 private:
  const std::vector<Record>* parts_ = nullptr;
  int num_inputs_ = 0;
  std::vector<bool> integrating_;  // p
  // Of each recorded input the column of element (i, j), at i m + j; -1: none.
  std::vector<std::vector<int>> columns_;
  // Of each part and recorded input: N × the elements that it drives.
  std::vector<std::vector<Eigen::MatrixXd>> responses_;
};

}  // namespace mle

#endif  // MLE_MAINTAIN_ELEMENT_RESPONSES_H_
