#include "apps/serve/post.h"

#include <curl/curl.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "apps/serve/server.h"

namespace mle::serve {
namespace {

constexpr long kStallSeconds = 10;  // of a connection, or without a byte
constexpr std::size_t kMostAnswer = 65'536;  // bytes of head and body

// The part of an answer that has come.
struct Answer {
  std::size_t bytes = 0;
  bool has_head = false;  // a whole one
};

std::size_t Count(Answer& answer, std::size_t bytes) {
  answer.bytes += bytes;
  return answer.bytes <= kMostAnswer ? bytes : 0;  // 0 ends it
}

std::size_t TakeLine(char* line, std::size_t /*one*/, std::size_t bytes,
                     void* answer) {
  auto& taken = *static_cast<Answer*>(answer);
  taken.has_head = absl::string_view(line, bytes) == "\r\n";
  return Count(taken, bytes);
}

std::size_t TakeBody(char* /*body*/, std::size_t /*one*/, std::size_t bytes,
                     void* answer) {
  return Count(*static_cast<Answer*>(answer), bytes);
}

bool IsHost(absl::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) {
    return absl::ascii_isalnum(static_cast<unsigned char>(c)) || c == '.' ||
           c == '-' || c == '_';
  });
}

bool IsUrl(const std::string& url) {
  const std::size_t scheme = absl::StartsWith(url, "http://")    ? 7
                             : absl::StartsWith(url, "https://") ? 8
                                                                 : 0;
  const bool is_visible = std::all_of(
      url.begin(), url.end(), [](char c) { return c > ' ' && c < '\x7f'; });
  const std::size_t slash = std::min(url.find('/', scheme), url.size());
  const std::string authority = url.substr(scheme, slash - scheme);
  const std::size_t colon = authority.find(':');
  int port = 1;
  return scheme != 0 && is_visible && IsHost(authority.substr(0, colon)) &&
         (colon == std::string::npos ||
          (absl::SimpleAtoi(authority.substr(colon + 1), &port) && port > 0 &&
           port <= kMostPort));
}

absl::Status StatusOf(CURL* curl, CURLcode code, const Answer& answer) {
  long status = 0;
  long sent = 0;
  curl_easy_getinfo(curl, CURLINFO_RESPONSE_CODE, &status);
  curl_easy_getinfo(curl, CURLINFO_REQUEST_SIZE, &sent);
  // The status alone decides: the rest of the answer need not arrive.
  if (code == CURLE_OK || (answer.has_head && status >= 200)) {
    return status >= 200 && status < 300
               ? absl::OkStatus()
               : absl::UnavailableError(
                     absl::StrCat("it answered with status ", status));
  }
  if (code == CURLE_PEER_FAILED_VERIFICATION) {
    return absl::UnavailableError(
        "its certificate is of another name, or not one that the system "
        "believes (the environment variable SSL_CERT_FILE names others)");
  }
  const char* const word = code == CURLE_OUT_OF_MEMORY
                               ? "a line of its head is too long"
                               : curl_easy_strerror(code);
  // The request may have arrived.
  return sent > 0 ? absl::DeadlineExceededError(
                        absl::StrCat("no answer came: ", word))
                  : absl::UnavailableError(
                        absl::StrCat("it could not be reached: ", word));
}

}  // namespace

absl::Status CheckUrl(const std::string& url) {
  if (IsUrl(url)) return absl::OkStatus();
  return absl::InvalidArgumentError(
      "is not an address as https://host.example:8443/path");
}

absl::Status PostJson(const std::string& url, const std::string& text,
                      const std::string& id, std::chrono::milliseconds time) {
  if (!IsUrl(url)) return CheckUrl(url);
  static const CURLcode kReady = curl_global_init(CURL_GLOBAL_DEFAULT);
  const std::unique_ptr<CURL, decltype(&curl_easy_cleanup)> owned(
      kReady == CURLE_OK ? curl_easy_init() : nullptr, &curl_easy_cleanup);
  CURL* const curl = owned.get();
  if (curl == nullptr) return absl::InternalError("libcurl does not start");
  curl_slist* lines = nullptr;
  for (const std::string& line : {std::string("Content-Type: application/json"),
                                  absl::StrCat("Idempotency-Key: ", id)}) {
    lines = curl_slist_append(lines, line.c_str());
  }
  const std::unique_ptr<curl_slist, decltype(&curl_slist_free_all)> headers(
      lines, &curl_slist_free_all);
  Answer answer;
  curl_easy_setopt(curl, CURLOPT_URL, url.c_str());
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_PROXY, "");
  curl_easy_setopt(curl, CURLOPT_HTTP_VERSION, CURL_HTTP_VERSION_1_1);
  curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_USERAGENT, "mle_watch");
  curl_easy_setopt(curl, CURLOPT_HTTPHEADER, lines);
  curl_easy_setopt(curl, CURLOPT_POSTFIELDS, text.c_str());
  curl_easy_setopt(curl, CURLOPT_POSTFIELDSIZE_LARGE,
                   static_cast<curl_off_t>(text.size()));
  curl_easy_setopt(curl, CURLOPT_TIMEOUT_MS, static_cast<long>(time.count()));
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, kStallSeconds);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, kStallSeconds);
  curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, &TakeLine);
  curl_easy_setopt(curl, CURLOPT_HEADERDATA, &answer);
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, &TakeBody);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &answer);
  if (const char* const believed = std::getenv("SSL_CERT_FILE")) {
    curl_easy_setopt(curl, CURLOPT_CAINFO, believed);
  }
  return StatusOf(curl, curl_easy_perform(curl), answer);
}

}  // namespace mle::serve
