// A site with a state of its own, as a run leaves it.

#ifndef TESTS_APPS_WATCH_WATCHED_SITE_H_
#define TESTS_APPS_WATCH_WATCHED_SITE_H_

#include <string>
#include <vector>

#include "apps/watch/state.h"
#include "apps/watch/watch_file.h"
#include "tests/mle/base/scratch_folder.h"

namespace mle::watch {

// A folder with a tank's model, whose tag is hostile markup, a list of
// controllers "a 1", "b" and "c", and a state in which "a 1" has one alarm,
// "b" is healthy and "c" has not been looked at.
class WatchedSite {
 public:
  WatchedSite();

  std::string List() const { return folder_ / "controllers.json"; }
  std::string StatePath() const { return folder_ / "state.sqlite"; }
  const std::string& folder() const { return folder_.path(); }
  State OpenState() const;

  // Without a state: of `number` outputs, an alarm where `is_aged`.
  static Watch MakeWatch(const std::string& controller, bool is_aged);

 private:
  const ScratchFolder folder_;
};

inline constexpr char kAlarmId[] = "0123456789abcdef0123456789abcdef";
inline constexpr char kHostileTag[] =
    "<b data-injected=1>\"'&\\</script><script>x</script>";

}  // namespace mle::watch

#endif  // TESTS_APPS_WATCH_WATCHED_SITE_H_
