// The state of the watch: all that it remembers of its controllers, in one
// SQLite file or in PostgreSQL.
//
//   watch     a controller from a day on, with one model and one set of options
//   file      files of records that were read, as they were
//   day       that was looked at: checksum of its samples, state
//   score     of an output: score, information and evidence of a day, or of
//             several that were merged
//   alarm     raised; by whom, when and with which note it was acknowledged
//   delivery  of an alarm through a channel (command, mail, webhook): whether
//             it has arrived, how often it was tried, what was wrong
//   proposal  corrections that were run
//   trial     of corrections, beside the model in use
//
// A watch is read whole, changed in memory and written back in one transaction:
// a kill leaves the state of before or after. With it goes a checksum of
// everything that evidence rests on; a watch that does not fit it is damaged,
// and neither shown nor carried on. The version of the tables is in
// user_version, or a table `version`; a state of another version is refused.

#ifndef APPS_WATCH_STATE_H_
#define APPS_WATCH_STATE_H_

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/watch/database.h"
#include "mle/monitor/change_evidence.h"
#include "mle/monitor/model_watch.h"
#include "mle/trial/trial_state.h"

namespace mle::watch {

inline constexpr int kStateVersion = 7;

struct SeenFile {
  std::int64_t bytes = 0;
  std::int64_t changed = 0;  // ns since 1970, as the file system says
  // Times of its first and last row, s since 1970; 0 where the file could not
  // be read.
  double first = 0.0;
  double last = 0.0;
  std::string fault = {};

  bool operator==(const SeenFile&) const = default;
};

struct SeenDay {
  std::string checksum;  // of its samples and those before that act on it
  BatchState state = BatchState::kNothingMoved;
  std::string reason = {};  // of kCannotTell

  bool operator==(const SeenDay&) const = default;
};

// The score of one output from a day, or from several that were merged, and the
// evidence after it. Numbers are days since the watch's first.
struct StoredBatch {
  ScoredBatch batch;
  ChangeEvidence evidence;  // after it
};

// How alarms leave the machine.
enum class Channel { kCommand, kMail, kWebhook };
inline constexpr Channel kChannels[] = {Channel::kCommand, Channel::kMail,
                                        Channel::kWebhook};

// "command", "mail", "webhook".
std::string_view NameOf(Channel channel);

struct Delivery {
  enum class State { kToSend, kBeingSent, kSent };
  Channel channel = Channel::kCommand;
  State state = State::kToSend;
  int attempts = 0;
  std::string fault = {};  // of the last attempt, in words
};

struct Acknowledgement {
  std::string who = {};
  std::int64_t at = 0;  // s since 1970
  std::string note = {};
};

// Now, by `who`. InvalidArgument without a name, or where name or note are too
// long.
absl::StatusOr<Acknowledgement> MakeAcknowledgement(const std::string& who,
                                                    const std::string& note);

enum class AlarmKind { kAged, kAdopt, kDrop, kRollBack };

// "aged", "adopt", "drop", "roll_back".
std::string_view NameOf(AlarmKind kind);

struct Alarm {
  std::string id = {};  // the same for the same alarm, whenever it is raised
  AlarmKind kind = AlarmKind::kAged;
  int output = 0;  // −1: of a trial, which is of none
  int element =
      -1;       // of those present in the row; −1: of the output as a whole
  int day = 0;  // since 1970
  // Day that the change most likely began on; of a trial, of its correction.
  int began = 0;
  std::string text = {};
  // As the state has them; saving a watch changes neither.
  std::vector<Delivery> deliveries = {};  // that were tried
  std::optional<Acknowledgement> acknowledged = {};
};

// The id of an alarm of which this is said.
std::string AlarmId(const std::string& what);

// Those that say that the model has aged.
std::vector<Alarm> AlarmsOfAgeing(const std::vector<Alarm>& alarms);
// Those not acknowledged.
int CountOpen(const std::vector<Alarm>& alarms);

// Whether the channel was tried, and the alarm has not arrived.
bool IsUndelivered(const Alarm& alarm, Channel channel);

// An alarm on its way.
struct PendingAlarm {
  std::string controller;
  Alarm alarm;
  Delivery delivery;  // so far
};

struct Proposal {
  int day = 0;                  // since 1970: the last of its records
  std::string folder = {};      // of the files
  std::string decision = {};    // as in result.json, or "failed"
  std::string conclusion = {};  // in words
};

// The trial of a correction beside the model in use (mle/trial/model_trial.h).
struct Trial {
  int day = 0;       // of its correction
  int last_day = 0;  // that was looked at
  double sample_time = 0.0;
  std::string in_use = {};  // process models, as JSON
  std::string proposed = {};
  // "dropped", "rolled_back", "replaced" by another model, "kept" after many
  // responses; empty: it goes on.
  std::string ended = {};
  std::string fault = {};  // why it could not be begun, or look at a day
  // By whom and since which day the correction is in use.
  std::optional<Acknowledgement> adopted = {};
  int adopted_day = 0;
  TrialState state = {};
};

struct Watch {
  std::int64_t id = 0;  // 0: not in the state
  std::string controller;
  std::string basis;  // SHA-256 of model and options
  // SHA-256 of all that the evidence rests on, as it was saved; empty for a
  // watch that is not in the state.
  std::string checksum;
  // Days since 1970. Days before `begin` belong to an earlier watch; `first` is
  // the first with records, once the reference is made.
  int begin = 0;
  int first = 0;
  double sample_time = 0.0;
  std::optional<WatchReference> reference;
  std::string news;  // what the last run found, in words
  bool failed = false;

