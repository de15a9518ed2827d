// What mle_watch is asked to do.

#ifndef APPS_WATCH_REQUEST_H_
#define APPS_WATCH_REQUEST_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "apps/watch/shard.h"
#include "apps/watch/watch_file.h"

namespace mle::watch {

struct Request {
  std::string watch_path;     // of the file that lists the controllers
  std::string out = "watch";  // folder of pages and proposals
  std::string state;          // file or PostgreSQL; empty: OUT/state.sqlite
  std::string alarm_command;  // program; empty: none
  bool propose = true;
  bool update = true;  // false: pages and alarms of what is in the state
  std::string shard_text;
  int threads = 0;

  Shard shard;
  std::vector<Controller> controllers;  // of the shard
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

// Reads the file. Errors name the option.
absl::Status Complete(Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_REQUEST_H_
