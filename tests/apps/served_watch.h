// mle_watch --serve, for tests.

#ifndef TESTS_APPS_SERVED_WATCH_H_
#define TESTS_APPS_SERVED_WATCH_H_

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/serve/client.h"
#include "tests/apps/started_command.h"

namespace mle {

// A server on any port, until it is stopped.
class ServedWatch {
 public:
  ServedWatch(const std::vector<std::string>& arguments, const std::string& log)
      : run_(MLE_TESTED_COMMAND, arguments, log) {
    run_.Await([&] {
      std::ostringstream text;
      text << std::ifstream(log).rdbuf();
      const std::string said = text.str();
      const std::size_t at = said.find("http://127.0.0.1:");
      if (at == std::string::npos || said.back() != '\n') return false;
      port_ = std::atoi(said.c_str() + at + 17);
      return true;
    });
    // Until it has read the state for the first time.
    run_.Await([&] { return serve::StatusOf(Get("/watch.json")) != 503; });
  }
  int port() const { return port_; }
  std::string Get(const std::string& path) const {
    return serve::Ask(port_, serve::Get(path));
  }
  int Stop(int signal) {
    run_.Send(signal);
    return run_.ExitCode();
  }

 private:
  StartedCommand run_;
  int port_ = 0;
};

}  // namespace mle

#endif  // TESTS_APPS_SERVED_WATCH_H_