  std::map<std::string, SeenFile> files;            // by path
  std::map<int, SeenDay> days;                      // since 1970
  std::vector<std::map<int, StoredBatch>> outputs;  // p, by number
  std::vector<Alarm> alarms;
  std::vector<Proposal> proposals;
  std::vector<Trial> trials;  // in order of their days

  int last_day() const {
    return days.empty() ? begin - 1 : days.rbegin()->first;
  }
};

// The watch of a controller of which nothing is known yet.
Watch EmptyWatch(const std::string& controller, int outputs);

class State {
 public:
  // A file, or postgresql://USER@HOST/NAME. Makes the file and the tables if
  // they do not exist. FailedPrecondition for a state of another version,
  // Unavailable for a database that cannot be reached.
  static absl::StatusOr<State> Open(const std::string& path);

  // In PostgreSQL one run alone may go over all controllers (`part` empty), or
  // one over each part of them; Unavailable where there is one. Ends with the
  // state. For files the lock of their folder does that (LockState() in
  // run.cc).
  absl::Status Claim(const std::string& part) { return database_->Claim(part); }

  // The last watch of the controller, or a new one with `outputs` outputs.
  // DataLoss where it is damaged.
  absl::StatusOr<Watch> Load(const std::string& controller, int outputs);
  // All of it, in one transaction; gives a new watch its id.
  absl::Status Save(Watch& watch);
  // The alarms of the watch as they are now: others may have acknowledged some.
  absl::Status ReloadAlarms(Watch& watch);
  // Alarms that have not arrived through the channel and were not acknowledged
  // either: those tried least, and of these the oldest, first.
  absl::StatusOr<std::vector<PendingAlarm>> Undelivered(Channel channel);
  absl::Status SetDelivery(const std::string& alarm, const Delivery& delivery);
  // The id that begins so. NotFound, or InvalidArgument where several do.
  absl::StatusOr<std::string> FindAlarm(const std::string& beginning);
  // NotFound where there is no such alarm. An acknowledgement stays as it was
  // first made: AlreadyExists says by whom and when.
  absl::Status Acknowledge(const std::string& alarm,
                           const Acknowledgement& acknowledgement);
  // A number that changes once another connection has written to the state.
  absl::StatusOr<std::int64_t> Revision();

 private:
  explicit State(std::unique_ptr<Database> database)
      : database_(std::move(database)) {}

  absl::Status MakeTables();
  // With all outputs that there are.
  absl::StatusOr<Watch> Read(const std::string& controller);
  // Reads the files, days, scores and proposals of the watch with that id.
  absl::Status ReadRows(Watch& watch);
  absl::Status LoadAlarms(Watch& watch);
  absl::Status LoadTrials(Watch& watch);
  absl::Status SaveWatch(Watch& watch);
  absl::Status SaveFiles(const Watch& now, const Watch& before);
  absl::Status SaveDays(const Watch& now, const Watch& before);
  absl::Status SaveScores(const Watch& now, const Watch& before);
  absl::Status SaveAlarms(const Watch& now);
  absl::Status SaveTrials(const Watch& now, const Watch& before);
  // Saves the checksum of what the tables hold now.
  absl::Status SaveChecksum(const Watch& now);
  // A statement that gives no rows.
  absl::Status Write(const std::string& statement,
                     const std::vector<Value>& values) {
    return database_->Run(statement, values).status();
  }

  std::unique_ptr<Database> database_;
};

// How scores and references are kept in the state, and the checksum of all.
// Numbers are kept to the last bit, so that what is computed before and after
// does not differ.

// Doubles, little-endian: n, 1 where there is `largest` and 0 where not, the
// score and the lower triangle of the information of `largest`, where there is
// one, and of the batch, ln E of the output and of its n/3 elements.
std::string EncodeBatch(const StoredBatch& stored);
// DataLoss for other bytes, for scores that are not finite and for evidence
// that is not a number.
absl::StatusOr<StoredBatch> DecodeBatch(std::string_view bytes, int number,
                                        int length);

// The numbers of a trial's state, doubles, little-endian. DataLoss where they
// are not those of a state; whether it fits the models ModelTrial::Resume()
// says.
std::string EncodeTrial(const TrialState& state);
absl::StatusOr<TrialState> DecodeTrial(std::string_view bytes);

std::string EncodeReference(const WatchReference& reference);  // JSON
absl::StatusOr<WatchReference> DecodeReference(const std::string& json);

// SHA-256 of model and options, reference, files, days, scores, alarms,
// corrections and trials; not of deliveries and acknowledgements, which change
// alone, and of the words of the last run.
std::string ChecksumOf(const Watch& watch);

}  // namespace mle::watch

#endif  // APPS_WATCH_STATE_H_
