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

bool PostgresqlServer::IsInstalled() { return !Programs().empty(); }

PostgresqlServer::PostgresqlServer() {
  if (geteuid() == 0) Shell("chown postgres:postgres " + folder_);
  fs::permissions(folder_, fs::perms::all);
  const std::string data = folder_ + "/data";
  if (!Shell("cd " + folder_ + " && " +
             AsServer(Programs() + "initdb -D " + data +
                      " -U postgres --auth=trust --no-sync -E UTF8 "
                      "--locale=C.UTF-8 >" +
                      folder_ + "/initdb.log 2>&1"))) {
    return;
  }
  scratch_.Write("data/pg_hba.conf",
                 "local all reader scram-sha-256\nlocal all all trust\n");
  scratch_.Write("data/postgresql.auto.conf",
                 "listen_addresses = ''\nunix_socket_directories = '" +
                     folder_ +
                     "'\nfsync = off\ntimezone = 'America/New_York'\n"
                     "datestyle = 'SQL, DMY'\n");
  is_running_ =
      Shell("cd " + folder_ + " && " +
            AsServer(Programs() + "pg_ctl -D " + data + " -l " + folder_ +
                     "/server.log -w start >/dev/null 2>&1"));
  if (!is_running_) return;
  Shell("psql -q -h " + folder_ + " -U postgres -c 'CREATE DATABASE plant'");
  Run("CREATE ROLE open LOGIN IN ROLE pg_read_all_data;"
      "CREATE ROLE reader LOGIN IN ROLE pg_read_all_data PASSWORD '" +
      std::string(kPassword) + "';");
}

PostgresqlServer::~PostgresqlServer() { Kill(); }

void PostgresqlServer::Kill() {
  if (!is_running_) return;
  is_running_ = false;
  Shell("cd " + folder_ + " && " +
        AsServer(Programs() + "pg_ctl -D " + folder_ +
                 "/data -m immediate stop >/dev/null 2>&1"));
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
