// The list of controllers of mle_watch.

#include <set>
#include <string>

#include "apps/watch/watch_file.h"
#include "tests/fuzz/fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data,
                                      std::size_t size) {
  const std::string_view text = mle::fuzz::Bytes(data, size).Rest();
  const auto controllers = mle::watch::ParseWatchFile(text, "folder/list.json");
  if (!controllers.ok()) {
    FUZZ_EXPECT(controllers.status().message().find("folder/list.json") !=
                std::string::npos);
    return 0;
  }
  std::set<std::string> names;
  for (const mle::watch::Controller& controller : *controllers) {
    FUZZ_EXPECT(names.insert(controller.name).second, controller.name);
    FUZZ_EXPECT(controller.name.find('/') == std::string::npos);
    FUZZ_EXPECT(controller.options.Validate().ok());
    FUZZ_EXPECT(controller.reference_days >= 2);
  }
  return 0;
}
