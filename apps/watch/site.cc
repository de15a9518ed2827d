#include "apps/watch/site.h"

#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "apps/watch/report.h"
#include "apps/watch/update.h"
#include "mle/base/parallel.h"
#include "mle/base/status.h"
#include "mle/database/record_sources.h"
#include "mle/exchange/model_file.h"

namespace mle::watch {
namespace {

// Bytes of pages that are kept; a page of a controller has some 20 kB.
constexpr std::size_t kMostKept = 16'000'000;
// Reading takes at most an eleventh of the time.
constexpr int kRest = 10;

// Device and inode; zeros where there is none, and of a database.
std::pair<std::uint64_t, std::uint64_t> FileOf(const std::string& path) {
  struct stat about = {};
  if (IsDatabase(path) || stat(path.c_str(), &about) != 0) return {0, 0};
  return {about.st_dev, about.st_ino};
}

Snapshot::Text Shared(std::string text) {
  return std::make_shared<const std::string>(std::move(text));
}

// Drops what only a controller's own page needs.
void Trim(Entry& entry) {
  entry.watch.files.clear();
  entry.watch.days.clear();
  entry.watch.outputs.clear();
  entry.watch.trials.clear();
  entry.report.trends.clear();
  for (OutputTrend& trend : entry.report.outlook.trends) {
    trend.course.points.clear();
  }
}

}  // namespace

std::vector<Report> Snapshot::Reports() const {
  std::vector<Report> reports;
  reports.reserve(entries.size());
  for (const auto& entry : entries) reports.push_back(entry->report);
  return reports;
}

absl::StatusOr<std::unique_ptr<Site>> Site::Open(Options options) {
  MLE_ASSIGN_OR_RETURN(State state, State::Open(options.state));
  return std::unique_ptr<Site>(new Site(std::move(options), std::move(state)));
}

Site::Site(Options options, State state)
    : options_(std::move(options)),
      file_(FileOf(options_.state)),
      state_(std::move(state)) {}

absl::Status Site::CheckFile() const {
  if (FileOf(options_.state) == file_) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(
      options_.state,
      " has been removed or replaced while the server runs. Stop the server "
      "and all runs, remove ",
      options_.state, "-wal and ", options_.state,
      "-shm, put the right file in place and start again"));
}

std::shared_ptr<const Snapshot> Site::snapshot() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return snapshot_;
}

absl::StatusOr<std::shared_ptr<Entry>> Site::Load(const Controller& controller,
                                                  const Entry* before) {
  auto entry = std::make_shared<Entry>();
  entry->controller = controller;
  const absl::StatusOr<ModelFile> file = ReadModelFile(controller.model);
  const ProcessModel model = file.ok() ? file->process : ProcessModel();
  absl::StatusOr<Watch> loaded;
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    loaded = state_.Load(controller.name, model.num_outputs());
    entry->reading = ++readings_;
  }
  // One that is damaged is shown as such, beside the others.
  const absl::Status status = loaded.status();
  if (!status.ok() && !absl::IsDataLoss(status)) return status;
  Watch& watch = entry->watch;
  watch = status.ok() ? *std::move(loaded)
                      : EmptyWatch(controller.name, model.num_outputs());
  if (!status.ok()) {
    watch.failed = true;
    watch.news = std::string(status.message());
  } else if (!file.ok()) {
    watch.failed = true;
    watch.news = absl::StrCat("model: ", file.status().message());
  } else if (watch.id == 0) {
    watch.news = "No run has looked at it yet.";
  }
  entry->basis = BasisOf(controller, model);
  const bool is_same = before != nullptr && !watch.checksum.empty() &&
                       watch.checksum == before->watch.checksum &&
                       entry->basis == before->basis;
  entry->report = MakeReport(entry->controller, model, watch,
                             is_same ? &before->report : nullptr);
  return entry;
}

void Site::Publish(std::vector<std::shared_ptr<const Entry>> entries) {
  const std::shared_ptr<const Snapshot> before = this->snapshot();
  for (std::shared_ptr<const Entry>& entry : entries) {
    if (before == nullptr) break;
    const auto found = before->by_id.find(FileNameOf(entry->controller.name));
    if (found == before->by_id.end()) continue;
    const std::shared_ptr<const Entry>& shown = before->entries[found->second];
    if (shown->reading > entry->reading && shown->basis == entry->basis) {
      entry = shown;
    }
  }
  auto snapshot = std::make_shared<Snapshot>();
  snapshot->entries = std::move(entries);
  for (std::size_t i = 0; i < snapshot->entries.size(); ++i) {
    snapshot->by_id[FileNameOf(snapshot->entries[i]->controller.name)] = i;
  }
  snapshot->read_at = absl::ToUnixSeconds(absl::Now());
  const std::vector<Report> reports = snapshot->Reports();
  snapshot->overview = Shared(FormatOverview(reports));
  snapshot->alarms = Shared(FormatAlarmsPage(reports));
  snapshot->watch_json = Shared(FormatReports(reports));
  snapshot->controllers_json = Shared(FormatControllers(reports));
  snapshot->metrics = Shared(FormatMetrics(reports, snapshot->read_at));
  const std::lock_guard<std::mutex> lock(mutex_);
  snapshot_ = std::move(snapshot);
  kept_.clear();
  kept_bytes_ = 0;
}

absl::StatusOr<std::int64_t> Site::Revision() {
  MLE_RETURN_IF_ERROR(CheckFile());
  const std::lock_guard<std::mutex> lock(state_mutex_);
  absl::StatusOr<std::int64_t> revision = state_.Revision();
  if (revision.ok()) return revision;
  // A database that was gone is asked anew; its numbers may begin anew, too.
  MLE_ASSIGN_OR_RETURN(state_, State::Open(options_.state));
  revision_.reset();
  return state_.Revision();
}

