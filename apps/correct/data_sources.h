// The sources that --data names: files and databases, and the checksums by
// which a result can be tied to what it was made from.
//
//   MLE_ASSIGN_OR_RETURN(const DataSources sources,
//                        DataSources::Create({"a.csv"}, {}, import));
//   LoadSources(sources.sources(), …);
//   sources.Files();

#ifndef APPS_CORRECT_DATA_SOURCES_H_
#define APPS_CORRECT_DATA_SOURCES_H_

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "mle/data/historian.h"
#include "mle/database/database_options.h"

namespace mle::correct {

// A file as it was read; of a database its name and the rows as CSV.
struct DataFile {
  std::string path = {};
  std::string sha256 = {};  // of its bytes, hexadecimal
  std::int64_t bytes = 0;
};

// Reads the file block by block; of "-" what standard input had. Errors name
// the path.
absl::StatusOr<DataFile> ReadDataFile(const std::string& path);

class DataSources {
 public:
  // Reads the files for their checksums. Errors name the file, and as of
  // RecordSources().
  static absl::StatusOr<DataSources> Create(
      const std::vector<std::string>& names, const DatabaseOptions& database,
      const HistorianOptions& import);

  const std::vector<HistorianSource>& sources() const { return sources_; }
  // In the order of the names. Databases have a checksum once they have been
  // read to their end.
  std::vector<DataFile> Files() const;

 private:
  std::vector<HistorianSource> sources_;
  std::vector<std::shared_ptr<DataFile>> files_;
};

}  // namespace mle::correct

#endif  // APPS_CORRECT_DATA_SOURCES_H_
