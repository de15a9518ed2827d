// A part of the controllers, for one of several runs that share them: tasks of
// a job array, or machines.

#ifndef APPS_WATCH_SHARD_H_
#define APPS_WATCH_SHARD_H_

#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace mle::watch {

struct Shard {
  int number = 1;  // from 1 to count
  int count = 1;
  std::string text = {};  // "3/16"; empty: all controllers

  bool is_everything() const { return text.empty(); }
  // Whether the controller of that name belongs to it: by the name alone, so
  // that controllers stay where they are when others come and go.
  bool Has(std::string_view controller) const;
  // "3-of-16", for names of folders.
  std::string Name() const;
};

// "3/16", or empty for everything. InvalidArgument says what would be right.
absl::StatusOr<Shard> ParseShard(const std::string& text);

}  // namespace mle::watch

#endif  // APPS_WATCH_SHARD_H_
