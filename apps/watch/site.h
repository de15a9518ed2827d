// The pages and answers that a server makes from the state of all watches.
//
// The data of the overview are kept in memory and read anew once the state or
// the list of controllers has changed; outlooks and costs are computed only for
// the controllers that have changed themselves. A controller's own page and
// history are read when they are asked for; the pages asked for last are kept
// until the next change.

#ifndef APPS_WATCH_SITE_H_
#define APPS_WATCH_SITE_H_

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "apps/serve/access.h"
#include "apps/serve/server.h"
#include "apps/watch/health.h"
#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"

namespace mle::watch {

// A controller as the state has it.
struct Entry {
  Controller controller;
  Watch watch;
  std::string basis;  // of controller and model as they are now
  // Which of all readings of the state it is: the later one is shown.
  std::uint64_t reading = 0;
  Report report;  // of `watch`
};

// All controllers at a time. Texts are shared with those who are sent them.
struct Snapshot {
  using Text = std::shared_ptr<const std::string>;

  std::vector<std::shared_ptr<const Entry>> entries;  // without days and scores
  std::map<std::string, std::size_t> by_id;           // IdOf(name) to index
  std::int64_t read_at = 0;                           // s since 1970
  std::string fault;  // why it is older than it should be
  Text overview, alarms, watch_json, controllers_json, metrics;

  std::vector<Report> Reports() const;
};

class Site {
 public:
  struct Options {
    std::string list;    // of the controllers
    std::string state;   // file
    std::string folder;  // of pages and corrections
    bool can_acknowledge = false;
    int threads = 0;  // 0: one for each processor
  };
  // Without a snapshot, which the first Refresh() makes.
  static absl::StatusOr<std::unique_ptr<Site>> Open(Options options);

  const Options& options() const { return options_; }
  // Null before the first reading.
  std::shared_ptr<const Snapshot> snapshot() const;

  // Reads anew what has changed; `stop` is asked between controllers. Where it
  // cannot be read, the snapshot stays and says why; an error without one.
  absl::Status Refresh(const std::function<bool()>& stop);

  enum class Detail { kPage, kJson };
  // The page or the JSON of one controller, read from the state unless it is
  // kept.
  absl::StatusOr<Snapshot::Text> Read(const Entry& entry, Detail detail);
  // The health of its outputs, day by day, from one day to another (since
  // 1970).
  absl::StatusOr<std::string> ReadHistory(const Entry& entry, int from, int to);

  // As State::Acknowledge(); at once in all that is shown.
  absl::Status Acknowledge(const std::string& alarm,
                           const Acknowledgement& acknowledgement);

 private:
  Site(Options options, State state);

  // `before`: what was known of it, of the same list; or null.
  absl::StatusOr<std::shared_ptr<Entry>> Load(const Controller& controller,
                                              const Entry* before = nullptr);
  absl::StatusOr<std::int64_t> Revision();
  absl::Status RefreshAll(const std::function<bool()>& stop);
  // With publish_mutex_ held. Of controllers that have been read since, what
  // was read last is kept.
  void Publish(std::vector<std::shared_ptr<const Entry>> entries);
  // Unavailable where another file has taken the place of the state's.
  absl::Status CheckFile() const;

  struct Kept {
    std::string key;
    Snapshot::Text text;
  };

  const Options options_;
  const std::pair<std::uint64_t, std::uint64_t> file_;  // device and inode
  std::mutex state_mutex_;                              // of what follows
  State state_;
  std::uint64_t readings_ = 0;

  // Used by the refreshing thread alone.
  std::optional<std::int64_t> revision_;
  std::filesystem::file_time_type list_changed_ = {};
  // Not the time of day, which may be set.
  using Clock = std::chrono::steady_clock;
  Clock::time_point next_refresh_ = Clock::time_point::min();

  std::mutex publish_mutex_;  // of who makes a snapshot of another
  mutable std::mutex mutex_;  // of what follows
  std::shared_ptr<const Snapshot> snapshot_;
  std::list<Kept> kept_;  // the last used first
  std::size_t kept_bytes_ = 0;
};

// The routes of the watch's server (docs/watch.md):
//
//   GET  /, /alarms.html, /controller-ID.html    the pages
//   GET  /proposals/ID/DAY/FILE                  of corrections
//   GET  /watch.json, /metrics
//   GET  /api/v1/controllers[?status=…&search=…]
//   GET  /api/v1/controllers/ID
//   GET  /api/v1/controllers/ID/history[?from=DAY&to=DAY]
//   GET  /api/v1/alarms[?open=true]
//   POST /api/v1/alarms/ID/acknowledgement       {"who": …, "note": …}
//   POST /acknowledge                            the same from a page's form

// Called by many threads at once.
serve::Response Answer(Site& site, const serve::Access& access,
                       const serve::Request& request);

}  // namespace mle::watch

#endif  // APPS_WATCH_SITE_H_
