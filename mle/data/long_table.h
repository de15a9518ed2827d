// Long tables, with a row for each sample (tag, time, value and perhaps its
// quality), turned into wide ones, with a row for each time. Internal to
// mle/data.
//
//   tag;time;value                       time,TI101,FC7
//   TI101;2024-03-04 06:00;71.3   →      2024-03-04 06:00,71.3,12
//   FC7;2024-03-04 06:00;12              2024-03-04 06:01,71.4,
//   TI101;2024-03-04 06:01;71.4
//
// Fields keep their text, so that everything else is that of wide tables.

#ifndef MLE_DATA_LONG_TABLE_H_
#define MLE_DATA_LONG_TABLE_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/data/record_clock.h"
#include "mle/data/row_source.h"

namespace mle {

// Which column of a long table holds what; −1: none.
struct LongColumns {
  int time = 0;
  int time_part = -1;  // the rest of a time in two columns
  int tag = 0;
  int value = 0;
  int quality = -1;
  // Other columns of quality, all of which must be good.
  std::vector<int> other_qualities = {};
};

// Names of such columns, for the header to be found by.
std::vector<std::string> LongColumnNames(const ColumnOptions& options);

// Those of a header that names time, tag and value, as declared, by the names
// of `channels` that stand in one of the first `rows`, or by usual names;
// nothing for any other, and for a header that names a channel.
// InvalidArgument where tags stand in a column, but values or times are not
// certain, and for a declared column that is not there.
absl::StatusOr<std::optional<LongColumns>> FindLongColumns(
    const std::vector<std::string>& header,
    const std::vector<std::vector<std::string>>& rows,
    const std::vector<std::string>& channels, const ColumnOptions& options);

// The wide table, a source of rows that is made of a long one.
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

  std::int64_t rows() const;
  int tags() const;
  // Every tag of which samples are kept has one at every time.
  bool is_complete() const;
  // Rows that are left out: at a time already read, comments and the header
  // again.
  std::int64_t repeated_rows() const;
  std::int64_t comment_rows() const;

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

#endif  // MLE_DATA_LONG_TABLE_H_
