// The rows of a long table, with a row for each sample (tag, time, value and
// perhaps its quality), as those of a wide one, with a row for each time.
// Internal to mle/data.
//
//   tag;time;value                       time,TI101,FC7
//   TI101;2024-03-04 06:00;71.3   →      2024-03-04 06:00,71.3,12
//   FC7;2024-03-04 06:00;12              2024-03-04 06:01,71.4,
//   TI101;2024-03-04 06:01;71.4
//
// Fields keep their text, so that everything else is that of wide tables.

#ifndef MLE_DATA_WIDE_ROWS_H_
#define MLE_DATA_WIDE_ROWS_H_

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/data/long_table.h"
#include "mle/data/record_clock.h"
#include "mle/data/row_source.h"

namespace mle {

struct WideCounts {
  int tags = 0;
  std::int64_t rows = 0;  // of the wide table
  // Every tag of which samples are kept has one at every time.
  bool is_complete = true;
  // Rows that are left out: at a time already read, comments and the header
  // again.
  std::int64_t repeated_rows = 0;
  std::int64_t comment_rows = 0;
};

// The wide table.
class WideRows : public RowSource {
 public:
  // Reads all rows below the header. Of tags that are not among `channels` no
  // sample is kept, so that memory is that of the samples asked for; they are
  // left out if other columns are to be ignored, else columns without samples.
  // If repeated times are to be spread, samples of a tag at one time are rows
  // of their own. InvalidArgument for a time that `clock` does not read, two
  // samples of a tag at one time, and more than 4 · options.max_samples
  // samples.
  static absl::StatusOr<std::unique_ptr<WideRows>> Read(
      RowSource& rows, const std::vector<std::string>& header,
      const LongColumns& columns, const std::vector<std::string>& channels,
      const HistorianOptions& options, RecordClock clock);

  bool Next(std::vector<std::string_view>& fields) override;
  std::unique_ptr<RowSource> Preview() override;
  std::int64_t bytes_read() const override { return at_; }

  const WideCounts& counts() const;

 protected:
  std::pair<int, int> Origin(int line, int field) const override;

 private:
  class Samples;

  WideRows(std::shared_ptr<const Samples> samples, std::string source,
           bool is_table)
      : RowSource(std::move(source), is_table), samples_(std::move(samples)) {}

  std::shared_ptr<const Samples> samples_;
  std::int64_t at_ = 0;  // the next row; 0: the header
};

}  // namespace mle

#endif  // MLE_DATA_WIDE_ROWS_H_