absl::Status Site::RefreshAll(const std::function<bool()>& stop) {
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(options_.list, error);
  MLE_ASSIGN_OR_RETURN(const std::int64_t revision, Revision());
  const std::shared_ptr<const Snapshot> before = snapshot();
  if (before != nullptr && before->fault.empty() && revision == revision_ &&
      changed == list_changed_) {
    return absl::OkStatus();
  }
  MLE_ASSIGN_OR_RETURN(const std::vector<Controller> controllers,
                       ReadWatchFile(options_.list));
  const Clock::time_point begin = Clock::now();
  std::map<std::string, const Entry*> known;
  if (before != nullptr && changed == list_changed_) {
    for (const auto& entry : before->entries) {
      known[entry->controller.name] = entry.get();
    }
  }
  std::vector<std::shared_ptr<const Entry>> entries(controllers.size());
  std::vector<absl::Status> statuses(controllers.size());
  std::atomic<bool> stopped = false;
  ParallelFor(
      static_cast<int>(controllers.size()), options_.threads, [&](int i) {
        if (stopped || (stop != nullptr && stop())) {
          stopped = true;
          return;
        }
        const auto found = known.find(controllers[i].name);
        absl::StatusOr<std::shared_ptr<Entry>> entry = Load(
            controllers[i], found == known.end() ? nullptr : found->second);
        statuses[i] = entry.status();
        if (!entry.ok()) return;
        Trim(**entry);
        entries[i] = *std::move(entry);
      });
  if (stopped) return absl::OkStatus();
  for (const absl::Status& status : statuses) MLE_RETURN_IF_ERROR(status);
  {
    const std::lock_guard<std::mutex> lock(publish_mutex_);
    Publish(std::move(entries));
  }
  const Clock::time_point end = Clock::now();
  // The first reading finds nothing to keep, and is longer than others.
  if (before != nullptr) next_refresh_ = end + kRest * (end - begin);
  revision_ = revision;
  list_changed_ = changed;
  return absl::OkStatus();
}

absl::Status Site::Refresh(const std::function<bool()>& stop) {
  if (Clock::now() < next_refresh_) return absl::OkStatus();
  const absl::Status status = RefreshAll(stop);
  if (status.ok()) return absl::OkStatus();
  const std::lock_guard<std::mutex> lock(mutex_);
  if (snapshot_ == nullptr) return status;
  if (snapshot_->fault == status.message()) return absl::OkStatus();
  auto stale = std::make_shared<Snapshot>(*snapshot_);
  stale->fault = std::string(status.message());
  const std::vector<Report> reports = stale->Reports();
  stale->overview = Shared(FormatOverview(reports, stale->fault));
  stale->metrics = Shared(FormatMetrics(reports, stale->read_at, stale->fault));
  snapshot_ = std::move(stale);
  return absl::OkStatus();
}

absl::StatusOr<Snapshot::Text> Site::Read(const Entry& entry, Detail detail) {
  const std::string key = absl::StrCat(
      detail == Detail::kPage ? "page " : "json ", entry.controller.name);
  std::shared_ptr<const Snapshot> current;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    current = snapshot_;
    const auto kept =
        std::find_if(kept_.begin(), kept_.end(),
                     [&](const Kept& text) { return text.key == key; });
    if (kept != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, kept);
      return kept_.front().text;
    }
  }
  MLE_ASSIGN_OR_RETURN(const std::shared_ptr<Entry> read,
                       Load(entry.controller));
  Snapshot::Text text =
      Shared(detail == Detail::kPage
                 ? FormatControllerPage(read->report, options_.folder,
                                        options_.can_acknowledge)
                 : FormatController(read->report));
  const std::lock_guard<std::mutex> lock(mutex_);
  // A text that was read before a change is not kept after it.
  if (snapshot_ != current) return text;
  kept_.push_front({key, text});
  kept_bytes_ += text->size();
  while (kept_bytes_ > kMostKept && !kept_.empty()) {
    kept_bytes_ -= kept_.back().text->size();
    kept_.pop_back();
  }
  return text;
}

absl::StatusOr<std::string> Site::ReadHistory(const Entry& entry, int from,
                                              int to) {
  MLE_ASSIGN_OR_RETURN(const std::shared_ptr<Entry> read,
                       Load(entry.controller));
  return FormatHistory(read->report, from, to);
}

absl::Status Site::Acknowledge(const std::string& alarm,
                               const Acknowledgement& acknowledgement) {
  MLE_RETURN_IF_ERROR(CheckFile());
  {
    const std::lock_guard<std::mutex> lock(state_mutex_);
    MLE_RETURN_IF_ERROR(state_.Acknowledge(alarm, acknowledgement));
  }
  const std::lock_guard<std::mutex> lock(publish_mutex_);
  std::vector<std::shared_ptr<const Entry>> entries = snapshot()->entries;
  for (std::shared_ptr<const Entry>& entry : entries) {
    const std::vector<Alarm>& alarms = entry->watch.alarms;
    if (std::none_of(alarms.begin(), alarms.end(),
                     [&](const Alarm& raised) { return raised.id == alarm; })) {
      continue;
    }
    MLE_ASSIGN_OR_RETURN(std::shared_ptr<Entry> read, Load(entry->controller));
    Trim(*read);
    entry = std::move(read);
  }
  Publish(std::move(entries));
  return absl::OkStatus();
}

}  // namespace mle::watch
