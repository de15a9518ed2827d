#include "tests/mle/database/postgresql_server.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "gtest/gtest.h"

namespace mle {
namespace {

namespace fs = std::filesystem;

// The folder of the server's programs; empty: not installed.
std::string Programs() {
  std::error_code error;
  std::string newest;
  for (const auto& version :
       fs::directory_iterator("/usr/lib/postgresql", error)) {
    const std::string folder = version.path().string() + "/bin/";
    if (fs::exists(folder + "initdb") && folder > newest) newest = folder;
  }
  return newest;
}

// The server refuses to run as root.
std::string AsServer(const std::string& command) {
  if (geteuid() != 0) return command;
  return "setpriv --reuid=postgres --regid=postgres --clear-groups " + command;
}

bool Shell(const std::string& command) {
  const int code = std::system(command.c_str());
  EXPECT_EQ(code, 0) << command;
  return code == 0;
}

}  // namespace

// The server of the process, which its tests use one after the other: it takes
// seconds to set one up.
class PostgresqlServer::Shared {
 public:
  Shared() {
    if (geteuid() == 0) Shell("chown postgres:postgres " + folder());
    fs::permissions(folder(), fs::perms::all);
    if (!Shell("cd " + folder() + " && " +
               AsServer(Programs() + "initdb -D " + folder() +
                        "/data -U postgres --auth=trust --no-sync -E UTF8 "
                        "--locale=C.UTF-8 >" +
                        folder() + "/initdb.log 2>&1"))) {
      return;
    }
    scratch_.Write("data/pg_hba.conf",
                   "local all reader scram-sha-256\nlocal all all trust\n");
    scratch_.Write("data/postgresql.auto.conf",
                   "listen_addresses = ''\nunix_socket_directories = '" +
                       folder() +
                       "'\nfsync = off\ntimezone = 'America/New_York'\n"
                       "datestyle = 'SQL, DMY'\n");
  }
  ~Shared() { Kill(); }

  const std::string& folder() const { return scratch_.path(); }
  const ScratchFolder& scratch() const { return scratch_; }

  bool Start() {
    if (is_running_) return true;
    is_running_ = Control("-l " + folder() + "/server.log -w start");
    return is_running_;
  }
  void Kill() {
    if (is_running_) Control("-m immediate stop");
    is_running_ = false;
  }

 private:
  bool Control(const std::string& what) const {
    return Shell("cd " + folder() + " && " +
                 AsServer(Programs() + "pg_ctl -D " + folder() + "/data " +
                          what + " >/dev/null 2>&1"));
  }

  const ScratchFolder scratch_;
  bool is_running_ = false;
};

PostgresqlServer::Shared& PostgresqlServer::Process() {
  static Shared shared;
  return shared;
}

bool PostgresqlServer::IsInstalled() { return !Programs().empty(); }

PostgresqlServer::PostgresqlServer()
    : scratch_(Process().scratch()), folder_(scratch_.path()) {
  is_running_ = Process().Start();
  if (!is_running_) return;
  // Nothing of an earlier test is left.
  const std::string script = scratch_.Write(
      "begin.sql",
      "DROP DATABASE IF EXISTS plant WITH (FORCE);\n"
      "SELECT format('DROP ROLE %I', rolname) FROM pg_roles "
      "WHERE rolname !~ '^(pg_|postgres$)' \\gexec\n"
      "CREATE DATABASE plant;\n"
      "CREATE ROLE open LOGIN IN ROLE pg_read_all_data;\n"
      "CREATE ROLE reader LOGIN IN ROLE pg_read_all_data PASSWORD '" +
          std::string(kPassword) + "';\n");
  Shell("psql -q -v ON_ERROR_STOP=1 -h " + folder_ + " -U postgres -f " +
        script + " >/dev/null 2>&1");
}

void PostgresqlServer::Kill() {
  if (is_running_) Process().Kill();
  is_running_ = false;
}

std::string PostgresqlServer::name(const std::string& role) const {
  return "postgresql://" + role + "@/plant?host=" + folder_;
}

void PostgresqlServer::Run(const std::string& sql) const {
  const std::string path = scratch_.Write("run.sql", sql);
  Shell("psql -q -v ON_ERROR_STOP=1 -h " + folder_ +
        " -U postgres -d plant -f " + path + " >/dev/null");
}

std::string PostgresqlServer::Value(const std::string& query) const {
  const std::string path = scratch_.Write("value.sql", query);
  std::string value;
  FILE* const pipe = popen(
      ("psql -qAt -h " + folder_ + " -U postgres -d plant -f " + path).c_str(),
      "r");
  if (pipe == nullptr) return value;
  for (int c = std::fgetc(pipe); c != EOF && c != '\n'; c = std::fgetc(pipe)) {
    value += static_cast<char>(c);
  }
  pclose(pipe);
  return value;
}

}  // namespace mle
