#include "apps/watch/correction_files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_split.h"
#include "mle/base/absl_view.h"

namespace mle::watch {
namespace {

constexpr std::size_t kMostParts = 5;

bool IsName(std::string_view part) {
  return !part.empty() && part[0] != '.' &&
         std::all_of(part.begin(), part.end(), [](char c) {
           return absl::ascii_isalnum(static_cast<unsigned char>(c)) ||
                  c == '.' || c == '_' || c == '-';
         });
}

std::string TypeOf(const std::string& name) {
  constexpr std::pair<const char*, const char*> kTypes[] = {
      {".html", "text/html; charset=utf-8"},
      {".json", "application/json"},
      {".csv", "text/csv; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".pdf", "application/pdf"},
      {".txt", "text/plain; charset=utf-8"}};
  for (const auto& [end, type] : kTypes) {
    if (absl::EndsWith(name, end)) return type;
  }
  return "application/octet-stream";
}

// −1 where one of the parts is not what it should be.
int OpenBelow(const std::string& folder,
              const std::vector<std::string>& parts) {
  int at = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  for (std::size_t i = 0; i < parts.size() && at >= 0; ++i) {
    const int kind = i + 1 < parts.size() ? O_DIRECTORY : O_NONBLOCK;
    const int next =
        openat(at, parts[i].c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | kind);
    close(at);
    at = next;
  }
  return at;
}

}  // namespace

absl::StatusOr<serve::Response> FileBelow(const std::string& folder,
                                          std::string_view path) {
  const std::vector<std::string> parts = absl::StrSplit(AbslView(path), '/');
  if (parts.size() > kMostParts ||
      !std::all_of(parts.begin(), parts.end(), IsName)) {
    return absl::NotFoundError("no such file");
  }
  const std::shared_ptr<const int> file(new int(OpenBelow(folder, parts)),
                                        [](const int* descriptor) {
                                          if (*descriptor >= 0)
                                            close(*descriptor);
                                          delete descriptor;
                                        });
  struct stat about = {};
  if (*file < 0 || fstat(*file, &about) != 0 || !S_ISREG(about.st_mode)) {
    return absl::NotFoundError("no such file");
  }
  return serve::Response{.content_type = TypeOf(parts.back()),
                         .file = file,
                         .file_bytes = static_cast<std::size_t>(about.st_size)};
}

}  // namespace mle::watch
