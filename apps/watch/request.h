// The request to mle_watch, as its flags give it.

#ifndef APPS_WATCH_REQUEST_H_
#define APPS_WATCH_REQUEST_H_

#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "apps/common/part.h"
#include "apps/serve/server.h"
#include "apps/watch/alarms.h"
#include "apps/watch/watch_file.h"

namespace mle::watch {

// Environment variables, for what others must not see on a command line.
inline constexpr char kTokenVariable[] = "MLE_WATCH_TOKEN";
inline constexpr char kWebhookVariable[] = "MLE_WATCH_WEBHOOK";

struct Request {
  std::string watch_path;     // of the file that lists the controllers
  std::string out = "watch";  // folder of pages and proposals
  std::string state;          // file or PostgreSQL; empty: OUT/state.sqlite
  AlarmTargets alarms;
  bool propose = true;
  bool update = true;  // false: pages and alarms of what is in the state
  Part part;           // of the controllers
  int threads = 0;

  // A server in place of a run.
  std::string serve;  // address; empty: no server
  std::vector<std::string> host_names;
  std::string token_file;

  // An acknowledgement in place of a run.
  std::string acknowledge;  // beginning of an alarm's id; empty: none
  std::string acknowledged_by;
  std::string note;

  std::vector<Controller> controllers;  // of the part
  serve::ServerOptions address;         // from `serve`
};

// Both must outlive the program's flags.
void AddOptions(Request& request, OptionTable& table);

// Reads the file. Errors name the option.
absl::Status Complete(Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_REQUEST_H_
