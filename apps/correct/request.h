// The request to mle_correct: its options, and what they name.

#ifndef APPS_CORRECT_REQUEST_H_
#define APPS_CORRECT_REQUEST_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/common/option_table.h"
#include "apps/correct/next_move.h"
#include "control/mpc_options.h"
#include "mle/data/historian.h"
#include "mle/database/database_options.h"
#include "mle/exchange/model_file.h"
#include "mle/maintain/correct.h"
#include "mle/maintain/records.h"
#include "mle/model/process_model.h"

namespace mle::correct {

// The result of an earlier run, to be compared with.

// A parameter as it was estimated with all elements free.
struct PreviousEstimate {
  std::string output;
  std::string input;
  std::string name;  // "gain", "time_constant", "delay"
  double value = 0.0;
  double lower = 0.0;
  double upper = 0.0;
};

struct PreviousRun {
  std::string folder;
  std::string decision;  // as in result.json
  std::string until;     // the end of its last window; empty: no dates
  std::vector<PreviousEstimate> estimates;
};

// Reads `folder`/result.json. InvalidArgument where it is not a result of a
// version known here, or of a model with other channels.
absl::StatusOr<PreviousRun> ReadPreviousRun(const std::string& folder,
                                            const ProcessModel& model);

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
  NextMoveOptions next_move;
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

// A run that looks at some of a model's outputs only: those that are asked for,
// or those whose tags the records have. The inputs that move none of them are
// left out too. What is written in the form of the model given has all of it,
// corrected where the part is.

// Keeps only request.outputs, if there are any, and their inputs.
// InvalidArgument names an output that the model does not have.
absl::Status ChooseOutputs(Request& request);

// Leaves out the outputs that have no column in the sources, and those that an
// input without a column moves. False, and nothing is done, if there is no such
// output, or no other. A column of nearly the name is one that was meant.
bool LeaveOutMissing(const std::vector<HistorianSource>& sources,
                     Request& request);

// The whole model with this one in place of its part.
ProcessModel InWholeModel(const Request& request, const ProcessModel& part);

// The options of mle_correct that say how records are read and cut.

// Options of databases: query, table and columns.
std::vector<Option> OptionsOf(DatabaseOptions& database);

// `tags` are the texts TAG=CHANNEL…, `tag_file` the path of a file of tags.
std::vector<Option> OptionsOf(HistorianOptions& import,
                              std::vector<std::string>& tags,
                              std::string* tag_file);

std::vector<Option> OptionsOf(RecordOptions& options);

// The tags' columns, of both. InvalidArgument names the flag and what it
// expects.
absl::Status ParseTags(const std::vector<std::string>& tags,
                       const std::string& tag_file, const ProcessModel& model,
                       ColumnOptions& columns);

}  // namespace mle::correct

#endif  // APPS_CORRECT_REQUEST_H_
