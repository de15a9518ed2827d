// The request to mle_correct: its options, and what they name.

#ifndef APPS_CORRECT_REQUEST_H_
#define APPS_CORRECT_REQUEST_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "apps/common/option_table.h"
#include "apps/correct/previous_run.h"
#include "control/mpc_options.h"
#include "mle/data/historian.h"
#include "mle/database/database_options.h"
#include "mle/exchange/model_file.h"
#include "mle/maintain/correct.h"
#include "mle/model/process_model.h"

namespace mle::correct {

struct Request {
  // Options as they are given.
  std::string model_path;  // empty: a model in memory
  std::vector<std::string> data_paths;
  std::string out = "correction";
  std::string truth_path;  // empty: none
  std::vector<std::string> tags;
  std::string tag_file;              // empty: none
  std::string propose_tags;          // empty: a correction is wanted
  std::vector<std::string> outputs;  // that are judged; empty: all
  HistorianOptions import;
  DatabaseOptions database;
  CorrectOptions options;
  // As it is tuned, for the advice.
  control::MpcOptions controller;
  std::string previous;  // folder of the last run; empty: none
  bool dry_run = false;
  bool verbose = false;
  bool json = false;  // result.json on standard output, in place of the verdict
  bool figures = true;

  // Models and results that the options name.
  ModelFile model_file;  // of its process model, `model` is all or a part
  ProcessModel model;
  std::vector<Message> left_out;  // outputs that the records do not have
  std::optional<ProcessModel> truth;
  std::optional<PreviousRun> last;

  // A control period of 0 stands for a controller that was not told.
  bool controller_known() const { return controller.control_period > 0.0; }
};

// Both must outlive the program's flags. The controller is not told unless its
// option is given.
void AddOptions(Request& request, OptionTable& table);

// Reads the models that the options name, and what depends on them. Errors name
// the option, what was found and what would be right.
absl::Status Complete(Request& request, OptionTable& table);

// The same where the models are in the request already.
absl::Status CompleteForModel(Request& request, OptionTable& table);

}  // namespace mle::correct

#endif  // APPS_CORRECT_REQUEST_H_
