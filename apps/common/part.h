// One part of work that several runs of a command share: --part=3/16 is the
// third of 16. The runs are tasks of a job array, jobs of GNU parallel or other
// machines; a run without --part then brings the parts together.

#ifndef APPS_COMMON_PART_H_
#define APPS_COMMON_PART_H_

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "apps/common/option_values.h"

namespace mle {

struct Part {
  int number = 1;  // from 1 to count
  int count = 1;
  std::string text = {};  // "3/16"; empty: everything

  bool is_everything() const { return text.empty(); }
  // Whether the piece of work of that number, counted from 0, belongs to it.
  bool Has(std::int64_t piece) const { return piece % count == number - 1; }
  // The same for what has a name: by the name alone, so that it stays in its
  // part when others come and go.
  bool Has(std::string_view name) const;
  // Where the part's results are below `folder`: FOLDER/parts/3-of-16, or
  // FOLDER itself for everything.
  std::string FolderBelow(const std::string& folder) const;
};

// "3/16", or empty for everything. InvalidArgument says what would be right.
absl::StatusOr<Part> ParsePart(const std::string& text);

// As the value of an option.
TextValue PartOfWork(Part* part);

}  // namespace mle

#endif  // APPS_COMMON_PART_H_
