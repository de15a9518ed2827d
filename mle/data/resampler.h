// Resamples rows at any times to samples every Δt, by the rules of historian.h.
// Internal to mle/data.
//
// Memory is that of a few samples, whatever the number of rows.

#ifndef MLE_DATA_RESAMPLER_H_
#define MLE_DATA_RESAMPLER_H_

#include <functional>
#include <vector>

namespace mle {

struct ResamplerOptions {
  double sample_time = 0.0;  // Δt
  double step = 0.0;         // usual spacing of rows
  double max_gap = 0.0;      // rows missing for longer end a record
  int num_outputs = 0;       // p
  int num_inputs = 0;        // m
  // By value (2p + m), or empty: by how much its stamps are late, and whether
  // it is measured at single rows, each of which is the sample nearest to it.
  std::vector<double> late = {};
  std::vector<bool> is_point = {};
};

class Resampler {
 public:
  // A sample: its 2p + m values (outputs, set points, inputs). `begins` where
  // a record begins with it.
  using Sink =
      std::function<void(bool begins, double time, const std::vector<double>&)>;

  Resampler(const ResamplerOptions& options, Sink sink);

  // True if the files are finer than Δt and outputs are means.
  bool averages() const { return averages_; }

  // Times must increase. Values NaN where bad; those of a row (2p + m).
  void Add(double time, const std::vector<double>& values);
  // Emits the remaining samples.
  void Finish();

 private:
  // Sums of what falls into one sample.
  struct Cell {
    std::vector<double> sum;
    std::vector<double> weight;
  };

  void Begin(double time, const std::vector<double>& values);
  void AddSegment(double to, const std::vector<double>* values);
  void AddPiece(double from, double to, double shift, int first, int last,
                const std::vector<double>& values);
  void AddSetPoints(double to, bool is_usual);
  void AddBetween(double to, const std::vector<double>& values);
  void SetOutputs(double at, const std::vector<double>& values);
  void Set(double sample, int value, double to);
  Cell& CellAt(double index);
  void EmitUpTo(double end);

  ResamplerOptions options_;
  Sink sink_;
  double step_;   // all in units of Δt from here on
  double split_;  // rows farther apart are of two records
  bool averages_;
  int num_values_;
  std::vector<double> late_;  // samples
  std::vector<bool> is_point_;
  double latest_ = 0.0;

  bool has_row_ = false;
  bool begins_ = false;
  double origin_ = 0.0;  // time of the record's first row
  double at_ = 0.0;      // of the last row, since origin_
  std::vector<double> last_;
  double next_ = 0.0;        // the first sample not yet given to the sink
  std::vector<Cell> cells_;  // from next_ on
  Cell empty_;
  std::vector<double> sample_;
};

}  // namespace mle

#endif  // MLE_DATA_RESAMPLER_H_
