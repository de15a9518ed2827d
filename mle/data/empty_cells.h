// Whether the empty fields of a wide table are bad samples, or stand for values
// that have not changed, as historians write that report by exception.
// Internal to mle/data.

#ifndef MLE_DATA_EMPTY_CELLS_H_
#define MLE_DATA_EMPTY_CELLS_H_

#include <cstdint>
#include <vector>

namespace mle {

// Looks at rows one by one.
class EmptyCells {
 public:
  void Add(const std::vector<double>& values);

  // Half of the fields are empty and hardly a row is; every channel that is
  // there has a sample now and then, at distances that vary. A slower tag among
  // others, with a sample in every tenth row, is no such table.
  bool MeanUnchanged() const;
  // Of the channels that are there.
  double share() const;

 private:
  struct Channel {
    std::int64_t samples = 0;
    std::int64_t last = 0;      // row of the last
    std::int64_t shortest = 0;  // rows from one to the next
    std::int64_t longest = 0;
  };
  std::vector<Channel> channels_;
  std::int64_t rows_ = 0;
  std::int64_t empty_rows_ = 0;
};

}  // namespace mle

#endif  // MLE_DATA_EMPTY_CELLS_H_
